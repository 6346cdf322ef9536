"""The live page of a command, there before anything else is; or none, where nobody asked for it."""

from __future__ import annotations

from typing import Self

from curiosight.robot.page import HOST, Page, open_page
from curiosight.robot.state import Preparing, Subject


class LivePage:
    """A page that says what is being prepared, and then shows it.

    port: None = no page; 0 = any that is free. Raises ValueError for one that cannot be had.
    Use as a context manager.
    """

    def __init__(self, port: int | None, host: str = HOST) -> None:
        self._preparing = Preparing("starting")
        self._page: Page | None = None if port is None else open_page(self._preparing, port, host)

    @property
    def url(self) -> str | None:
        return None if self._page is None else self._page.url

    def say(self, note: str) -> None:
        """Say what is under way."""
        self._preparing.note = note

    def show(self, subject: Subject) -> None:
        """Show that from now on."""
        if self._page is not None:
            self._page.show(subject)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._page is not None:
            self._page.close()
