"""Write ONNX files byte by byte: messages of Protocol Buffers, as the format's definition has them.

A message is the bytes of its fields; the numbers of fields are those of onnx.proto.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

FLOAT, INT64 = 1, 7  # kinds of numbers in tensors
IR_VERSION = 8
_VARINT, _BYTES, _FIXED32 = 0, 2, 5
_KINDS = {"f": 1, "i": 2, "s": 3, "floats": 6, "ints": 7, "strings": 8}

Attribute = str | int | float | npt.NDArray[Any] | Sequence[str]
Dimension = int | str  # a word is a length left open


def node(
    kind: str,
    inputs: Sequence[str],
    output: str,
    attributes: Mapping[str, Attribute] | None = None,
    *,
    domain: str = "",
) -> bytes:
    """Return a step of a graph."""
    message = b"".join(_text(1, name) for name in inputs)
    message += _text(2, output) + _text(3, output) + _text(4, kind)
    for name, value in (attributes or {}).items():
        message += _text(5, _attribute(name, value))
    return message + _text(7, domain)


def constant(name: str, values: npt.NDArray[Any]) -> bytes:
    """Return a tensor of the graph that is always the same, float32 or int64."""
    kind = FLOAT if values.dtype == np.float32 else INT64
    dims = b"".join(_whole(1, length) for length in values.shape)
    content = values.astype(values.dtype.newbyteorder("<")).tobytes()
    return dims + _whole(2, kind) + _text(8, name) + _text(9, content)


def value(name: str, shape: Sequence[Dimension], said: str) -> bytes:
    """Return a float32 input or output of the graph, and what is said of it."""
    dims = [_whole(1, side) if isinstance(side, int) else _text(2, side) for side in shape]
    lengths = b"".join(_text(1, dim) for dim in dims)
    tensor = _whole(1, FLOAT) + _text(2, lengths)
    return _text(1, name) + _text(2, _text(1, tensor)) + _text(3, said)


def model(
    nodes: Sequence[bytes],
    constants: Sequence[bytes],
    inputs: Sequence[bytes],
    outputs: Sequence[bytes],
    *,
    operators: Mapping[str, int],
    producer: tuple[str, str],
    said: str,
    facts: Mapping[str, str],
) -> bytes:
    """Return a file. operators: version by domain. producer: name, version. facts: metadata."""
    graph = b"".join(_text(1, one) for one in nodes) + _text(2, "forest")
    for field, messages in ((5, constants), (11, inputs), (12, outputs)):
        graph += b"".join(_text(field, one) for one in messages)
    message = _whole(1, IR_VERSION) + _text(2, producer[0]) + _text(3, producer[1])
    message += _text(6, said) + _text(7, graph)
    for domain, version in operators.items():
        message += _text(8, _text(1, domain) + _whole(2, version))
    return message + b"".join(_text(14, _text(1, key) + _text(2, facts[key])) for key in facts)


def _attribute(name: str, value: Attribute) -> bytes:
    kind, content = _content(value)
    return _text(1, name) + content + _whole(20, _KINDS[kind])


def _content(value: Attribute) -> tuple[str, bytes]:
    if isinstance(value, str):
        return "s", _text(4, value)
    if isinstance(value, int):
        return "i", _whole(3, value)
    if isinstance(value, float):
        return "f", _head(2, _FIXED32) + np.array(value, "<f4").tobytes()
    if not isinstance(value, np.ndarray):
        return "strings", b"".join(_text(9, word) for word in value)
    if value.dtype.kind == "f":
        return "floats", _text(7, value.astype("<f4").tobytes())
    return "ints", _text(8, b"".join(_number(number) for number in value.tolist()))


def _head(field: int, wire: int) -> bytes:
    return _number(field << 3 | wire)


def _whole(field: int, number: int) -> bytes:
    return _head(field, _VARINT) + _number(number)


def _text(field: int, content: bytes | str) -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return _head(field, _BYTES) + _number(len(raw)) + raw


def _number(number: int) -> bytes:
    """Return a number from 0 by seven bits a byte, the lowest first; only the last below 128."""
    parts = bytearray()
    while number > 0x7F:
        parts.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*parts, number])
