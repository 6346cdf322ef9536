"""Draw the paper's figures of one source, as far as it can give them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from curiosight.cli.evaluate_report import failures
from curiosight.cli.figures_files import CannotDrawError, FigureFiles, Row
from curiosight.cli.figures_of_maps import (
    draw_evolution,
    draw_examples,
    draw_maps,
    draw_roc_curves,
)
from curiosight.cli.figures_of_strategies import (
    draw_regions,
    draw_strategies,
    draw_time_in_regions,
)
from curiosight.cli.talk import Talk
from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.experiments.comparing import Comparison, Methods
from curiosight.experiments.contest.contest import Contest
from curiosight.experiments.contest.runs import RunRecord
from curiosight.experiments.contest.table import Curve, curves_of
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.paper_figures.claims import Claim, claims_of_evolution
from curiosight.experiments.paper_figures.evolution import choose_target, evolve
from curiosight.experiments.paper_figures.from_above import ViewsFromAbove
from curiosight.experiments.paper_figures.subject import Subject

TIMED = ("random", "iac")  # whose time in regions is shown


class Drawing:
    """The figures of one source.

    config: as it is prepared with. subject: None where it could not be prepared, for the
    reason that `problem` says. is_stopped: asked frame by frame; then no more is drawn.
    claims: of the figures drawn so far.
    """

    def __init__(
        self, talk: Talk, folder: OutputFolder, config: Config, dataset: Dataset, methods: Methods
    ) -> None:
        self._talk, self._methods = talk, methods
        self._files = FigureFiles(folder)
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

    def _examples(self) -> None:
        draw_examples(self._prepared(), self._files)

    def _roc(self) -> None:
        subject = self._prepared()
        if not subject.has_truth:
            raise CannotDrawError("there is no ground truth to draw a ROC curve against")
        self.claims += draw_roc_curves(subject, self._compared(), self._files)

    def _wall(self) -> None:
        draw_maps(self._compared(), self._files)

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

    def _evolution(self) -> None:
        subject = self._prepared()
        target = choose_target(subject)
        shots = []
        with self._talk.following("one view", len(subject.prepared.ids), "look") as progress:
            for shot in evolve(subject, target):
                self._check_going_on()
                progress.advance()
                if shot is not None:
                    shots.append(shot)
        draw_evolution(target, shots, has_truth=subject.has_truth, files=self._files)
        threshold = self.config.learner.threshold
        self.claims += claims_of_evolution(target, shots, threshold)

    def _errors(self) -> None:
        subject = self._prepared()
        self._check_runs()
        self.claims += draw_strategies(subject, self._curves, self._files)

    def _times(self) -> None:
        self._prepared()
        self._check_runs()
        self.claims += draw_time_in_regions(self._runs, self.config.run.seed, self._files)

    def _check_runs(self) -> None:
        if not self._runs:
            raise CannotDrawError("not all runs of the strategies are done")

    def _regions(self) -> None:
        prepared = None if self.subject is None else self.subject.prepared
        draw_regions(ViewsFromAbove.of(self.config, self.dataset, prepared), self._files)

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
            self._files.write_table("claims.csv", self.claims_table())

    def told(self) -> dict[str, str]:
        """Return the claims for a person."""
        return {
            f"fig. {row['figure']}: {row['claim']}": f"{row['holds']}, {_with_interval(row)}"
            for row in self.claims_table()
        }


def _with_interval(row: Row) -> str:
    if row["low"] is None:
        return f"{row['value']:.3f}"
    return f"{row['value']:.3f} [{row['low']:.3f}, {row['high']:.3f}]"
