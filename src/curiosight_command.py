"""The command `curiosight`, outside the package so that Ctrl-C during its imports is answered."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

# Read when NumPy is imported. Our products are small: shared out, they wait for a core that others
# hold, and one of .02 ms takes 9.
BLAS_THREADS = "OPENBLAS_NUM_THREADS"


def main() -> None:
    """Run the command line and exit with its status."""
    os.environ.setdefault(BLAS_THREADS, "1")
    try:
        from curiosight.cli import main as run

        run()
    except KeyboardInterrupt:
        with suppress(OSError):  # standard error may be full or closed
            sys.stderr and print("curiosight: interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
