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
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.model_file import KIND
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
