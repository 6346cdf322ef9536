"""Write ONNX files of a single step, byte by byte: https://onnx.ai/onnx/repo-docs/IR.html.

What the format calls a message is here what `_text` makes of the bytes of its fields.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

FLOAT, FLOAT16 = 1, 10
Shape = Sequence[int | str]


def write_network(
    path: Path,
    weights: Sequence[float] = (1, 0, 0),
    shape: Shape = (1, 3, 8, 8),
) -> Path:
    """Write a network whose only map is the weighted sum of the image's channels."""
    dims = b"".join(_number(1, length) for length in (1, len(weights), 1, 1))
    values = np.array(weights, "<f4").tobytes()
    tensor = dims + _number(2, FLOAT) + _text(8, "weights") + _text(9, values)
    step = _text(1, "image") + _text(1, "weights") + _text(2, "map") + _text(4, "Conv")
    inputs = [_value("image", shape, FLOAT)]
    return _write(path, step, inputs, _value("map", (1, 1, "h", "w"), FLOAT), _text(5, tensor))


def write_echo(path: Path, shape: Shape, *, kind: int = FLOAT, n_inputs: int = 1) -> Path:
    """Write a network that returns the first of its inputs, which all have one shape."""
    step = _text(1, "input0") + _text(2, "echo") + _text(4, "Identity")
    inputs = [_value(f"input{index}", shape, kind) for index in range(n_inputs)]
    return _write(path, step, inputs, _value("echo", shape, kind))


def _write(
    path: Path, step: bytes, inputs: list[bytes], output: bytes, initialisers: bytes = b""
) -> Path:
    graph = _text(1, step) + _text(2, "graph") + initialisers
    graph += b"".join(_text(11, value) for value in inputs) + _text(12, output)
    ir_version, operators = _number(1, 8), _text(8, _number(2, 13))
    path.write_bytes(ir_version + _text(7, graph) + operators)
    return path


def _value(name: str, shape: Shape, kind: int) -> bytes:
    """Return the name, kind and shape of an input or output; words are lengths left open."""
    dims = [_number(1, side) if isinstance(side, int) else _text(2, side) for side in shape]
    lengths = b"".join(_text(1, dim) for dim in dims)
    return _text(1, name) + _text(2, _text(1, _number(1, kind) + _text(2, lengths)))


def _number(field: int, value: int) -> bytes:
    return _variable_length(field << 3) + _variable_length(value)


def _text(field: int, content: bytes | str) -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return _variable_length(field << 3 | 2) + _variable_length(len(raw)) + raw


def _variable_length(value: int) -> bytes:
    """Return seven bits a byte, the lowest first; all but the last have their top bit set."""
    last = bytes([value & 0x7F | (0x80 if value > 0x7F else 0)])
    return last + _variable_length(value >> 7) if value > 0x7F else last
