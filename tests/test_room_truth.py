"""The truth of a drawn room's pixels."""

from __future__ import annotations

import numpy as np
import pytest

from curiosight.rooms.mesh import Material, Mesh
from curiosight.rooms.scene import Part, Role
from curiosight.rooms.truth import draw_truth, object_ids

PLAIN = Material(np.zeros((1, 1, 3), np.uint8))


def part(role: Role, size: float = 0.3) -> Part:
    """Return a part that is `size` metres across."""
    vertices = np.array([[0, 0, 0], [size, 0, 0], [size, 0, 0]], np.float32)
    up = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
    triangles, surface = np.array([[0, 1, 2]], np.int32), np.zeros(1, np.int32)
    return Part("part", role, Mesh(vertices, up, vertices[:, :2], triangles, surface, (PLAIN,)))


PARTS = (
    part(Role.STRUCTURE, 5.0),
    part(Role.SUPPORT),
    part(Role.OBJECT),
    part(Role.OBJECT),
    part(Role.UNDECIDED),
    part(Role.OBJECT, 0.07),
    part(Role.OBJECT, 1.6),
)
NOTHING, FLOOR, TABLE, MUG, BOWL, ON_SHELF, TINY, HUGE = range(len(PARTS) + 1)


@pytest.mark.parametrize(
    ("number", "grey"),
    [
        (NOTHING, 125),
        (FLOOR, 0),
        (TABLE, 0),
        (MUG, 255),
        (ON_SHELF, 125),
        (TINY, 125),
        (HUGE, 125),
    ],
)
def test_grey_of_a_part(number: int, grey: int) -> None:
    truth = draw_truth(np.full((4, 5), number, np.int32), PARTS)
    np.testing.assert_array_equal(truth, np.full((4, 5), grey, np.uint8))


def test_sizes_are_arguments() -> None:
    ids = np.full((1, 1), TINY, np.int32)
    assert draw_truth(ids, PARTS, min_size=0.05) == 255
    assert draw_truth(ids, PARTS, min_size=0.05, max_size=0.06) == 125


@pytest.mark.parametrize("outline_px", [1, 2, 3])
def test_outlines_between_salient_and_not_are_ignored(outline_px: int) -> None:
    ids = np.full((9, 20), FLOOR, np.int32)
    ids[:, 10:] = MUG
    row = draw_truth(ids, PARTS, outline_px=outline_px)[4]
    n_clear = 10 - outline_px
    expected = [0] * n_clear + [125] * 2 * outline_px + [255] * n_clear
    np.testing.assert_array_equal(row, expected)


@pytest.mark.parametrize(("left", "right"), [(MUG, BOWL), (FLOOR, TABLE)])
def test_other_outlines_are_kept(left: int, right: int) -> None:
    ids = np.full((9, 20), left, np.int32)
    ids[:, 10:] = right
    assert len(np.unique(draw_truth(ids, PARTS))) == 1


def test_outline_beside_ignored_pixels_is_kept() -> None:
    ids = np.full((9, 20), ON_SHELF, np.int32)
    ids[:, 10:] = MUG
    np.testing.assert_array_equal(draw_truth(ids, PARTS)[4], [125] * 10 + [255] * 10)


def test_object_ids_are_those_of_objects() -> None:
    ids = np.arange(len(PARTS) + 1, dtype=np.int32)[None]
    np.testing.assert_array_equal(object_ids(ids, PARTS), [[0, 0, 0, MUG, BOWL, 0, TINY, HUGE]])


@pytest.mark.parametrize("number", [-1, len(PARTS) + 1])
def test_unknown_ids_are_refused(number: int) -> None:
    with pytest.raises(ValueError, match=f"ids: expected 0 to 7.*{number}"):
        draw_truth(np.full((2, 2), number, np.int32), PARTS)
