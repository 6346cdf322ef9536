"""Features of any network in an ONNX file, averaged over superpixels (extra `curiosight[onnx]`)."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.errors.inputs import read_bytes
from curiosight.frame import Rgb
from curiosight.learner.features.colour import Rows
from curiosight.learner.features.feature_set import FeatureSet, mean_of_pixels, to_bytes
from curiosight.learner.features.superpixels import Superpixels

Maps = npt.NDArray[np.float32]

MEAN = np.array([0.485, 0.456, 0.406], np.float32)
DEVIATION = np.array([0.229, 0.224, 0.225], np.float32)
# Values are told apart up to this far from 0, finer near it: 255 steps of their arsinh.
FARTHEST = 100.0
MAX_MAPS = 2048
MAX_BYTES = 2**31
ANOTHER = "give the ONNX file of a network from an image (1, 3, h, w) to maps (1, k, h', w')"


class Network:
    """Dense features of a network: called with an image, it returns its maps.

    path: a network from one float32 image (1, 3, h, w), red first, prepared as for ImageNet.
    content: of that file.
    tensor: what counts of all that the network computes on its way, by its name in the file;
        "" = of its outputs that are maps the one with most of them.

    Runs on one thread. Raises `DataError` where the file is no such network, or where
    onnxruntime is not installed.
    """

    def __init__(self, path: Path, content: bytes, tensor: str = "") -> None:
        self.path = path
        self._session = _open(path, content + (_output(tensor) if tensor else b""))
        inputs = self._session.get_inputs()
        shape = tuple(inputs[0].shape) if len(inputs) == 1 else ()
        if len(shape) != 4 or inputs[0].type != "tensor(float)" or not _fits(shape[1], 3):
            found = [(node.type, node.shape) for node in inputs]
            raise DataError(path, f"takes {found} instead of one float image", ANOTHER)
        self._input = inputs[0].name
        self._sides = tuple(side if isinstance(side, int) else None for side in shape[2:])
        self._output, self.n_maps = self._find_output(tensor)

    def __call__(self, rgb: Rgb) -> Maps:
        """Return the (k, h', w') maps of an (h, w, 3) uint8 RGB image."""
        height, width = (fixed or own for fixed, own in zip(self._sides, rgb.shape, strict=False))
        resized = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_LINEAR)
        image = (resized.astype(np.float32) / 255 - MEAN) / DEVIATION
        return self._run(np.ascontiguousarray(image.transpose(2, 0, 1)), [self._output])[0]

    def _find_output(self, tensor: str) -> tuple[str, int]:
        """Return the name and number of maps of the output that counts, by trying the network."""
        names = [tensor] if tensor else [node.name for node in self._session.get_outputs()]
        height, width = (side or 320 for side in self._sides)
        found = self._run(np.zeros((3, height, width), np.float32), names)
        sizes = [len(maps) if maps.ndim == 3 and maps.size else 0 for maps in found]
        if not 0 < max(sizes) <= MAX_MAPS:
            shapes = [maps.shape for maps in found]
            raise DataError(self.path, f"its outputs {shapes} are no 1 to {MAX_MAPS} maps", ANOTHER)
        return names[int(np.argmax(sizes))], max(sizes)

    def _run(self, image: Maps, names: list[str]) -> list[Maps]:
        try:
            outputs = self._session.run(names, {self._input: image[None]})
        except Exception as error:  # onnxruntime's own have no other base class
            found = f"cannot work on an image of {image.shape[1:]} ({error})"
            raise DataError(self.path, found, "give another network") from error
        return [np.asarray(output, np.float32)[0] for output in outputs]


def network(place: str) -> FeatureSet:
    """Return the set `onnx:FILE` or `onnx:FILE#TENSOR`: its maps, averaged over superpixels.

    place: what follows `onnx:`, see `Network`.
    """
    name, _, tensor = (place, "", "") if Path(place).exists() else place.partition("#")
    path = Path(name).absolute()
    try:
        content = read_bytes(path, MAX_BYTES)
    except OSError as error:
        found = f"cannot be read ({error.strerror or error})"
        raise DataError(path, found, ANOTHER) from error
    digest = hashlib.sha256(content).hexdigest()
    maps_of = Network(path, content, tensor)

    def describe(image: Rgb, superpixels: Superpixels) -> Rows:
        maps, (height, width) = maps_of(image), superpixels.shape
        enlarged = [cv2.resize(one, (width, height)) for one in maps]
        values = np.nan_to_num(mean_of_pixels(enlarged, superpixels))
        farthest = np.arcsinh(FARTHEST)
        return to_bytes(np.arcsinh(values), -farthest, farthest)

    columns = tuple(f"map {index}" for index in range(maps_of.n_maps))
    set_name = f"onnx:{path}#{tensor}" if tensor else f"onnx:{path}"
    return FeatureSet(set_name, columns, describe, digest=digest)


def _open(path: Path, content: bytes) -> Any:
    """Return the onnxruntime session of a file's content."""
    try:
        import onnxruntime
    except ImportError as error:
        found, remedy = "needs onnxruntime, which is missing", "pip install 'curiosight[onnx]'"
        raise DataError(path, found, remedy) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4  # errors are raised; printing them too is not for a library
    providers = ["CPUExecutionProvider"]
    try:
        return onnxruntime.InferenceSession(content, options, providers=providers)
    except Exception as error:  # onnxruntime's own have no other base class
        raise DataError(path, f"cannot be read as a network ({error})", ANOTHER) from error


def _output(tensor: str) -> bytes:
    """Return what makes a tensor an output of a network, where it follows the file's content.

    Messages of Protocol Buffers that follow each other are merged: here a model (7: graph) whose
    graph (12: output) has one value more (1: name).
    """
    message = tensor.encode()
    for field in (1, 12, 7):
        message = _number(field << 3 | 2) + _number(len(message)) + message
    return message


def _number(value: int) -> bytes:
    """Return seven bits a byte, the lowest first; all but the last have their top bit set."""
    last = bytes([value & 0x7F | (0x80 if value > 0x7F else 0)])
    return last + _number(value >> 7) if value > 0x7F else last


def _fits(side: int | str | None, expected: int) -> bool:
    """Tell whether a dimension is so long, or left open."""
    return side == expected or not isinstance(side, int)
