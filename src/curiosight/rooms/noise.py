"""Random patterns that repeat without a seam, and colours shaded by them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.rooms.mesh import Texture

Field = npt.NDArray[np.float32]


def noise(
    rng: np.random.Generator, shape: tuple[int, int], smooth: float | tuple[float, float]
) -> Field:
    """Return (h, w) Gaussian noise of mean 0 and deviation 1 that wraps at its edges.

    smooth: pixels of blur, along v and u where they differ.
    """
    smooth_v, smooth_u = smooth if isinstance(smooth, tuple) else (smooth, smooth)
    spectrum = np.fft.rfft2(rng.standard_normal(shape))
    fall_v = np.exp(-2 * (np.pi * smooth_v * np.fft.fftfreq(shape[0])) ** 2)
    fall_u = np.exp(-2 * (np.pi * smooth_u * np.fft.rfftfreq(shape[1])) ** 2)
    spectrum *= fall_v[:, None] * fall_u
    spectrum[0, 0] = 0
    field = np.fft.irfft2(spectrum, shape)
    return np.asarray(field / field.std(), np.float32)


def shaded(colour: npt.ArrayLike, shade: npt.ArrayLike) -> Texture:
    """Return (h, w, 3) sRGB: a colour, or an image of them, made (1 + shade) times as bright."""
    brightness = 1 + np.asarray(shade, np.float32)[..., None]
    shades = np.asarray(colour, np.float32) * brightness + 0.5
    return np.array(np.clip(shades, 0, 255), np.uint8, order="C")


def mixed(share: npt.ArrayLike, first: npt.ArrayLike, second: npt.ArrayLike) -> Field:
    """Return (h, w, 3) colours: the first where share is 0, the second where it is 1."""
    start = np.asarray(first, np.float32)
    part = np.clip(np.asarray(share, np.float32), 0, 1)[..., None]
    return start + part * (np.asarray(second, np.float32) - start)
