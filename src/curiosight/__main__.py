"""Run `python -m curiosight`."""

from curiosight.cli import main

main()
