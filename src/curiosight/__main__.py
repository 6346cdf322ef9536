"""Run `python -m curiosight`."""

from curiosight.cli import main

if __name__ == "__main__":  # not in a process that `compare` starts
    main()
