"""The live page: a small server on this machine, of files that lie beside it."""

from curiosight.robot.page.server import HOST, Page, open_page

__all__ = ["HOST", "Page", "open_page"]
