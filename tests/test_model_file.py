"""Model files: the same learner comes back, and what is no model is refused."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from curiosight.errors import DataError
from curiosight.learner.archive import read_archive, write_archive
from curiosight.learner.features import RowsPer
from curiosight.learner.forest import Forest
from curiosight.learner.forest_trees import unpack_trees
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.model_file import KIND
from curiosight.learner.places import Places
from pictures import RedThings, make_learner, picture, taught


@pytest.mark.parametrize("rows_per", get_args(RowsPer))
def test_the_same_seed_gives_the_same_bytes(rows_per: RowsPer, tmp_path: Path) -> None:
    contents = []
    for turn, seed in enumerate((5, 5, 6)):
        path = tmp_path / f"{turn}.npz"
        taught(seed=seed, rows_per=rows_per).save(path)
        contents.append(path.read_bytes())
    assert contents[0] == contents[1] != contents[2]


def test_a_saved_model_comes_back_whole_and_goes_on_learning(tmp_path: Path) -> None:
    learner = taught(colour_space="lab", contrast=True, n_pixels=90, n_superpixels=300)
    learner.notes["source"] = "pictures"
    learner.save(tmp_path / "model.npz")
    loaded = SaliencyLearner.load(tmp_path / "model.npz", RedThings(), seed=1, n_threads=2)
    assert np.array_equal(loaded.saliency(picture(8).rgb), learner.saliency(picture(8).rgb))
    assert np.array_equal(loaded.forest.rows, learner.forest.rows)
    assert (loaded.describer.rows_per, loaded.describer.colour_space) == ("superpixel", "lab")
    assert loaded.describer.contrast
    assert loaded.observe(picture(3)).change.n_regrown == 4
    assert loaded.forest.n_samples == 4 * 90


def test_an_untrained_model_can_be_saved_too(tmp_path: Path) -> None:
    make_learner().save(tmp_path / "model.npz")
    loaded = SaliencyLearner.load(tmp_path / "model.npz")
    assert not loaded.saliency(picture().rgb).any()
    with pytest.raises(ValueError, match="teacher: expected one to learn from"):
        loaded.observe(picture())


def spoil(path: Path, how: str) -> None:
    """Turn a good model file into another that must be refused."""
    content = path.read_bytes()
    header, arrays = read_archive(path, KIND)
    if how == "missing":
        path.unlink()
    elif how == "text":
        path.write_text("no model at all")
    elif how == "truncated":
        path.write_bytes(content[: len(content) // 2])
    elif how == "other kind":
        write_archive(path, "picture book", header, arrays)
    elif how == "other features":
        header["features"]["name"] = "learned by heart"
        write_archive(path, KIND, header, arrays)
    elif how == "other number of features":
        header["forest"]["n_features"] = header["forest"]["n_split_features"] = 3
        write_archive(path, KIND, header, Forest(n_features=3).state_arrays())
    elif how == "more features":
        header["features"]["contrast"] = True
        write_archive(path, KIND, header, arrays)
    elif how == "features not said":
        del header["features"]["contrast"]
        write_archive(path, KIND, header, arrays)
    elif how == "unknown rows":
        header["features"]["rows_per"] = "line"
        write_archive(path, KIND, header, arrays)
    elif how == "no forest":
        del header["forest"]
        write_archive(path, KIND, header, arrays)
    elif how == "no trees":
        del arrays["tree_sizes"]
        write_archive(path, KIND, header, arrays)


@pytest.mark.parametrize(
    ("how", "found"),
    [
        ("missing", "cannot be read"),
        ("text", "not a curiosight file"),
        ("truncated", "not a curiosight file, or a damaged one"),
        ("other kind", "kind 'picture book'"),
        ("other features", "was made with other features"),
        ("other number of features", "forest: expected 39 features, got 3"),
        ("more features", "forest: expected 54 features, got 39"),
        ("features not said", r"holds no usable model \('contrast'\)"),
        ("unknown rows", "rows_per: expected 'pixel' or 'superpixel', got 'line'"),
        ("no forest", "holds no usable model"),
        ("no trees", "tree_sizes: expected"),
    ],
)
def test_what_is_no_model_of_ours_is_refused(tmp_path: Path, how: str, found: str) -> None:
    path = tmp_path / "model.npz"
    taught(1).save(path)
    spoil(path, how)
    with pytest.raises(DataError, match=found) as caught:
        SaliencyLearner.load(path)
    assert caught.value.path == path
    assert caught.value.remedy


# A right checksum says that a file is whole, not that its maker meant well.
NONSENSE_IN_HEADER = [
    ("forest n_trees", 1001, "n_trees: expected 1 to 1000"),
    ("forest n_trees", 10**30, "n_trees: expected 1 to 1000"),
    ("forest n_trees", True, "n_trees: expected a whole number"),
    ("forest n_trees", 30.0, "n_trees: expected a whole number"),
    ("forest n_levels", 256.0, "n_levels: expected a whole number"),
    ("forest max_depth", 2**31 - 1, "max_depth: expected 0 to 1000"),
    ("forest max_depth", 1, "tree_depths: expected"),
    ("forest max_samples", 20, "rows: expected 20 at most, got 1400"),
    ("forest share", "all", "not supported between"),
    ("forest leaf_share", "a", "leaf_share: expected 0 to below 1"),
    ("forest vote", ["soft"], "vote: expected"),
    ("forest", [], "argument after"),
    ("features n_superpixels", 10**9, "n_superpixels: expected 1 to 19200"),
    ("features n_superpixels", 2.5, "n_superpixels: expected a whole number"),
    ("features contrast", "yes", "contrast: expected True or False, got 'yes'"),
    ("features rows_per", {}, "rows_per: expected"),
    ("features sets", 7, "holds no usable model"),
    ("n_pixels", 1.5, "n_pixels: expected a whole number, got 1.5"),
    ("n_pixels", True, "n_pixels: expected a whole number, got True"),
    ("n_pixels", 10**400, "n_pixels: expected 1 to 100000"),
    ("blind_share", "x", "blind_share: expected 0 to below 1"),
    ("threshold", float("nan"), "threshold: expected 0 to below 1"),
    ("edge_stride", 0, "edge_stride: expected 1 or more"),
    ("follow_edges", "x", "follow_edges: expected True or False"),
    ("notes", [], r"notes: expected a table, got \[\]"),
    ("cameras", [[]], "holds no usable model"),
    ("cameras", 5, "holds no usable model"),
    ("places", {"max_places": 10**12}, "max_places: expected 1 to 10000"),
]


@pytest.mark.parametrize(("place", "value", "found"), NONSENSE_IN_HEADER)
def test_nonsense_in_a_header_is_refused(
    place: str, value: object, found: str, tmp_path: Path
) -> None:
    path = tmp_path / "model.npz"
    taught(2).save(path)
    header, arrays = read_archive(path, KIND)
    *outer, last = place.split()
    (header[outer[0]] if outer else header)[last] = value
    write_archive(path, KIND, header, arrays)
    with pytest.raises(DataError, match=found):
        SaliencyLearner.load(path)


NONSENSE_IN_ARRAYS = [
    ("tree_depths", 2**31 - 1, "tree_depths: expected those of the trees"),
    ("tree_depths", 0, "tree_depths: expected those of the trees"),
    ("tree_depths", -1, "tree_depths: expected those of the trees"),
    ("node_values", np.nan, "node_values: expected shares from 0 to 1"),
    ("node_values", 1e30, "node_values: expected shares from 0 to 1"),
    ("node_values", -5, "node_values: expected shares from 0 to 1"),
    ("groups", 99, "groups: expected numbers of"),
    ("groups", -1, "groups: expected numbers of"),
    ("places_of_spot", 10**12, "places_of_spot: expected numbers below"),
    ("places_of_spot", -2, "places_of_spot: expected numbers below"),
    ("places_cell_of_spot", 10**12, "places_cell_of_spot: expected numbers below"),
    ("places_spot_of_look", -1, "places_spot_of_look: expected numbers below"),
    ("places_n_seen", -1, "places_seen: expected the cells that each spot sees"),
    ("calibration", -1, "calibration: expected counts"),
    ("calibration_frames", np.nan, "calibration: expected counts"),
]


@pytest.mark.parametrize(("name", "value", "found"), NONSENSE_IN_ARRAYS)
def test_nonsense_in_an_array_is_refused(
    name: str, value: float, found: str, tmp_path: Path
) -> None:
    path = tmp_path / "model.npz"
    taught(2, places=Places(2), is_calibrated=True).save(path)
    SaliencyLearner.load(path)
    header, arrays = read_archive(path, KIND)
    array = arrays[name].copy()
    array[(-1,) * array.ndim] = value
    write_archive(path, KIND, header, arrays | {name: array})
    with pytest.raises(DataError, match=found):
        SaliencyLearner.load(path)


def test_tree_that_is_a_chain_is_walked_to_its_end_and_no_farther(tmp_path: Path) -> None:
    """A depth that is too small would end at an inner node."""
    n_splits = 900
    left = np.arange(2 * n_splits + 1, dtype=np.int32)
    thresholds = np.full(left.size, 255, np.uint8)
    left[0:-1:2] = np.arange(1, 2 * n_splits, 2)  # of each split the right child splits on
    nodes = {
        "tree_sizes": np.array([left.size], np.int32),
        "node_features": np.zeros(left.size, np.uint16),
        "node_values": np.zeros(left.size, np.float32),
    }
    thresholds[0:-1:2] = 7
    chain = nodes | {"node_left_children": left, "node_thresholds": thresholds}
    for depth, is_right in ((n_splits, True), (n_splits - 1, False), (n_splits + 1, False)):
        arrays = chain | {"tree_depths": np.array([depth], np.int32)}
        if is_right:
            (tree,) = unpack_trees(arrays, 1, max_depth=1000)
            assert tree.depth == n_splits
        else:
            with pytest.raises(ValueError, match="tree_depths"):
                unpack_trees(arrays, 1, max_depth=1000)
    with pytest.raises(ValueError, match="tree_depths: expected those of the trees, 899 at most"):
        unpack_trees(chain | {"tree_depths": np.array([900], np.int32)}, 1, max_depth=899)
