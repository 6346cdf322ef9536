"""Textures that repeat, and prints: size, seams, colours, chance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from curiosight.rooms import pictures, prints, textures
from curiosight.rooms.mesh import Texture
from curiosight.rooms.noise import mixed, noise, shaded

COLOUR = np.array((150, 110, 70), np.uint8)
COLOURS = [COLOUR, np.array((40, 90, 150), np.uint8), np.array((220, 210, 190), np.uint8)]

Draw = Callable[[np.random.Generator], Texture]

OF_ONE_COLOUR: dict[str, Draw] = {
    "wood": lambda rng: textures.wood(rng, COLOUR),
    "planks": lambda rng: textures.planks(rng, COLOUR),
    "fabric": lambda rng: textures.fabric(rng, COLOUR),
    "carpet": lambda rng: textures.carpet(rng, COLOUR),
    "plaster": lambda rng: textures.plaster(rng, COLOUR),
    "tiles": lambda rng: textures.tiles(rng, COLOUR),
    "stone": lambda rng: textures.stone(rng, COLOUR),
    "metal": lambda rng: textures.metal(rng, COLOUR),
    "speckled": lambda rng: textures.speckled(rng, COLOUR),
}
REPEATING: dict[str, Draw] = OF_ONE_COLOUR | {
    "wicker": lambda rng: textures.wicker(rng, COLOUR),
    "leaves": lambda rng: textures.leaves(rng, COLOUR),
    "soil": textures.soil,
    "wallpaper": lambda rng: textures.wallpaper(rng, COLOURS[:2]),
    "stripes": lambda rng: textures.stripes(rng, COLOURS),
    "checks": lambda rng: textures.checks(rng, COLOURS),
}
PRINTS: dict[str, Callable[[np.random.Generator, tuple[int, int]], Texture]] = {
    "label": prints.label,
    "book_cover": prints.book_cover,
    "book_spine": prints.book_spine,
    "page": prints.page,
    "screen": prints.screen,
    "rug": prints.rug,
    "picture": pictures.picture,
    "outdoors": pictures.outdoors,
}


@pytest.fixture(params=list(REPEATING.items()), ids=list(REPEATING))
def repeating(request: pytest.FixtureRequest) -> Draw:
    draw: Draw = request.param[1]
    return draw


@pytest.fixture(params=list(PRINTS.items()), ids=list(PRINTS))
def printed(request: pytest.FixtureRequest) -> Callable[..., Texture]:
    draw: Callable[..., Texture] = request.param[1]
    return draw


def test_texture_is_srgb_bytes(repeating: Draw) -> None:
    texture = repeating(np.random.default_rng(0))
    assert texture.dtype == np.uint8
    assert texture.ndim == 3
    assert texture.shape[2] == 3
    assert min(texture.shape[:2]) >= 64
    assert max(texture.shape[:2]) <= 512


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("seed", range(3))
def test_texture_repeats_without_a_seam(repeating: Draw, axis: int, seed: int) -> None:
    texture = repeating(np.random.default_rng(seed)).astype(float)
    steps = np.abs(texture - np.roll(texture, 1, axis)).mean((1 - axis, 2))
    at_seam, inside = steps[0], steps[1:]
    assert at_seam <= 1.2 * inside.max() + 1


def test_texture_comes_from_its_generator_alone(repeating: Draw) -> None:
    first, again, other = (repeating(np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert (first != other).any()


@pytest.mark.parametrize("draw", OF_ONE_COLOUR.values(), ids=OF_ONE_COLOUR.keys())
def test_texture_keeps_its_colour_and_has_some_structure(draw: Draw) -> None:
    texture = draw(np.random.default_rng(0)).astype(float)
    assert np.abs(texture.mean((0, 1)) - COLOUR).max() < 20
    assert texture.std((0, 1)).min() > 0.5


def test_plain_is_one_colour() -> None:
    assert (textures.plain(COLOUR) == COLOUR).all()


def test_more_tiles_have_more_mortar() -> None:
    few, many = (textures.tiles(np.random.default_rng(0), COLOUR, n) for n in (2, 8))
    colour = COLOUR.astype(float)
    assert np.abs(many.mean((0, 1)) - colour).sum() > np.abs(few.mean((0, 1)) - colour).sum()


def test_print_has_the_size_asked_for_and_contrast(printed: Callable[..., Texture]) -> None:
    image = printed(np.random.default_rng(3), (200, 150))
    assert image.shape == (200, 150, 3)
    assert image.dtype == np.uint8
    assert image.flags.c_contiguous
    assert image.std() > 12


def test_print_comes_from_its_generator_alone(printed: Callable[..., Texture]) -> None:
    first, again, other = (printed(np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert (first != other).any()


@pytest.mark.parametrize("draw", [prints.label, prints.book_cover, prints.page])
@pytest.mark.parametrize("shape", [(64, 64), (96, 384), (400, 100)])
def test_print_fills_any_shape(draw: Callable[..., Texture], shape: tuple[int, int]) -> None:
    for seed in range(10):
        assert draw(np.random.default_rng(seed), shape).shape == (*shape, 3)


def test_noise_is_normalised_wraps_and_is_smooth_as_asked() -> None:
    rough = noise(np.random.default_rng(0), (128, 96), 1.0)
    smooth = noise(np.random.default_rng(0), (128, 96), 8.0)
    for field in (rough, smooth):
        assert field.shape == (128, 96)
        assert field.mean() == pytest.approx(0, abs=1e-5)
        assert field.std() == pytest.approx(1, abs=1e-4)
        steps = np.abs(np.diff(field, axis=0, append=field[:1])).mean(1)
        assert steps[-1] < 2 * steps[:-1].mean()
    assert np.abs(np.diff(smooth, axis=0)).mean() < np.abs(np.diff(rough, axis=0)).mean() / 4


def test_noise_stretches_along_u() -> None:
    field = noise(np.random.default_rng(0), (128, 128), (1.0, 12.0))
    along_v, along_u = (np.abs(np.diff(field, axis=axis)).mean() for axis in (0, 1))
    assert along_u < along_v / 5


def test_shading_brightens_and_saturates() -> None:
    shaded_image = shaded((100, 200, 0), [[0.0, 0.5, -1.0]])
    assert shaded_image.tolist() == [[[100, 200, 0], [150, 255, 0], [0, 0, 0]]]


def test_mixing_goes_from_the_first_colour_to_the_second() -> None:
    colours = mixed([[-1.0, 0.0, 0.5, 2.0]], (0, 0, 100), (200, 0, 0))
    assert colours.tolist() == [[[0, 0, 100], [0, 0, 100], [100, 0, 50], [200, 0, 0]]]
