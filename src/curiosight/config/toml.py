"""Settings as TOML, and back: a key or a value that there is not is refused at every depth."""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from curiosight.config.settings import Config
from curiosight.errors import DataError
from curiosight.errors.arguments import shown
from curiosight.errors.inputs import read_text

MAX_BYTES = 2**20
MOST_64_BITS = 2**63 - 1


def to_toml(config: Config) -> str:
    """Write a config as TOML that `load_config` reads back to the same."""
    lines = [f"preset = {toml_value(config.preset)}"]
    for section in fields(config):
        if section.name != "preset":
            lines += _toml_section(section.name, getattr(config, section.name))
    return "\n".join(lines) + "\n"


def read_toml(path: Path) -> dict[str, Any]:
    """Return the table of a TOML file; `DataError` where it is none."""
    try:
        return tomllib.loads(read_text(path, max_bytes=MAX_BYTES))
    except OSError as error:
        raise DataError(path, f"cannot be read ({error.strerror})", "check the path") from error
    except RecursionError:
        raise DataError(path, "is nested too deeply", "write sections and values") from None
    except ValueError as error:
        raise DataError(path, f"is no TOML ({error})", "mend that line") from error


def updated(section: Any, table: Mapping[str, Any], path: Path, prefix: str) -> Any:
    """Return a dataclass with the table's values, checked key by key at every depth."""
    types = get_type_hints(type(section))
    changes: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{prefix}{key}"
        if key not in types:
            nearest = difflib.get_close_matches(key, types, n=1, cutoff=0)
            raise DataError(path, f"unknown key `{name}`", f"did you mean `{prefix}{nearest[0]}`?")
        present = getattr(section, key)
        if is_dataclass(present):
            if not isinstance(value, Mapping):
                raise DataError(path, f"`{name}` is {shown(value)}", f"write a section [{name}]")
            changes[key] = updated(present, value, path, name + ".")
        else:
            changes[key] = checked(value, types[key], path, name)
    try:
        return replace(section, **changes)
    except ValueError as error:
        raise DataError(path, f"[{prefix.rstrip('.')}] {error}", "mend that value") from error


def checked(value: Any, kind: Any, path: Path, name: str) -> Any:
    """Return a TOML value as a field's type, or say what was expected."""
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            expected = ", ".join(repr(choice) for choice in get_args(kind))
            raise DataError(path, f"`{name}` is {shown(value)}", f"use one of {expected}")
        return value
    if type(value) is int and abs(value) > MOST_64_BITS:
        raise DataError(path, f"`{name}` is {shown(value)}", "expected a number of 64 bits")
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    # A bool is an int to Python; here it is none.
    if not isinstance(value, kind) or isinstance(value, bool) != (kind is bool):
        raise DataError(path, f"`{name}` is {shown(value)}", f"expected {kind.__name__}")
    return value


def _toml_section(name: str, section: Any) -> list[str]:
    """Write a section, then those inside it."""
    lines, inner = ["", f"[{name}]"], []
    for entry in fields(section):
        value = getattr(section, entry.name)
        if is_dataclass(value):
            inner += _toml_section(f"{name}.{entry.name}", value)
        else:
            lines.append(f"{entry.name} = {toml_value(value)}")
    return lines + inner


def toml_value(value: str | int | float | Sequence[str]) -> str:
    """Write a scalar or a list of texts."""
    # JSON writes text and truth as TOML does, but for the character DEL.
    if isinstance(value, bool):
        return json.dumps(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Sequence):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(value)
