"""Refuse arguments that cannot be meant, in the words of all `ValueError`s here."""

from __future__ import annotations

from typing import Any

import numpy as np


def check_whole(name: str, value: Any, low: int, high: int) -> None:
    """Raise `ValueError` unless it is a whole number from `low` to `high`; True is none."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise ValueError(f"{name}: expected a whole number, got {shown(value)}")
    if not low <= value <= high:
        expected = f"{low} or more" if value < low else f"{low} to {high}"
        raise ValueError(f"{name}: expected {expected}, got {shown(value)}")


def check_share(name: str, value: Any) -> None:
    """Raise `ValueError` unless it is a number from 0 to below 1."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1:
        raise ValueError(f"{name}: expected 0 to below 1, got {shown(value)}")


def check_switch(name: str, value: Any) -> None:
    """Raise `ValueError` unless it is True or False."""
    if not isinstance(value, bool):
        raise ValueError(f"{name}: expected True or False, got {shown(value)}")


def shown(value: Any) -> str:
    """Return a value for a line of text, short whatever it is."""
    try:
        text = repr(value)
    except ValueError:  # of a number that Python does not write in tens
        text = f"{value:#x}"
    return text if len(text) <= 60 else f"{text[:59]}…"
