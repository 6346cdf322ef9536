"""Grey-scale reconstruction, and the smoothing of saliency maps that is built of it.

L. Vincent, "Morphological grayscale reconstruction in image analysis", IEEE TIP 1993: the fast
hybrid algorithm.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Array = npt.NDArray[Any]
Grey = npt.NDArray[np.uint8]


def reconstruct(marker: Grey, mask: Grey, *, n_neighbours: int) -> Grey:
    """Return the (H, W) marker dilated again and again by 4 or 8 neighbours, under the mask."""
    low, high = (
        cv2.copyMakeBorder(image, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
        for image in (np.minimum(marker, mask), mask)
    )
    stride = low.shape[1]
    before = [-1, -stride] if n_neighbours == 4 else [-1, -stride, -stride - 1, 1 - stride]
    _grow(low, high, np.array(before))
    inner: Grey = low[1:-1, 1:-1]
    return inner


def open_and_close_by_reconstruction(grey: Grey, element: Grey, *, n_neighbours: int) -> Grey:
    """Take away what is smaller than the element, first bright, then dark; edges stay."""
    opened = reconstruct(cv2.erode(grey, element), grey, n_neighbours=n_neighbours)
    dark = 255 - cv2.dilate(opened, element)
    closed: Grey = 255 - reconstruct(dark, 255 - opened, n_neighbours=n_neighbours)
    return closed


@njit(cache=True, nogil=True)
def _grow(marker: Array, mask: Array, before: Array) -> None:
    """Reconstruct a marker in place; both have a frame of 0.

    before: offsets of the neighbours that come before a pixel in reading order.
    """
    height, width = marker.shape
    low, high = marker.ravel(), mask.ravel()
    stack = np.empty(low.size, np.int32)
    waits = np.zeros(low.size, np.bool_)
    n_waiting = 0
    for v in range(1, height - 1):
        for pixel in range(v * width + 1, v * width + width - 1):
            for offset in before:
                low[pixel] = max(low[pixel], min(low[pixel + offset], high[pixel]))
    for v in range(height - 2, 0, -1):
        for pixel in range(v * width + width - 2, v * width, -1):
            for offset in before:
                low[pixel] = max(low[pixel], min(low[pixel - offset], high[pixel]))
            for offset in before:
                after = pixel - offset
                if low[after] < low[pixel] and low[after] < high[after] and not waits[pixel]:
                    waits[pixel] = True
                    stack[n_waiting] = pixel
                    n_waiting += 1
    while n_waiting > 0:
        n_waiting -= 1
        pixel = stack[n_waiting]
        waits[pixel] = False
        for sign in (-1, 1):
            for offset in before:
                neighbour = pixel + sign * offset
                here = min(low[pixel], high[neighbour])
                if low[neighbour] < here:
                    low[neighbour] = here
                    if not waits[neighbour]:
                        waits[neighbour] = True
                        stack[n_waiting] = neighbour
                        n_waiting += 1
