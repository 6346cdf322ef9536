"""The learner on small pictures that a detector of the test's own labels."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from curiosight.archive import read_archive, write_archive
from curiosight.errors import DataError
from curiosight.features import N_FEATURES, RowsPer
from curiosight.forest import Forest
from curiosight.frame import Frame, Label
from curiosight.learner import KIND, Description, SaliencyLearner, fit_labels
from curiosight.metrics import f1_error
from curiosight.segmentation import Segmentation, Teacher

BACKGROUND, RED = (120, 118, 110), (200, 40, 30)
ROWS_PER = pytest.mark.parametrize("rows_per", get_args(RowsPer))


class RedThings:
    """A detector of one's own: red is salient, and the image's upper quarter unknown."""

    def segment(self, frame: Frame) -> Segmentation:
        red, green = frame.rgb[..., 0].astype(int), frame.rgb[..., 1].astype(int)
        labels = np.where(red - green > 80, Label.SALIENT, Label.NOT_SALIENT).astype(np.uint8)
        known_from = len(labels) if frame.problem else len(labels) // 4
        labels[:known_from] = Label.UNKNOWN
        return Segmentation(labels, np.zeros(labels.shape, np.uint16), problem=frame.problem)


class Says:
    """Gives the same labels whatever it is shown."""

    def __init__(self, labels: npt.NDArray[np.generic]) -> None:
        self.labels = labels

    def segment(self, frame: Frame) -> Segmentation:
        return Segmentation(self.labels, np.zeros(self.labels.shape, np.uint16))


def picture(seed: int = 0, *, n_things: int = 2, size: tuple[int, int] = (320, 240)) -> Frame:
    """Paint red rectangles on a grey, slightly noisy ground; size: width, height."""
    rng = np.random.default_rng(seed)
    width, height = size
    rgb = np.full((height, width, 3), BACKGROUND, np.uint8)
    for _ in range(n_things):
        u, v = rng.integers(0, [2 * width // 3, 2 * height // 3])
        rgb[v : v + height // 4, u : u + width // 4] = RED
    rgb += rng.integers(0, 12, rgb.shape).astype(np.uint8)
    return Frame(str(seed), rgb)


def make_learner(seed: int = 0, **options) -> SaliencyLearner:
    return SaliencyLearner(RedThings(), **{"rows_per": "superpixel", "seed": seed} | options)


def taught(n_frames: int = 3, **options) -> SaliencyLearner:
    learner = make_learner(**options)
    for seed in range(n_frames):
        learner.observe(picture(seed))
    return learner


@ROWS_PER
def test_an_untrained_learner_sees_nothing_salient(rows_per: RowsPer) -> None:
    learner = make_learner(rows_per=rows_per)
    assert not learner.saliency(picture().rgb).any()
    observation = learner.observe(picture())
    assert not observation.saliency.any()
    assert observation.error == 1
    assert observation.regrown == tuple(range(30))


@ROWS_PER
def test_what_it_learns_it_finds_again(rows_per: RowsPer) -> None:
    learner = taught(rows_per=rows_per)
    frame = picture(9)
    labels = RedThings().segment(frame).labels
    assert f1_error(labels, learner.saliency(frame.rgb)) < 0.1


@ROWS_PER
def test_scores_and_error_are_from_before_learning(rows_per: RowsPer) -> None:
    learner, twin = taught(2, rows_per=rows_per), taught(2, rows_per=rows_per)
    frame = picture(7)
    before = twin.predict(twin.describe(frame.rgb))
    observation = learner.observe(frame)
    after = learner.predict(observation.description)
    assert np.array_equal(observation.scores, before)
    assert not np.array_equal(observation.scores, after)
    labels = fit_labels(observation.segmentation.labels, observation.description)
    assert observation.error == f1_error(labels, observation.saliency)


def test_a_frame_without_any_object_has_no_error_and_still_teaches() -> None:
    learner = make_learner()
    bare = learner.observe(picture(0, n_things=0))
    assert (bare.error, bare.regrown) == (None, ())
    assert learner.forest.n_samples == 700
    assert not learner.forest.is_salient.any()
    assert not learner.saliency(picture(1).rgb).any()
    learner.observe(picture(1))
    bare = learner.observe(picture(2, n_things=0))
    assert bare.error is None
    assert len(bare.regrown) == 4
    assert learner.forest.n_samples == 2100


@pytest.mark.parametrize("teacher", [RedThings(), Teacher()])
def test_a_frame_with_a_problem_teaches_nothing(teacher: RedThings | Teacher) -> None:
    learner = taught()
    learner.teacher = teacher
    n_samples, before = learner.forest.n_samples, learner.saliency(picture(5).rgb)
    damaged = Frame("damaged", np.zeros((240, 320, 3), np.uint8), problem="truncated")
    observation = learner.observe(damaged)
    assert (observation.error, observation.regrown) == (None, ())
    assert observation.segmentation.problem == "truncated"
    assert learner.forest.n_samples == n_samples
    assert np.array_equal(learner.saliency(picture(5).rgb), before)


def test_exactly_the_four_trees_it_names_change() -> None:
    learner = taught()
    rows = learner.describe(picture(8).rgb).rows
    before = learner.forest.votes(rows)
    regrown = list(learner.observe(picture(3)).regrown)
    has_changed = (learner.forest.votes(rows) != before).any(axis=0)
    assert len(set(regrown)) == 4
    assert has_changed[regrown].any()
    assert not np.delete(has_changed, regrown).any()


@pytest.mark.parametrize(("n_labelled", "n_learned"), [(0, 0), (1, 1), (40, 40), (3000, 700)])
def test_at_most_n_pixels_of_a_frame_are_learned(n_labelled: int, n_learned: int) -> None:
    labels = np.full(240 * 320, Label.UNKNOWN, np.uint8)
    labels[:n_labelled] = Label.NOT_SALIENT
    learner = make_learner()
    learner.teacher = Says(labels.reshape(240, 320))
    learner.observe(picture())
    assert learner.forest.n_samples == n_learned


def test_samples_carry_their_group() -> None:
    learner = make_learner(n_pixels=50)
    for group in (7, -1, 7):
        learner.observe(picture(group + 1), group)
    assert learner.forest.groups.tolist() == 50 * [7] + 50 * [-1] + 50 * [7]


LABEL_VALUES = st.sampled_from([*Label, 3])


@given(
    labels=arrays.arrays(np.uint8, (6, 9), elements=LABEL_VALUES),
    row_of_pixel=arrays.arrays(np.int32, (6, 9), elements=st.integers(0, 10)),
    seed=st.integers(0, 9),
)
@settings(max_examples=60, deadline=None)
def test_only_labelled_pixels_are_drawn_each_once(labels, row_of_pixel, seed) -> None:
    rows = np.repeat(np.arange(11, dtype=np.uint8)[:, None], N_FEATURES, axis=1)
    description = Description(rows, row_of_pixel)
    drawn, is_salient = make_learner(seed, n_pixels=20).sample(description, labels)
    salient, other = description.count(labels)
    assert len(drawn) == len(is_salient) == min(20, salient.sum() + other.sum())
    for of_class, available in ((is_salient, salient), (~is_salient, other)):
        n_drawn = np.bincount(drawn[of_class, 0], minlength=11)
        assert (n_drawn <= available).all()


def enlarged(small: npt.NDArray[np.float32], width: int, height: int) -> npt.NDArray[np.float64]:
    """Interpolate linearly between the middles of pixels, one line of code an axis."""
    v = (np.arange(height) + 0.5) * small.shape[0] / height - 0.5
    u = (np.arange(width) + 0.5) * small.shape[1] / width - 0.5
    rows = np.array([np.interp(v, np.arange(small.shape[0]), column) for column in small.T]).T
    return np.array([np.interp(u, np.arange(small.shape[1]), row) for row in rows])


@ROWS_PER
@pytest.mark.parametrize("size", [(320, 240), (640, 480), (160, 120), (333, 500), (300, 40)])
def test_a_map_is_the_rows_scores_painted_and_enlarged(rows_per: RowsPer, size) -> None:
    learner = taught(rows_per=rows_per)
    rgb = picture(4, size=size).rgb
    before = rgb.copy()
    saliency = learner.saliency(rgb)
    description = learner.describe(rgb)
    small = learner.predict(description)[description.row_of_pixel]
    assert saliency.shape == rgb.shape[:2]
    assert saliency.dtype == np.float32
    assert np.allclose(saliency, enlarged(small, *size), atol=1e-5)
    assert np.array_equal(rgb, before)


@ROWS_PER
@pytest.mark.parametrize("colour_space", ["rgb", "lab"])
def test_features_are_colours_of_the_space_that_was_asked_for(rows_per, colour_space) -> None:
    rgb = np.full((240, 320, 3), RED, np.uint8)
    lab = cv2.cvtColor(rgb[:1, :1], cv2.COLOR_RGB2LAB)[0, 0]
    learner = SaliencyLearner(rows_per=rows_per, colour_space=colour_space)
    rows = learner.describe(rgb).rows
    assert (rows == np.tile(RED if colour_space == "rgb" else lab, 13)).all()


def test_superpixels_have_far_fewer_rows_than_pixels() -> None:
    rgb = picture().rgb
    n_rows = {
        rows_per: len(make_learner(rows_per=rows_per).describe(rgb).rows)
        for rows_per in get_args(RowsPer)
    }
    assert n_rows["superpixel"] < 1000 < 10 * n_rows["superpixel"] < n_rows["pixel"]


def test_describing_leaves_no_trace() -> None:
    learner = make_learner()
    first = learner.describe(picture(0).rgb)
    rows, row_of_pixel = first.rows.copy(), first.row_of_pixel.copy()
    learner.describe(picture(1).rgb)
    learner.describe(picture(2, size=(200, 200)).rgb)
    again = learner.describe(picture(0).rgb)
    for description in (first, again):
        assert np.array_equal(description.rows, rows)
        assert np.array_equal(description.row_of_pixel, row_of_pixel)


def test_a_mirror_image_has_nearly_the_mirrored_map() -> None:
    """Nearly: SEEDS starts at the upper left."""
    learner = taught(6)
    rgb = picture(8).rgb
    mirrored = learner.saliency(np.ascontiguousarray(rgb[:, ::-1]))[:, ::-1]
    assert np.abs(mirrored - learner.saliency(rgb)).mean() < 0.05


@ROWS_PER
def test_the_same_seed_gives_the_same_bytes(rows_per: RowsPer, tmp_path: Path) -> None:
    contents = []
    for turn, seed in enumerate((5, 5, 6)):
        path = tmp_path / f"{turn}.npz"
        taught(seed=seed, rows_per=rows_per).save(path)
        contents.append(path.read_bytes())
    assert contents[0] == contents[1] != contents[2]


def test_a_saved_model_comes_back_whole_and_goes_on_learning(tmp_path: Path) -> None:
    learner = taught(colour_space="lab", n_pixels=90, n_superpixels=300)
    learner.save(tmp_path / "model.npz", {"source": "pictures"})
    loaded = SaliencyLearner.load(tmp_path / "model.npz", RedThings(), seed=1, n_threads=2)
    assert np.array_equal(loaded.saliency(picture(8).rgb), learner.saliency(picture(8).rgb))
    assert np.array_equal(loaded.forest.rows, learner.forest.rows)
    assert (loaded.rows_per, loaded.colour_space) == ("superpixel", "lab")
    assert len(loaded.observe(picture(3)).regrown) == 4
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


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"rows_per": "line"}, "rows_per: expected 'pixel' or 'superpixel', got 'line'"),
        ({"colour_space": "hsv"}, "colour_space: expected 'rgb' or 'lab', got 'hsv'"),
        ({"n_pixels": 0}, "n_pixels: expected 1 or more, got 0"),
        ({"n_superpixels": 0}, "n_superpixels: expected 1 or more, got 0"),
        ({"forest": Forest(n_features=3)}, "forest: expected 39 features, got 3"),
    ],
)
def test_bad_settings_are_named(options, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        SaliencyLearner(**options)


@pytest.mark.parametrize(
    "rgb",
    [
        np.zeros((240, 320), np.uint8),
        np.zeros((240, 320, 4), np.uint8),
        np.zeros((240, 320, 3), np.float32),
    ],
)
def test_what_is_no_rgb_image_is_refused(rgb) -> None:
    with pytest.raises(ValueError, match=r"rgb: expected \(H, W, 3\) uint8, got"):
        make_learner().saliency(rgb)


@pytest.mark.parametrize("labels", [np.zeros((120, 160), np.uint8), np.zeros((240, 320), np.int64)])
def test_labels_of_another_shape_or_kind_are_refused(labels) -> None:
    learner = make_learner()
    learner.teacher = Says(labels)
    with pytest.raises(ValueError, match=r"labels: expected \(240, 320\) uint8, got"):
        learner.observe(picture())
