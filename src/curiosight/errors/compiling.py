"""Compile kernels, on machines too where Numba ends with an error: no place for its cache."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numba

NO_PLACE = (
    "Numba has no place for its cache, so every run compiles anew: "
    "set NUMBA_CACHE_DIR to a folder that can be written"
)
_is_said = False


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return Numba's decorator `njit`; without a place for a cache it compiles for this run only.

    options: Numba's own. Numba looks beside the source, in the user's cache folder and in
    NUMBA_CACHE_DIR. Where none of them can be written it raises, and whatever imports a kernel
    would end; a shared temporary folder is no way out, for others could put their code into it.
    """

    def compile_lazily(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(**options)(function)
        except RuntimeError as error:
            if not options.get("cache") or "no locator available" not in str(error):
                raise
        _say_once()
        return numba.njit(**{**options, "cache": False})(function)

    return compile_lazily


def _say_once() -> None:
    global _is_said
    if not _is_said:
        _is_said = True
        warnings.warn(NO_PLACE, RuntimeWarning, stacklevel=4)
