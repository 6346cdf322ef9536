"""The live page: a small server on this machine, of files that lie beside it."""

from curiosight.robot.page.server import Page, open_page

__all__ = ["Page", "open_page"]
