"""Every setting of a run, section by section, and the two presets."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from curiosight.datasets.reading import AS_RECORDED, Reading
from curiosight.errors.arguments import check_whole
from curiosight.explorer.iac import Direction
from curiosight.explorer.progress import Negative, Undefined
from curiosight.explorer.regions import OrientationSplit, PositionSplit
from curiosight.explorer.strategies import Over, check_name
from curiosight.learner.features import ColourSpace, RowsPer, SuperpixelKind
from curiosight.learner.forest import MAX_THREADS
from curiosight.teacher import PaperSettings, SegmentationSettings

Preset = Literal["default", "paper"]
# Frames or steps: more are not meant. A seed is what a file of settings can hold.
MOST, MAX_SEED = 10**9, 2**63 - 1
PRESETS: tuple[Preset, ...] = get_args(Preset)


@dataclass(frozen=True, slots=True)
class TeacherConfig:
    """What the teacher takes a recording for, after a look at some of its frames.

    source: what labels the frames: "depth", "depth+masks:FOLDER", "masks:FOLDER" or "boxes:FILE".
    pipeline: how depth labels them: "paper" is `PaperTeacher`, set by [paper_segmentation];
        "default" is `Teacher`, set by [segmentation].
    up: to which side of the image up points; "towards" the camera where it looks straight down,
        "away" from it where it looks straight up; "auto" = as camera.json says, else found out.
    temporal: with poses, what earlier views agree on corrects what teaches the learner; not in
        the paper's pipeline, which takes each frame alone.
    """

    source: str = "depth"
    pipeline: Literal["paper", "default"] = "paper"
    scene: Literal["auto", "floor", "table"] = "auto"
    up: Literal["auto", "up", "down", "left", "right", "towards", "away"] = "auto"
    n_survey_frames: int = 24
    temporal: bool = False

    def __post_init__(self) -> None:
        check_whole("n_survey_frames", self.n_survey_frames, 1, 10_000)
        if self.temporal and self.pipeline == "paper":
            raise ValueError("temporal: expected false with the pipeline 'paper', got true")

    @property
    def is_depth(self) -> bool:
        """Tell whether depth says what an object is, with masks or without."""
        kind, _, folder = self.source.partition(":")
        return self.source == "depth" or (kind == "depth+masks" and bool(folder))


@dataclass(frozen=True, slots=True)
class LearnerConfig:
    """What an image is described by, and how much of a frame is learned (sec. II-A.1, 3).

    contrast: 15 features more, of how superpixels differ from their surroundings.
    features: names of sets, joined by +: colours, contrast, surroundings, texture, height, itti,
        onnx:FILE.
    superpixels: seeds as in the paper, or cells, which take a tenth of the time.
    blind_share: of the pixels, taken from where depth says nothing, as not salient.
    salient_share: of the pixels, taken from objects where a frame shows so much of them.
    follow_edges: maps follow the image's edges.
    max_places: so many places at most have forests of their own; 0 = one forest for everywhere.
    is_calibrated: scores are scaled so that the threshold has the best F1.
    edge_stride: of which the filter's weights are found for blocks of so many pixels.
    """

    rows_per: RowsPer = "pixel"
    colour_space: ColourSpace = "rgb"
    contrast: bool = False
    features: str = "colours"
    superpixels: SuperpixelKind = "seeds"
    n_superpixels: int = 600
    n_pixels: int = 700
    blind_share: float = 0.0
    salient_share: float = 0.0
    follow_edges: bool = False
    max_places: int = 0
    is_calibrated: bool = False
    edge_stride: int = 1
    threshold: float = 0.5


@dataclass(frozen=True, slots=True)
class ForestConfig:
    """The forest (sec. II-A.3).

    n_split_features: 0 = all of them.
    leaf_share: a node of less than this share of a tree's samples is a leaf, too.
    n_levels: values of a feature that a split tells apart, a power of 2 up to 256.
    max_rows: a tree draws rows with all their samples, about so many at most, and the oldest trees
        regrow; 0 = it draws samples, and random trees do, as in the paper.
    """

    n_trees: int = 30
    n_regrown: int = 4
    share: float = 0.7
    max_samples: int = 100_000
    max_depth: int = 10
    min_split: int = 11
    n_split_features: int = 0
    leaf_share: float = 0.0
    n_levels: int = 256
    max_rows: int = 0
    vote: Literal["hard", "soft"] = "hard"


@dataclass(frozen=True, slots=True)
class ExplorerConfig:
    """Where to look (sec. II-B). regions: "" = as the recording's own table says, else auto
    where there are rooms, else pose where there are poses, else time:5.

    strategy: see docs/strategies.md. progress: of the errors as they were made, "forward", or of
    a few kept frames that are scored again after every look, "backward", which takes time.
    """

    strategy: str = "iac"
    n_steps: int = 200
    regions: str = ""
    position_split: PositionSplit = "median"
    orientation_split: OrientationSplit = "count"
    n_stay: int = 10
    n_warm_up: int = 2
    random_share: float = 0.25
    progress: Direction = "forward"
    theta: int = 15
    smoothing: int = 1
    min_errors: int = 2
    undefined: Undefined = "repeat"
    negative: Negative = "clip"
    exponent: float = 1.0
    random_over: Over = "views"
    random_n_stay: int = 1

    def __post_init__(self) -> None:
        check_whole("n_steps", self.n_steps, 1, MOST)
        check_name(self.strategy)


@dataclass(frozen=True, slots=True)
class TestConfig:
    """What is kept out of learning, to test on.

    every: 0 = nothing. gap: neighbours left out on each side. max_frames: no more are tested.
    """

    every: int = 0
    gap: int = 3
    max_frames: int = 200

    def __post_init__(self) -> None:
        check_whole("every", self.every, 0, MOST)
        check_whole("gap", self.gap, 0, MOST)
        check_whole("max_frames", self.max_frames, 1, MOST)


@dataclass(frozen=True, slots=True)
class RunConfig:
    """What changes no result but speed and memory, and the seed of all chance."""

    seed: int = 0
    n_threads: int = 2
    memory_mb: int = 64

    def __post_init__(self) -> None:
        check_whole("seed", self.seed, 0, MAX_SEED)
        check_whole("n_threads", self.n_threads, 1, MAX_THREADS)
        check_whole("memory_mb", self.memory_mb, 1, 10_000_000)


@dataclass(frozen=True, slots=True)
class Config:
    """All settings; the defaults of the sections are the paper's."""

    preset: Preset = "paper"
    reading: Reading = AS_RECORDED
    teacher: TeacherConfig = field(default_factory=TeacherConfig)
    segmentation: SegmentationSettings = field(default_factory=SegmentationSettings)
    paper_segmentation: PaperSettings = field(default_factory=PaperSettings)
    learner: LearnerConfig = field(default_factory=LearnerConfig)
    forest: ForestConfig = field(default_factory=ForestConfig)
    explorer: ExplorerConfig = field(default_factory=ExplorerConfig)
    test: TestConfig = field(default_factory=TestConfig)
    run: RunConfig = field(default_factory=RunConfig)

    @classmethod
    def of_preset(cls, preset: str) -> Config:
        """Return the settings of a preset.

        `paper` is the paper's method to the letter. `default` has a teacher that knows tables
        and floors, and learns from what several views agree on; it describes superpixels instead
        of pixels, in Lab, by their surroundings and texture, and grows deeper, more varied trees
        that answer in shares: measured to be faster and better (`benchmarks/`).
        """
        if preset == "paper":
            return cls()
        if preset != "default":
            raise ValueError(f"preset: expected {' or '.join(PRESETS)}, got {preset!r}")
        return cls(
            preset="default",
            teacher=TeacherConfig(pipeline="default", temporal=True),
            segmentation=SegmentationSettings(follow_sensor=True),
            learner=LearnerConfig(
                features="surroundings+texture+height",
                rows_per="superpixel",
                colour_space="lab",
                superpixels="cells",
                n_superpixels=1500,
                blind_share=0.02,
                salient_share=0.5,
                follow_edges=True,
                edge_stride=2,
                max_places=16,
                is_calibrated=True,
            ),
            forest=ForestConfig(
                n_regrown=2,
                share=0.9,
                max_depth=24,
                min_split=20,
                n_split_features=12,
                leaf_share=0.002,
                max_rows=16_000,
                vote="soft",
            ),
        )

    @property
    def max_range(self) -> float:
        """How far along z depth teaches, in metres."""
        is_paper = self.teacher.pipeline == "paper"
        return self.paper_segmentation.max_range if is_paper else self.segmentation.max_range
