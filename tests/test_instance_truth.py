"""Ground truth that tells one object from another, from recordings and drawn rooms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from curiosight.datasets import KnowsInstances, Osd, open_dataset
from curiosight.errors import DataError
from curiosight.rooms.truth import draw_instances
from curiosight.rooms.views import RoomViews
from recordings import annotation, truncate, write_folder, write_image, write_osd
from test_room_truth import BOWL, FLOOR, HUGE, MUG, NOTHING, ON_SHELF, PARTS, TABLE, TINY


def osd(path: Path) -> Osd:
    dataset = open_dataset(path)
    assert isinstance(dataset, Osd)
    return dataset


def test_osd_numbers_objects_as_annotated(tmp_path: Path) -> None:
    (view, *_) = write_osd(tmp_path)
    annotated = annotation(view)
    expected = np.select([annotated == 0, annotated == 1], [-1, 0], annotated.astype(int))
    instances = osd(tmp_path).instance_truth(0)
    assert instances is not None
    np.testing.assert_array_equal(instances, expected)
    assert instances.dtype == np.int32
    assert len(np.unique(instances[instances > 0])) > 1


def test_original_osd_numbers_objects_from_1(tmp_path: Path) -> None:
    (view, *_) = write_osd(tmp_path, with_camera=False)
    np.testing.assert_array_equal(osd(tmp_path).instance_truth(0), annotation(view))


def test_masks_beside_annotated_images_leave_the_instances(tmp_path: Path) -> None:
    (view, *_) = write_osd(tmp_path)
    write_image(tmp_path / "ground_truth/learn0.png", view.ground_truth)
    np.testing.assert_array_equal(np.unique(osd(tmp_path).ground_truth(0)), [0, 255])
    assert osd(tmp_path).instance_truth(0) is not None


def test_masks_given_instead_tell_no_instances(tmp_path: Path) -> None:
    (view, *_) = write_osd(tmp_path / "osd")
    write_image(tmp_path / "masks/learn0.png", view.ground_truth)
    dataset = open_dataset(tmp_path / "osd", ground_truth=tmp_path / "masks")
    assert isinstance(dataset, KnowsInstances)
    assert dataset.instance_truth(0) is None


def test_frame_without_annotation_has_no_instances(tmp_path: Path) -> None:
    write_osd(tmp_path)
    (tmp_path / "annotation/learn1.png").unlink()
    assert osd(tmp_path).instance_truth(1) is None
    assert osd(tmp_path).instance_truth(2) is not None


def test_damaged_annotation_is_named(tmp_path: Path) -> None:
    write_osd(tmp_path)
    truncate(tmp_path / "annotation/learn1.png")
    with pytest.raises(DataError, match=r"learn1\.png is truncated"):
        osd(tmp_path).instance_truth(1)


def test_other_recordings_do_not_know_instances(tmp_path: Path) -> None:
    write_folder(tmp_path)
    assert not isinstance(open_dataset(tmp_path), KnowsInstances)


def test_room_numbers_salient_parts() -> None:
    ids = np.array([[NOTHING, FLOOR, TABLE, MUG, BOWL, ON_SHELF, TINY, HUGE]], np.int32)
    instances = draw_instances(ids, PARTS)
    np.testing.assert_array_equal(instances, [[-1, 0, 0, MUG, BOWL, -1, -1, -1]])
    assert instances.dtype == np.int32


def test_rooms_know_instances() -> None:
    assert issubclass(RoomViews, KnowsInstances)
