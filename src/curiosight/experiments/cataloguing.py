"""Make a catalogue of what recordings of the same rooms show, and write it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from curiosight.catalogue import CHANGES, MIN_CONFIDENCE, Catalogue, Detection, Entry, Visit
from curiosight.config import Config
from curiosight.datasets import Dataset, Prefetch
from curiosight.errors import DataError
from curiosight.evaluation.proposals import run_lengths
from curiosight.experiments.components import make_teacher, place, survey_dataset
from curiosight.experiments.mapping import FRAMES_MB
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.problems import Problems
from curiosight.frame import Frame, Rgb
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.looks import look_of
from curiosight.learner.observation import Teaches
from curiosight.teacher import Survey

OBJECTS = "objects.json"
NO_POSE = "no pose"
# Pixels of a picture's longer side, and the share of the thing's size that is shown around it.
PICTURE_PX, AROUND = 240, 0.25
# Seen on dark and on light.
OUTLINE = (((0, 0, 0), 3), ((255, 255, 255), 1))


class Cataloguing:
    """Follow the things that recordings of the same rooms show, each a visit, frame by frame.

    model: of a run; its maps confirm what depth leaves in doubt, and its places are named.
    every: look at each `every`-th frame.
    catalogue: what is known so far. is_confirmed: the model has learned, so that its maps count.

    Raises `DataError` for a recording without poses or depth.
    """

    def __init__(
        self,
        config: Config,
        model: Path,
        datasets: Sequence[Dataset],
        *,
        min_confidence: float = MIN_CONFIDENCE,
        every: int = 1,
    ) -> None:
        if every < 1:
            raise ValueError(f"every: expected 1 or more, got {every}")
        for dataset in datasets:
            _check_poses(dataset)
        self.catalogue = Catalogue(min_confidence=min_confidence)
        # JPEG, of each detection.
        self._pictures: dict[Detection, bytes] = {}
        self.problems = Problems()
        self.n_frames = 0
        self._learner = SaliencyLearner.load(model)
        self._datasets = tuple(datasets)
        self._indices = [range(0, len(dataset), every) for dataset in datasets]
        self._config = config

    def __len__(self) -> int:
        """Count the frames that are looked at."""
        return sum(map(len, self._indices))

    def __iter__(self) -> Iterator[Frame]:
        """Yield each frame once it is taken in; a visit that is ended early counts as it is."""
        for dataset, indices in zip(self._datasets, self._indices, strict=True):
            survey = survey_dataset(self._config, dataset)
            visit = Visit(place(dataset), _up_of(survey))
            try:
                yield from self._visited(visit, dataset, indices, survey)
            finally:
                if visit.views:
                    self.catalogue.add(visit)

    def _visited(
        self, visit: Visit, dataset: Dataset, indices: Sequence[int], survey: Survey
    ) -> Iterator[Frame]:
        teacher = make_teacher(self._config, dataset, survey)
        memory_mb = min(self._config.run.memory_mb, FRAMES_MB)
        with Prefetch(dataset, memory_mb=memory_mb) as frames:
            for frame in frames.in_order(indices):
                self.n_frames += 1
                self._take_in(frame, visit, teacher)
                yield frame

    def _take_in(self, frame: Frame, visit: Visit, teacher: Teaches) -> None:
        if frame.problem is not None or frame.T_world_camera is None:
            self.problems.add(frame, NO_POSE)
            return
        segmentation = teacher.segment(frame)
        self.problems.add_told(frame, segmentation)
        saliency = None
        if self._learner.is_trained:
            saliency = self._learner.saliency(frame.rgb, frame.T_world_camera)
        for shown in visit.add(frame, segmentation, saliency, self._place(frame)):
            picture = cv2.cvtColor(_picture(frame.rgb, shown), cv2.COLOR_RGB2BGR)
            self._pictures[shown] = cv2.imencode(".jpg", picture)[1].tobytes()

    def _place(self, frame: Frame) -> int | None:
        """Return the number of the place that a frame was taken in; None where none is known."""
        places = self._learner.experts.places
        if places is None:
            return None
        weights = places.locate(frame.T_world_camera, look_of(frame.rgb))
        return int(weights.argmax()) if weights.any() else None

    @property
    def is_confirmed(self) -> bool:
        return self._learner.is_trained

    def picture_of(self, entry: Entry) -> Rgb:
        """Return (h, w, 3) uint8, an entry in the view that shows most of it, outlined."""
        encoded = np.frombuffer(self._pictures[entry.best.shown], np.uint8)
        picture: Rgb = cv2.cvtColor(cv2.imdecode(encoded, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        return picture

    def finish(self, out: OutputFolder) -> dict[str, Any]:
        """Write objects.json for the frames so far; return a summary, JSON-able."""
        out.write_json(OBJECTS, to_json(self.catalogue))
        changes = Counter[str](entry.change for entry in self.catalogue.entries)
        return {
            "frames": self.n_frames,
            "visits": len(self.catalogue.visits),
            "objects": len(self.catalogue.entries),
            **{change: changes[change] for change in CHANGES},
            "problems": self.problems.counts(),
        }


def to_json(catalogue: Catalogue) -> dict[str, Any]:
    """Return a catalogue as a COCO file's content, with the entries as `objects`.

    Every view that was looked at is an image, every view of an entry an annotation.
    """
    images: list[dict[str, Any]] = []
    number_of: dict[tuple[int, int], int] = {}
    for number, visit in enumerate(catalogue.visits):
        for place_in_visit, view in enumerate(visit.views):
            height, width = view.size
            image = {"id": len(images) + 1, "file_name": view.id, "width": width, "height": height}
            image |= {"visit": number, "source": visit.name}
            if view.stamp_ns is not None:
                image["stamp_ns"] = view.stamp_ns
            images.append(image)
            number_of[number, place_in_visit] = len(images)
    annotations: list[dict[str, Any]] = []
    for entry in catalogue.entries:
        for sighting in entry.seen:
            image_id = number_of[sighting.visit, sighting.view]
            size = catalogue.visits[sighting.visit].views[sighting.view].size
            numbers = {"id": len(annotations) + 1, "image_id": image_id, "object_id": entry.id}
            annotations.append(numbers | _annotation(sighting.shown, size))
    return {
        "images": images,
        "annotations": annotations,
        "categories": [{"id": 1, "name": "object"}],
        "objects": [_object(entry, number_of) for entry in catalogue.entries],
    }


def _annotation(shown: Detection, size: tuple[int, int]) -> dict[str, Any]:
    x, y, width, height = shown.box
    full = np.zeros(size, np.bool_)
    full[y : y + height, x : x + width] = shown.mask
    annotation = {
        "category_id": 1,
        "bbox": list(shown.box),
        "area": shown.n_pixels,
        "iscrowd": 0,
        "segmentation": {"size": list(size), "counts": run_lengths(full)},
    }
    if np.isfinite(shown.saliency):
        annotation["score"] = round(shown.saliency, 4)
    return annotation


def _object(entry: Entry, number_of: Mapping[tuple[int, int], int]) -> dict[str, Any]:
    images = [number_of[one.visit, one.view] for one in entry.seen]
    described: dict[str, Any] = {
        "id": entry.id,
        "place": entry.place,
        "support": entry.support,
        "T_world_centre": entry.T_world_centre.round(4).tolist(),
        "size_m": [round(length, 3) for length in entry.size_m],
        "first_seen": min(images),
        "last_seen": max(images),
        "n_views": entry.n_views,
        "confidence": round(entry.confidence, 3),
        "change": entry.change,
    }
    if entry.T_world_before is not None:
        described["T_world_before"] = entry.T_world_before.round(4).tolist()
    return described


def _check_poses(dataset: Dataset) -> None:
    if all(pose is None for pose in dataset.poses):
        found = "has no poses, and things are followed from view to view by where they are"
        raise DataError(place(dataset), found, "give poses, see docs/recordings.md")


def _up_of(survey: Survey) -> npt.NDArray[Any] | None:
    return None if survey.up_world is None else np.asarray(survey.up_world, np.float64)


def _picture(rgb: Rgb, shown: Detection) -> Rgb:
    """Return what a thing looks like in a view, outlined, with a little around it."""
    x, y, width, height = shown.box
    margin = round(AROUND * max(width, height))
    left, top = max(0, x - margin), max(0, y - margin)
    part = rgb[top : y + height + margin, left : x + width + margin]
    mask = np.zeros(part.shape[:2], np.uint8)
    mask[y - top : y - top + height, x - left : x - left + width] = shown.mask
    scale = PICTURE_PX / max(part.shape[:2])
    size = (max(1, round(scale * part.shape[1])), max(1, round(scale * part.shape[0])))
    picture: Rgb = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
    mask = cv2.resize(mask, size, interpolation=cv2.INTER_NEAREST)
    outline, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for colour, thickness in OUTLINE:
        cv2.drawContours(picture, outline, -1, colour, thickness)
    return picture
