"""Draw the paper's figures one by one, and write their numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.cli.evaluate_report import failures, method_results
from curiosight.cli.talk import Talk
from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.evaluation.baselines import METHODS
from curiosight.experiments.comparing import Comparison, Methods
from curiosight.experiments.components import choose_regions
from curiosight.experiments.contest.contest import Contest
from curiosight.experiments.contest.runs import RunRecord
from curiosight.experiments.contest.series import band_of
from curiosight.experiments.contest.table import Curve, curves_of
from curiosight.experiments.output import OutputFolder, TableFile
from curiosight.experiments.paper_figures.claims import (
    Claim,
    claims_of_errors,
    claims_of_evolution,
    claims_of_roc,
    claims_of_time,
)
from curiosight.experiments.paper_figures.evolution import choose_target, evolve
from curiosight.experiments.paper_figures.subject import Subject, least_error
from curiosight.explorer import Regions, make_regions
from curiosight.explorer.from_above import seen_from_above
from curiosight.frame import Label, Pose
from curiosight.viewing.comparison import WallRow, draw_roc, draw_wall
from curiosight.viewing.contest import draw_errors, draw_times
from curiosight.viewing.evolution import MapThen, evolution
from curiosight.viewing.examples import Example, examples
from curiosight.viewing.figures import window_shares
from curiosight.viewing.region_map import regions_from_above

ENDINGS = ("svg", "pdf")
BASELINE = "bms"
# Looks over which time in regions is counted: at most, at least, and as a part of a run.
MOST_LOOKS, LEAST_LOOKS, PART = 50, 5, 5
TIMED = ("random", "iac")  # whose time in regions is shown
Row = Mapping[str, Any]
Floats = npt.NDArray[np.float64]


class CannotDrawError(Exception):
    """Why a source cannot give a figure, in a line."""


class Drawing:
    """The figures of one source.

    config: as it is prepared with. subject: None where it could not be prepared, for the
    reason that `problem` says. is_stopped: asked frame by frame; then no more is drawn.
    claims: of the figures drawn so far.
    """

    def __init__(
        self, talk: Talk, folder: OutputFolder, config: Config, dataset: Dataset, methods: Methods
    ) -> None:
        self._talk, self._folder, self._methods = talk, folder, methods
        self.config, self.dataset = config, dataset
        self.subject: Subject | None = None
        self.problem = ""
        self.is_stopped: Callable[[], bool] = lambda: False
        self.claims: list[Claim] = []
        self._curves: dict[str, list[Curve]] = {}
        self._runs: dict[str, list[RunRecord]] = {}
        self._comparison: Comparison | None = None

    def add_runs(self, contest: Contest, source: str) -> None:
        """Read the runs of the strategies, for figures 6 and 7; nothing where some are missing."""
        if contest.n_missing():
            return
        self._curves = curves_of(contest, source)
        self._runs = {name: contest.records(source, name) for name in TIMED}

    def draw(self, number: int) -> None:
        """Draw a figure and write its numbers; raises `CannotDrawError`."""
        figures: dict[int, Callable[[], None]] = {
            2: self._examples,
            3: self._roc,
            4: self._wall,
            5: self._evolution,
            6: self._errors,
            7: self._times,
            8: self._regions,
        }
        figures[number]()

    def _prepared(self) -> Subject:
        if self.subject is None:
            raise CannotDrawError(self.problem)
        return self.subject

    def _save(self, number: int, draw: Callable[[Path], None], rows: Iterable[Row]) -> None:
        for ending in ENDINGS:
            draw(self._folder.file(f"figure-{number}.{ending}"))
        _write_table(self._folder.file(f"figure-{number}.csv"), rows)

    def _examples(self) -> None:
        subject = self._prepared()
        shown, rows = [], []
        for index in subject.shown:
            frame = subject.truth.dataset[index]
            if frame.problem is not None:
                continue
            told, saliency = subject.teacher.segment(frame), subject.saliency(frame)
            truth = subject.truth.dataset.ground_truth(index) if subject.has_truth else None
            shown.append(Example(frame.id, frame.rgb, told, saliency, truth))
            row: dict[str, Any] = {"id": frame.id}
            for label in Label:
                row[f"depth_says_{label.name.lower()}"] = float((told.labels == label).mean())
            for label in (Label.SALIENT, Label.NOT_SALIENT):
                of_label = saliency[truth == label] if truth is not None else saliency[:0]
                name = f"saliency_where_truth_is_{label.name.lower()}"
                row[name] = float(of_label.mean()) if of_label.size else None
            row["saliency_where_depth_says_nothing"] = _mean(
                saliency[np.isin(told.labels, (Label.UNKNOWN, Label.UNAVAILABLE))]
            )
            rows.append(row)
        if not shown:
            raise CannotDrawError("no test frame can be used")
        self._save(2, lambda path: examples(shown, path, has_truth=subject.has_truth), rows)

    def _compared(self) -> Comparison:
        subject = self._prepared()
        if self._comparison is None:
            comparison = subject.comparison(self._methods)
            with self._talk.following("methods", len(subject.compared.indices)) as progress:
                for _ in subject.compare(comparison):
                    self._check_going_on()
                    progress.advance()
            for failure in failures(comparison):
                self._talk.warn(failure)
            self._comparison = comparison
        return self._comparison

    def _check_going_on(self) -> None:
        if self.is_stopped():
            raise CannotDrawError("stopped")

    def _roc(self) -> None:
        if not self._prepared().has_truth:
            raise CannotDrawError("there is no ground truth to draw a ROC curve against")
        comparison = self._compared()
        tables = comparison.metrics()
        if not tables:
            raise CannotDrawError("no test frame can be used")
        results = [one for one in method_results(comparison, tables, {}) if len(one.roc)]
        if not results:
            raise CannotDrawError("no frame shows both something salient and something else")
        rows = (
            {"method": one.name, "auc": one.figures["roc_auc"], **_interval(one.intervals)}
            | {"false_positive_rate": float(x), "true_positive_rate": float(y)}
            for one in results
            for x, y in one.roc
        )
        self._save(3, lambda path: draw_roc(results, path), rows)
        self.claims += claims_of_roc(comparison, self.config.run.seed)

    def _wall(self) -> None:
        comparison = self._compared()
        if not comparison.shown:
            raise CannotDrawError("no test frame can be used")
        threshold = comparison.threshold
        wall = [
            WallRow(one.id, one.rgb, one.truth, one.maps, threshold) for one in comparison.shown
        ]
        ids = {one.id for one in comparison.shown}
        rows = (
            {"id": frame["id"], "method": name}
            | {key: frame["all"][key] for key in ("roc_auc", "best_f1", "error")}
            for name, table in comparison.metrics().items()
            for frame in table["per_frame"]
            if frame["id"] in ids
        )
        self._save(4, lambda path: draw_wall(wall, path), rows)

    def _evolution(self) -> None:
        subject = self._prepared()
        target = choose_target(subject)
        with self._talk.following("one view", len(subject.prepared.ids), "look") as progress:
            shots = []
            for shot in evolve(subject, target):
                self._check_going_on()
                progress.advance()
                if shot is not None:
                    shots.append(shot)
        late = target.late
        maps = [MapThen(_after(shot.looks, shot.error), shot.saliency) for shot in shots]
        title = "truth" if subject.has_truth else "what depth says"
        rows = (
            {
                "id": target.frame.id,
                "looks": shot.looks,
                "error": shot.error,
                "thing_first_seen_at_look": None if late is None else late.first_look,
                "saliency_on_thing": shot.on_late,
                "saliency_on_not_salient": shot.elsewhere,
            }
            for shot in shots
        )

        def draw(path: Path) -> None:
            mask = None if late is None else late.mask
            seen = "colour" if late is None else f"outlined: seen at look {late.first_look}"
            evolution(
                target.frame.rgb,
                target.labels,
                maps,
                path,
                outlined=mask,
                titles=(seen, title),
            )

        self._save(5, draw, rows)
        self.claims += claims_of_evolution(target, shots)

    def _errors(self) -> None:
        subject = self._prepared()
        if not self._curves:
            raise CannotDrawError("not all runs of the strategies are done")
        bands = {name: band_of(each, "frames") for name, each in self._curves.items()}
        offline = subject.prepared.phases[-1].offline["error"]
        least = least_error(subject, METHODS, BASELINE)
        others = {} if least is None else {f"BMS, cut at its best, {least[1]:.2f}": least[0]}
        constants = {"off-line": offline} | ({} if least is None else {"bms": least[0]})

        def rows() -> Iterator[Row]:
            for name, band in bands.items():
                for x, mean, deviation in zip(band.x, band.mean, band.deviation, strict=True):
                    yield _error_row(name, int(x), float(mean), float(deviation))
            for name, error in constants.items():
                yield _error_row(name, None, error, None)

        self._save(
            6, lambda path: draw_errors(bands, offline, "looks", path, others=others), rows()
        )
        baseline = None if least is None else least[0]
        self.claims += claims_of_errors(self._curves, offline, baseline, self.config.run.seed)

    def _times(self) -> None:
        self._prepared()
        if not self._runs:
            raise CannotDrawError("not all runs of the strategies are done")
        names = self._runs[TIMED[0]][0].region_names
        shortest = min(len(run.regions) for each in self._runs.values() for run in each)
        n_window = min(shortest, MOST_LOOKS, max(LEAST_LOOKS, shortest // PART))
        shares = {
            strategy: [window_shares(run.regions, len(names), n_window) for run in each]
            for strategy, each in self._runs.items()
        }
        n_looks = min(one.shape[1] for each in shares.values() for one in each)
        looks = np.arange(1, 1 + n_looks)
        first = {f"{name}, first of {len(each)} seeds": each[0] for name, each in shares.items()}
        rows = (
            {"strategy": name, "seed": seed, "look": int(look), "region": region, "share": share}
            for name, each in shares.items()
            for seed, one in enumerate(each)
            for look, column in zip(looks, one.T, strict=True)
            for region, share in zip(names, column.tolist(), strict=True)
        )
        self._save(7, lambda path: draw_times(looks, first, names, path, n_window=n_window), rows)
        self.claims += claims_of_time(shares, self.config.run.seed)

    def _regions(self) -> None:
        poses, regions, up = self._regions_of_views()
        if not any(pose is not None for pose in poses):
            raise CannotDrawError("there are no poses to be seen from above")
        above = seen_from_above(poses, up)
        ids = self.dataset.ids if self.subject is None else self.subject.prepared.ids
        rows = (
            {
                "id": id,
                "x": _known(place[0]),
                "y": _known(place[1]),
                "heading_deg": _known(np.degrees(heading)),
                "region": "" if region < 0 else regions.names[region],
            }
            for id, place, heading, region in zip(
                ids, above.positions, above.headings, regions.of_view, strict=True
            )
        )
        views = range(len(poses))
        self._save(
            8,
            lambda path: regions_from_above(poses, regions, views, path, up=up, counted="views"),
            rows,
        )

    def _regions_of_views(self) -> tuple[Sequence[Pose | None], Regions, Floats | None]:
        """Return the poses, the regions that strategies choose among, and where up is."""
        if self.subject is None:
            return self.dataset.poses, choose_regions(self.config, self.dataset), None
        prepared = self.subject.prepared
        regions = make_regions(
            self.config.explorer.regions or None,
            prepared.poses,
            prepared.ids,
            metres=np.asarray(prepared.metres),
            up=prepared.up,
        )
        return prepared.poses, regions, prepared.up

    def claims_table(self) -> list[dict[str, Any]]:
        """Return the claims, JSON-able."""
        return [
            {
                "figure": one.figure,
                "claim": one.claim,
                "holds": {True: "yes", False: "no", None: "not clear"}[one.holds],
                "value": one.value,
                "low": one.low,
                "high": one.high,
                "over": one.over,
            }
            for one in self.claims
        ]

    def write_claims(self) -> None:
        """Write claims.csv, where there are any."""
        if self.claims:
            _write_table(self._folder.file("claims.csv"), self.claims_table())

    def told(self) -> dict[str, str]:
        """Return the claims for a person."""
        return {
            f"fig. {row['figure']}: {row['claim']}": f"{row['holds']}, {_with_interval(row)}"
            for row in self.claims_table()
        }


def _write_table(path: Path, rows: Iterable[Row]) -> None:
    rows = iter(rows)
    first = next(rows)
    with closing(TableFile(path, list(first))) as table:
        table.add(first)
        for row in rows:
            table.add(row)


def _error_row(name: str, look: int | None, mean: float, deviation: float | None) -> Row:
    return {"strategy": name, "look": look, "error": mean, "standard_deviation": deviation}


def _interval(intervals: Mapping[str, tuple[float, float] | None]) -> dict[str, float | None]:
    low, high = intervals.get("roc_auc") or (None, None)
    return {"auc_low": low, "auc_high": high}


def _after(looks: int, error: float | None) -> str:
    told = "" if error is None else f", error {error:.2f}"
    return f"{looks} look{'s' * (looks > 1)}{told}"


def _with_interval(row: Row) -> str:
    if row["low"] is None:
        return f"{row['value']:.3f}"
    return f"{row['value']:.3f} [{row['low']:.3f}, {row['high']:.3f}]"


def _mean(values: npt.NDArray[np.floating]) -> float | None:
    return float(values.mean()) if values.size else None


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
