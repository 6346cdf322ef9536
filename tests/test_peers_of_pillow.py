"""What the base install reads of pictures without Pillow is what Pillow reads."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from curiosight.datasets.headers import size_in_header
from curiosight.datasets.palette import read_indices
from curiosight.datasets.tiff_tags import tiff_tags

RNG = np.random.default_rng(0)


def saved(image: Image.Image, kind: str, **options: object) -> bytes:
    content = io.BytesIO()
    image.save(content, kind, **options)
    return content.getvalue()


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("PNG", {"bits": 1}),
        ("PNG", {"bits": 2}),
        ("PNG", {"bits": 4}),
        ("PNG", {"bits": 8, "transparency": 0}),
        ("BMP", {}),
        ("TIFF", {}),
        ("TIFF", {"compression": "tiff_lzw"}),
        ("TIFF", {"compression": "packbits", "big_endian": True}),
    ],
)
def test_numbers_of_a_palette(kind: str, options: dict[str, object]) -> None:
    n_colours = 2 ** int(options.get("bits", 8))
    numbers = RNG.integers(0, n_colours, (13, 21)).astype(np.uint8)
    image = Image.fromarray(numbers, "P")
    image.putpalette(RNG.permutation(256 * 3).astype(np.uint8)[: 3 * n_colours].tobytes())
    np.testing.assert_array_equal(read_indices(saved(image, kind, **options)), numbers)


@pytest.mark.parametrize("size", [(1, 1), (50, 30), (301, 7), (16000, 3)])
@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("BMP", {}),
        ("TIFF", {}),
        ("TIFF", {"compression": "tiff_lzw"}),
        ("WEBP", {"quality": 60}),
        ("WEBP", {"lossless": True}),
        ("WEBP", {"exif": b"Exif\0\0II*\0\x08\0\0\0\0\0"}),
        ("PPM", {}),
    ],
)
def test_size(kind: str, options: dict[str, object], size: tuple[int, int]) -> None:
    content = saved(Image.new("RGB", size, (1, 2, 3)), kind, **options)
    assert size_in_header(io.BytesIO(content)) == size
    for length in range(0, min(len(content), 64), 3):
        assert size_in_header(io.BytesIO(content[:length])) in (None, size)


def test_remarks_of_a_netpbm_picture_are_no_numbers() -> None:
    assert size_in_header(io.BytesIO(b"P5\n# 7 8 by a camera\n50 # wide\n30\n255\n")) == (50, 30)


def test_tiff_that_lies_about_its_tags_has_none() -> None:
    content = saved(Image.new("RGB", (50, 30)), "TIFF")
    for damaged in (content[:7], content[:4] + b"\xff\xff\xff\x7f", content[:12]):
        assert tiff_tags(io.BytesIO(damaged)) == {}
