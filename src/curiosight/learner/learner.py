"""The learner: predict from RGB, compare with what depth says, learn from it (sec. II-A)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.errors.arguments import check_share, check_switch, check_whole
from curiosight.frame import Camera, Depth, Frame, Pose, Rgb
from curiosight.learner.calibration import Calibration
from curiosight.learner.description import (
    Counts,
    Description,
    Labels,
    Saliency,
    enlarge,
    fit_labels,
    sight_of,
)
from curiosight.learner.edges import EdgeFilter
from curiosight.learner.experts import Change, Experts
from curiosight.learner.features import (
    ColourSpace,
    Describer,
    Features,
    FeatureSet,
    Rows,
    RowsPer,
    SuperpixelKind,
    shrink,
)
from curiosight.learner.forest import Forest
from curiosight.learner.fusing import PRIOR, fuse, is_seen
from curiosight.learner.glance import Glance
from curiosight.learner.lesson import Drawn, Lesson, Taught, Visit
from curiosight.learner.looks import look_of
from curiosight.learner.maps import Cameras, Maps
from curiosight.learner.model_file import read_model, write_model
from curiosight.learner.novelty import SeenRows
from curiosight.learner.observation import Observation, Rescoring, Teaches, Votes
from curiosight.learner.places import Places
from curiosight.learner.sampling import draw_pixels
from curiosight.learner.sight import Sight
from curiosight.metrics import f1_error_of_rows
from curiosight.teacher import Segmentation

# Of an image of 320 pixels width, far over what helps.
MAX_PIXELS, MAX_STRIDE = 100_000, 100

# Of the views of the off-line model, to calibrate it: it learns all but one in turn.
N_PARTS = 4
# What changes as it learns, beside what its teacher remembers.
LEARNED = ("rng", "experts", "calibration", "notes", "cameras")


class SaliencyLearner:
    """Learn on-line how objects look, taught by depth; then find them in RGB alone.

    teacher: labels frames; None = this model only predicts.
    features: the sets of features, by their names joined with `+` (see `make_sets`), or sets of
        one's own (see `FeatureSet`). The paper's are `colours`.
    rows_per: "pixel" describes every pixel exactly, as the paper does; "superpixel" gives all
        pixels of a superpixel one row, an approximation that is 10 to 50 times cheaper. Sets
        other than `colours` describe superpixels either way.
    colour_space: of the features. The paper's is RGB; in Lab a split on one channel separates
        hues in any light, and the same forest learns more.
    contrast: describe superpixels also by how they differ from their surroundings: the set
        `contrast`. The paper does not.
    superpixels: "seeds" as in the paper, or "cells", which take a tenth of the time.
    n_pixels: labelled pixels that a frame teaches (sec. II-A.3), drawn without replacement.
    blind_share: of these, drawn where depth has no reading in range, and taken for not salient:
        windows and screens, which depth never shows, are learned so. The paper uses none.
    salient_share: of these, drawn where there is an object, if the frame shows enough of it: most
        of what is seen is none, and a full buffer would hold little else. 0 = as it comes, as in
        the paper.
    follow_edges: let maps follow the image's edges (guided filter, He et al. 2010). The paper's
        do not.
    edge_stride: find the filter's weights for blocks of so many pixels: sooner, a little coarser.
    threshold: a pixel that scores above it is predicted salient, for the error.
    places: which place a view is of; each has a forest of its own, see `Experts`. None = one
        forest for everywhere, as in the paper.
    is_calibrated: scores are scaled so that 0.5 is the decision with the best F1, see
        `Calibration`. The paper's are not.

    Any number of threads may call `saliency`, `describe` and `predict`, with the same bytes as
    one thread gives; also while one other thread learns (`observe`, `learn`): each map is then
    made by a forest from before an update, or from after it, never by a half-changed one. The scale
    of its scores (`is_calibrated`) may be that of a frame later.
    Two threads must not learn at the same time. With depth a map asks the teacher, and one that
    remembers (`TemporalTeacher`) must not be asked by two threads either.
    """

    def __init__(
        self,
        teacher: Teaches | None = None,
        forest: Forest | None = None,
        *,
        features: Features = "colours",
        rows_per: RowsPer = "pixel",
        colour_space: ColourSpace = "rgb",
        contrast: bool = False,
        superpixels: SuperpixelKind = "seeds",
        n_superpixels: int = 600,
        n_pixels: int = 700,
        blind_share: float = 0.0,
        salient_share: float = 0.0,
        follow_edges: bool = False,
        edge_stride: int = 1,
        threshold: float = 0.5,
        places: Places | None = None,
        is_calibrated: bool = False,
        seed: int | np.random.Generator = 0,
    ) -> None:
        self.describer = Describer(
            features=features,
            rows_per=rows_per,
            colour_space=colour_space,
            contrast=contrast,
            superpixels=superpixels,
            n_superpixels=n_superpixels,
        )
        check_whole("n_pixels", n_pixels, 1, MAX_PIXELS)
        check_whole("edge_stride", edge_stride, 1, MAX_STRIDE)
        check_share("blind_share", blind_share)
        check_share("salient_share", salient_share)
        check_share("threshold", threshold)
        check_switch("follow_edges", follow_edges)
        n_features = self.describer.n_features
        if forest is not None and forest.n_features != n_features:
            raise ValueError(f"forest: expected {n_features} features, got {forest.n_features}")
        self.teacher = teacher
        self.rng = np.random.default_rng(seed)
        self.experts = Experts(forest or Forest(n_features=n_features, seed=self.rng), places)
        self.calibration = Calibration() if is_calibrated else None
        self.n_pixels = n_pixels
        self.blind_share = blind_share
        self.salient_share = salient_share
        self.follow_edges = follow_edges
        self.edge_stride = edge_stride
        self.threshold = threshold
        self.notes: dict[str, Any] = {}
        self.cameras = Cameras()
        self._drawn: Drawn  # of the last look
        # With what was known of the samples when it was made.
        self._seen_rows: tuple[object, SeenRows | None] | None = None
        self._moment = object()

    @property
    def forest(self) -> Forest:
        """The forest of everywhere; where there is one place, the only one."""
        return self.experts.common

    @property
    def is_trained(self) -> bool:
        """Tell whether both classes have been seen; until then every prediction is 0."""
        return self.experts.is_trained

    @property
    def n_samples(self) -> int:
        return self.experts.n_samples

    def observe(self, frame: Frame) -> Observation:
        """Look at a frame: predict, compare with the teacher, then learn from it."""
        description = self.describe(frame.rgb)
        segmentation = self.segment(frame)
        labels = fit_labels(segmentation.labels, description)
        sight = self.sight(frame, description, segmentation)
        votes = self.vote(description, frame.T_world_camera)
        counts = description.count(labels)
        scores, error = self._judge(votes, counts, sight)
        spot = self.experts.note(sight)
        change = self.learn(description, labels, spot, error)
        scaling = None if self.calibration is None else self.calibration.state_arrays()
        taught = Taught(self._drawn, sight, error, frame.camera, scaling)
        return Observation(frame, segmentation, description, scores, counts, error, change, taught)

    def learn_again(self, taught: Taught) -> Change:
        """Learn what another learner in the same state was taught, and come to the same state."""
        if taught.camera is not None:
            self.cameras.note(taught.camera)
        if self.calibration is not None and taught.calibration is not None:
            self.calibration.restore(taught.calibration)
        spot, drawn = self.experts.note(taught.sight), taught.drawn
        for chance, state in zip(self._chances(), drawn.chances, strict=True):
            chance.bit_generator.state = state
        change = self.experts.update(drawn.samples(), drawn.is_salient, spot, taught.error)
        self._moment = object()
        return change

    def _chances(self) -> list[np.random.Generator]:
        """Return the sources of chance, each once: mostly one, that forests and learner share."""
        return list({id(one): one for one in (self.rng, self.experts.common.rng)}.values())

    def observe_again(self, visit: Visit) -> tuple[Votes, float | None, Change]:
        """Do as `observe` with what was described, labelled and drawn before.

        Return the (n,) scores and the error as they were before learning, and what changed.
        """
        lesson = visit.lesson
        votes = self.experts.vote(visit.rows, lesson.sight)
        scores, error = self._judge(votes, visit.counts, lesson.sight)
        spot = self.experts.note(lesson.sight)
        change = self.experts.update(lesson.rows, lesson.is_salient, spot, error)
        self._moment = object()
        return scores, error, change

    def error_of(
        self, rows: Rows, counts: tuple[Counts, Counts], sight: Sight | None
    ) -> float | None:
        """Return the error (eq. 1) of a view by the model as it is; nothing is learned.

        rows, counts: as those of a `Visit`; sight: what tells its place, as that of its lesson.
        """
        scores = self.scale(self.experts.vote(rows, sight))
        return f1_error_of_rows(*counts, scores, self.threshold)

    def rescoring(self, observation: Observation) -> Callable[[], float | None]:
        """Return what tells the error of a look by the model as it is when called."""
        description = observation.description
        sight = sight_of(description, observation.frame.T_world_camera)
        return Rescoring(self, description.rows, observation.counts, sight)

    def visit(self, frame: Frame, segmentation: Segmentation, n_pixels: int | None = None) -> Visit:
        """Describe a labelled frame and draw what it teaches, for `observe_again` and `fit`.

        n_pixels: see `sample`.
        """
        description = self.describe(frame.rgb)
        labels = fit_labels(segmentation.labels, description)
        rows, is_salient = self.sample(description, labels, n_pixels)
        salient, other = description.count(labels)
        share = int(salient.sum()) / max(int(salient.sum() + other.sum()), 1)
        sight = self.sight(frame, description, segmentation)
        lesson = Lesson(rows, is_salient, sight, share)
        return Visit(description.rows, (salient, other), lesson)

    def _judge(
        self, votes: Votes, counts: tuple[Counts, Counts], sight: Sight | None
    ) -> tuple[Votes, float | None]:
        """Scale votes for rows of a view; compare with how many pixels of each are labelled how."""
        scores = self.scale(votes)
        error = f1_error_of_rows(*counts, scores, self.threshold)
        if self.calibration is not None and self.is_trained and self.experts.knows(sight):
            self.calibration.add(votes, *counts)
        return scores, error

    def saliency(
        self,
        rgb: Rgb,
        T_world_camera: Pose | None = None,
        depth: Depth | None = None,
        camera: Camera | None = None,
    ) -> Saliency:
        """Return the (H, W) float32 saliency in [0, 1] of an (H, W, 3) RGB image.

        T_world_camera: (4, 4), from where it was taken, in the world of the frames that were
            learned from; None = what it looks like tells the place.
        depth: (H, W) float32 metres, NaN = no reading: what it shows now is fused with what is
            remembered. Raises `ValueError` without a teacher.
        camera: of that depth; None = that of the frames of this size that were learned from.
        """
        if depth is not None:
            return self.maps(rgb, T_world_camera, depth, camera).saliency
        small = shrink(_checked(rgb))
        description = self.describe(small)
        scores = self.predict(description, T_world_camera)[description.row_of_pixel]
        return enlarge(self._smoothing(small)(scores), rgb)

    def maps(
        self,
        rgb: Rgb,
        T_world_camera: Pose | None = None,
        depth: Depth | None = None,
        camera: Camera | None = None,
        *,
        with_uncertainty: bool = False,
    ) -> Maps:
        """Return the saliency of an image with how probable, how sure and how known it is.

        The arguments are those of `saliency`. with_uncertainty: find it too, which takes about
        as long again as the map.
        """
        said = self._said(rgb, T_world_camera, depth, camera)
        small = shrink(_checked(rgb))
        description, smooth = self.describe(small), self._smoothing(small)
        votes = self.vote(description, T_world_camera)
        row_of_pixel = description.row_of_pixel
        uncertainty = None
        if with_uncertainty:
            uncertainty = enlarge(self.unsure(description, T_world_camera)[row_of_pixel], rgb)
        remembered = Maps(
            enlarge(smooth(self.scale(votes)[row_of_pixel]), rgb),
            # Of votes that neighbours share: what follows edges is surer than one row is.
            enlarge(self.probability(smooth(votes[row_of_pixel])), rgb),
            np.zeros(rgb.shape[:2], np.bool_),
            uncertainty,
        )
        return remembered if said is None else self.fused(remembered, said)

    def fused(self, remembered: Maps, segmentation: Segmentation) -> Maps:
        """Return maps of an image that were remembered, fused with what its depth says.

        Where that has a `problem`, it says nothing.
        """
        if segmentation.problem is not None:
            return remembered
        known = remembered.probability
        if not self.is_trained:
            known = np.full_like(known, PRIOR)
        probability = fuse(known, segmentation)
        # Its best F1 is at a half as it is: most pixels are told surely.
        return Maps(probability, probability, is_seen(segmentation), remembered.uncertainty)

    def _said(
        self, rgb: Rgb, T_world_camera: Pose | None, depth: Depth | None, camera: Camera | None
    ) -> Segmentation | None:
        """Return what the teacher says of the depth at hand; None where nothing."""
        if depth is None:
            return None
        if self.teacher is None:
            raise ValueError("depth: expected a learner with a teacher, which this one has not")
        return self.segment(self.cameras.frame(rgb, depth, T_world_camera, camera))

    def _smoothing(self, small: Rgb) -> Callable[[Saliency], Saliency]:
        """Return what lets (h, w) maps follow the edges of their image; or leaves them."""
        return EdgeFilter(small, self.edge_stride) if self.follow_edges else _unchanged

    def describe(self, rgb: Rgb) -> Description:
        """Return the features of an (H, W, 3) RGB image (sec. II-A.1)."""
        small = shrink(_checked(rgb))  # itself where it is so already
        look = look_of(small) if self.experts.places else None
        return Description(*self.describer(small), look)

    def segment(self, frame: Frame) -> Segmentation:
        """Return what the teacher says of a frame (sec. II-A.2)."""
        if self.teacher is None:
            raise ValueError("teacher: expected one to learn from, got None")
        segmentation = self.teacher.segment(frame)
        if frame.camera is not None:
            self.cameras.note(frame.camera)
        labels, size = segmentation.labels, frame.rgb.shape[:2]
        if labels.shape != size or labels.dtype != np.uint8:
            raise ValueError(f"labels: expected {size} uint8, got {labels.shape} {labels.dtype}")
        return segmentation

    def predict(self, description: Description, T_world_camera: Pose | None = None) -> Votes:
        """Return the (n,) saliency of each row; 0 while nothing has been learned."""
        return self.scale(self.vote(description, T_world_camera))

    def vote(self, description: Description, T_world_camera: Pose | None = None) -> Votes:
        """Return the (n,) mean votes of the trees that know a view's place."""
        return self.experts.vote(description.rows, sight_of(description, T_world_camera))

    def scale(self, votes: Votes) -> Votes:
        """Return the saliency that votes mean."""
        return votes if self.calibration is None else self.calibration.scaled(votes)

    def probability(self, votes: Votes) -> Votes:
        """Return how probable it is that what got such votes is salient."""
        return votes if self.calibration is None else self.calibration.probability(votes)

    def unsure(self, description: Description, T_world_camera: Pose | None = None) -> Votes:
        """Return (n,) in [0, 1] how unsure the saliency of each row is; 1 while untrained.

        Trees and experts contradict each other, by which it is 0.5 at most, or the row is unlike
        anything seen, which makes it 1.
        """
        rows = description.rows
        seen = self._seen() if self.is_trained else None
        if seen is None:
            return np.ones(len(rows), np.float32)
        disagreement = self.experts.disagreement(rows, sight_of(description, T_world_camera))
        return np.asarray(1 - (1 - disagreement) * (1 - seen.novelty(rows)))

    def _seen(self) -> SeenRows | None:
        """Return what stands for all rows that were learned from; it is kept until others are."""
        moment, kept = self._moment, self._seen_rows
        if kept is None or kept[0] is not moment:
            kept = self._seen_rows = moment, SeenRows.of(self.experts.seen_rows())
        return kept[1]

    def sight(
        self, frame: Frame, description: Description, segmentation: Segmentation
    ) -> Sight | None:
        """Return what tells the place of a frame; None where places are not told apart."""
        if description.look is None:
            return None
        up = segmentation.up_in_world(frame.T_world_camera)
        glance = Glance.of(frame, segmentation.labels)
        return Sight.of(frame, description.look, up, glance)

    def fit(self, lessons: Sequence[Lesson]) -> None:
        """Forget everything, then learn from views at once: the off-line model.

        It stays untrained where they do not show both classes.
        """
        if self.calibration is not None:
            self.calibration = Calibration()
            for part in range(N_PARTS):  # each part is judged by what the others teach
                self.experts.fit([one for i, one in enumerate(lessons) if i % N_PARTS != part])
                for lesson in lessons[part::N_PARTS]:
                    votes = self.experts.vote(lesson.rows, lesson.sight)
                    self.calibration.add(votes, *lesson.counts(), forgets=False)
        self.experts.fit(lessons)
        self._moment = object()

    def learn(
        self,
        description: Description,
        labels: Labels,
        spot: int = 0,
        error: float | None = None,
    ) -> Change:
        """Add labelled pixels of a frame and regrow some trees (sec. II-A.3).

        labels: (h, w), see `fit_labels`. spot, error: see `Experts.update`.
        """
        which, is_salient = self._draw(description, labels, self.n_pixels)
        chances = tuple(one.bit_generator.state for one in self._chances())
        self._drawn = Drawn(description.rows, which, is_salient, chances)
        change = self.experts.update(self._drawn.samples(), is_salient, spot, error)
        self._moment = object()
        return change

    def sample(
        self, description: Description, labels: Labels, n_pixels: int | None = None
    ) -> tuple[Rows, npt.NDArray[np.bool_]]:
        """Draw the rows (n, F) of labelled pixels and whether each is salient.

        Those of `blind_share` are among them, as not salient.

        n_pixels: how many; None = as many as a frame teaches on-line.
        """
        which, is_salient = self._draw(description, labels, n_pixels or self.n_pixels)
        return description.rows[which], is_salient

    def _draw(
        self, description: Description, labels: Labels, n_pixels: int
    ) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.bool_]]:
        """Draw labelled pixels; return the number (n,) of the row of each, see `sample`."""
        pixels, is_salient = draw_pixels(
            labels,
            n_pixels,
            self.rng,
            blind_share=self.blind_share,
            salient_share=self.salient_share,
        )
        return description.row_of_pixel.ravel()[pixels], is_salient

    def learned(self) -> dict[str, Any]:
        """Return all that learning changes, as it is, not copied: for `take_up`."""
        return {name: getattr(self, name) for name in LEARNED}

    def take_up(self, learned: Mapping[str, Any]) -> None:
        """Go on from what `learned` returned of a learner with the same settings."""
        for name in LEARNED:
            setattr(self, name, learned[name])
        self._moment = object()

    def save(self, path: Path | str, *, is_packed: bool = True) -> None:
        """Write the model with its samples, so that learning can go on.

        `notes` (JSON-able, whatever should be known of it) are kept with it. An existing file is
        replaced as a whole or not at all.

        is_packed: write a small file; without, a larger one, sooner.
        """
        write_model(self, Path(path), is_packed=is_packed)

    @classmethod
    def load(
        cls,
        path: Path | str,
        teacher: Teaches | None = None,
        *,
        features: Iterable[FeatureSet] = (),
        seed: int | np.random.Generator = 0,
        n_threads: int = 1,
    ) -> Self:
        """Read a model that `save` wrote; raises `DataError` for anything else.

        path: the file, or the folder of a run that holds it.
        features: sets of one's own that the model was made with; others are found by their names.
        """
        if n_threads < 1:
            raise ValueError(f"n_threads: expected 1 or more, got {n_threads}")
        rng = np.random.default_rng(seed)
        return read_model(partial(cls, teacher), path, tuple(features), rng, n_threads)


def _checked(rgb: Rgb) -> Rgb:
    """Return an image if it is one."""
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8:
        raise ValueError(f"rgb: expected (H, W, 3) uint8, got {rgb.shape} {rgb.dtype}")
    return rgb


def _unchanged(saliency: Saliency) -> Saliency:
    return saliency
