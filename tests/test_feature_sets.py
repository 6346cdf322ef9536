"""Sets of features by name, and one's own: what a model says of them, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from curiosight.errors import DataError
from curiosight.learner.archive import read_archive, write_archive
from curiosight.learner.features import (
    SET_NAMES,
    Describer,
    FeatureSet,
    count_features,
    make_sets,
    mean_of_pixels,
    to_bytes,
)
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.model_file import KIND
from pictures import make_learner, noise_in_blocks, picture, taught
from scenes import photograph


def redness(image: np.ndarray, superpixels: np.ndarray) -> np.ndarray:
    """Describe a superpixel by how much redder than green it is."""
    colours = image.astype(float)
    means = mean_of_pixels([colours[..., 0] - colours[..., 1]], superpixels)
    return to_bytes(means, -255, 255)


RED = FeatureSet("redness", ("redder than green",), redness)


@pytest.mark.parametrize("name", SET_NAMES)
def test_a_set_has_the_columns_that_it_says(name: str) -> None:
    image, superpixels = noise_in_blocks(1)
    for colour_space in ("rgb", "lab"):
        (one,) = make_sets(name, colour_space)
        assert one(image, superpixels).shape == (superpixels.max() + 1, len(one.columns))
        assert len(set(one.columns)) == len(one.columns)
        assert one.name == name


def test_sets_are_joined_in_the_order_of_their_names() -> None:
    describer = Describer(features="height+surroundings", rows_per="superpixel", contrast=True)
    rows, row_of_pixel = describer(photograph())
    assert describer.n_features == rows.shape[1] == 1 + 58 + 15
    for one, columns in zip(describer.sets, ((0, 1), (1, 59), (59, 74)), strict=True):
        np.testing.assert_array_equal(rows[:, slice(*columns)], one(photograph(), row_of_pixel))
    assert count_features("height+surroundings", "rgb", contrast=True) == 74


@pytest.mark.parametrize("features", ["", "colour", "colours+", "colours++height", "+height"])
def test_what_is_no_set_is_refused(features: str) -> None:
    with pytest.raises(ValueError, match=r"features: expected colours, contrast, .*onnx:FILE"):
        make_sets(features, "rgb")


def test_a_set_can_be_there_once_only() -> None:
    for options in ({"features": "height+height"}, {"features": "contrast", "contrast": True}):
        with pytest.raises(ValueError, match="features: expected one set or more, each once"):
            Describer(**options)  # type: ignore[arg-type]


def test_ones_own_set_learns_and_is_known_by_its_name(tmp_path: Path) -> None:
    learner = taught(features=[RED, *make_sets("height", "rgb")], superpixels="cells")
    assert learner.forest.n_features == 2
    frame = picture(8)
    saliency = learner.saliency(frame.rgb)
    is_red = frame.rgb[..., 0] > 150
    assert saliency[is_red].mean() > 0.8
    assert saliency[~is_red].mean() < 0.1
    learner.save(tmp_path / "model.npz")
    with pytest.raises(DataError, match="made with other features: redness") as caught:
        SaliencyLearner.load(tmp_path / "model.npz")
    assert "features=[" in caught.value.remedy
    loaded = SaliencyLearner.load(tmp_path / "model.npz", features=[RED])
    np.testing.assert_array_equal(loaded.saliency(frame.rgb), saliency)


@pytest.mark.parametrize(
    "other",
    [
        FeatureSet("redness", ("greener than red",), redness),
        FeatureSet("redness", ("redder than green", "bluer"), redness),
        FeatureSet("redness", ("redder than green",), redness, digest="of another file"),
    ],
)
def test_a_set_of_the_same_name_that_is_another_is_refused(
    tmp_path: Path, other: FeatureSet
) -> None:
    taught(1, features=[RED]).save(tmp_path / "model.npz")
    with pytest.raises(DataError, match=r"other features|expected 2 features"):
        SaliencyLearner.load(tmp_path / "model.npz", features=[other])


@pytest.mark.parametrize(
    ("rows", "got"),
    [(np.zeros((4, 1)), r"\(4, 1\) float64"), (np.zeros((3, 1), np.uint8), r"\(3, 1\) uint8")],
)
def test_rows_that_are_not_as_declared_are_refused(rows: np.ndarray, got: str) -> None:
    wrong = FeatureSet("wrong", ("one",), lambda image, superpixels: rows)
    superpixels = np.repeat(np.arange(4, dtype=np.int32), 6)[None].repeat(24, axis=0)
    with pytest.raises(ValueError, match=rf"features 'wrong': expected \(4, 1\) uint8, got {got}"):
        wrong(np.zeros((24, 24, 3), np.uint8), superpixels)


def test_a_set_needs_a_name_and_columns() -> None:
    for name, columns in (("", ("one",)), ("none", ())):
        with pytest.raises(ValueError, match="features: expected a name and columns"):
            FeatureSet(name, columns, redness)


def test_means_and_bytes_are_what_they_say() -> None:
    superpixels = np.array([[0, 0, 2], [2, 2, 2]], np.int32)
    maps = [np.array([[1.0, 3.0, 0.0], [4.0, 4.0, 4.0]]), np.full((2, 3), 7.0)]
    means = mean_of_pixels(maps, superpixels)
    assert means.tolist() == [[2, 7], [0, 0], [3, 7]]
    assert to_bytes(np.array([-9.0, 0.0, 1.0, 5.0, 10.0, 11.0]), 0, 10).tolist() == [
        0,
        0,
        26,
        128,
        255,
        255,
    ]


def test_a_model_file_of_version_0_1_is_read(tmp_path: Path) -> None:
    """Its header, as that version wrote it: one set without columns, and no word of the rest."""
    learner = taught(colour_space="lab", contrast=True, follow_edges=True)
    learner.save(tmp_path / "model.npz")
    header, arrays = read_archive(tmp_path / "model.npz", KIND)
    first = {
        "name": "39 mean colours",
        "rows_per": "superpixel",
        "colour_space": "lab",
        "contrast": True,
        "n_superpixels": 600,
    }
    assert header["features"] == first
    assert "edge_stride" not in header
    write_archive(tmp_path / "first.npz", KIND, header | {"features": first}, arrays)
    loaded = SaliencyLearner.load(tmp_path / "first.npz")
    assert (loaded.describer.features, loaded.describer.superpixels) == ("colours", "seeds")
    assert loaded.edge_stride == 1
    frame = picture(8)
    np.testing.assert_array_equal(loaded.saliency(frame.rgb), learner.saliency(frame.rgb))


def test_a_model_says_its_sets_and_comes_back(tmp_path: Path) -> None:
    options = {"features": "surroundings+height", "superpixels": "cells", "contrast": True}
    learner = taught(**options, follow_edges=True, edge_stride=3, n_superpixels=900)
    learner.save(tmp_path / "model.npz")
    header, _ = read_archive(tmp_path / "model.npz", KIND)
    sizes = {one["name"]: len(one["columns"]) for one in header["features"]["sets"]}
    assert sizes == {"surroundings": 58, "height": 1, "contrast": 15}
    loaded = SaliencyLearner.load(tmp_path / "model.npz")
    assert (loaded.describer.features, loaded.describer.superpixels) == (
        "surroundings+height",
        "cells",
    )
    assert (loaded.describer.contrast, loaded.describer.n_superpixels) == (True, 900)
    assert loaded.edge_stride == 3
    frame = picture(8)
    np.testing.assert_array_equal(loaded.saliency(frame.rgb), learner.saliency(frame.rgb))


def test_a_model_whose_columns_are_others_is_refused(tmp_path: Path) -> None:
    taught(1, features="surroundings", superpixels="cells").save(tmp_path / "model.npz")
    header, arrays = read_archive(tmp_path / "model.npz", KIND)
    header["features"]["sets"][0]["columns"][7] = "smell"
    write_archive(tmp_path / "model.npz", KIND, header, arrays)
    with pytest.raises(DataError, match="was made with other features"):
        SaliencyLearner.load(tmp_path / "model.npz")


def test_pixels_have_rows_of_their_own_by_colours_alone() -> None:
    learner = make_learner(features="colours+height", rows_per="pixel")
    description = learner.describe(photograph())
    assert len(description.rows) > 5000
    others = make_learner(features="surroundings", rows_per="pixel").describe(photograph())
    assert len(others.rows) == 520
