"""The command `curiosight`, outside the package so that Ctrl-C during its imports is answered."""

from __future__ import annotations

import sys
from contextlib import suppress


def main() -> None:
    """Run the command line and exit with its status."""
    try:
        from curiosight.cli import main as run

        run()
    except KeyboardInterrupt:
        with suppress(OSError):  # standard error may be full or closed
            sys.stderr and print("curiosight: interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
