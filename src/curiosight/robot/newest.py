"""Hand over from thread to thread: the newest of what came, never a queue of old ones."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Newest(Generic[Item]):
    """A place for one thing: what comes replaces what was not taken yet."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._item: Item | None = None

    def put(self, item: Item) -> bool:
        """Put it there; tell whether another was replaced."""
        with self._changed:
            is_replaced = self._item is not None
            self._item = item
            self._changed.notify()
            return is_replaced

    def take(self, timeout_s: float) -> Item | None:
        """Wait for something and take it; None = nothing in time."""
        with self._changed:
            if self._item is None:
                self._changed.wait(timeout_s)
            item, self._item = self._item, None
            return item

    @property
    def is_empty(self) -> bool:
        return self._item is None
