"""figures: the paper's figures of any source, with their numbers; what it cannot give is said."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from command import call, files, refusal, succeed
from curiosight.cli.app import run
from curiosight.config import load_config
from curiosight.experiments.paper_figures.from_above import ViewsFromAbove
from curiosight.explorer.from_above import seen_from_above
from curiosight.worlds.sources import open_source
from recordings import write_folder, write_image

Capsys = pytest.CaptureFixture[str]
NUMBERS = range(2, 9)
ALL_FILES = {f"figure-{n}.{ending}" for n in NUMBERS for ending in ("svg", "pdf", "csv")}
# Frames of the tests are too small for GBVS.
METHODS = ("ours", "bms", "vocus2", "depth")
QUICK = ("--seeds", "2", "--steps", "4", "--workers", "1", "--regions", "time:2")
STRATEGIES = ("chronological", "random", "iac")


def table(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def drawn(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All figures of a recording; not to be written to."""
    out = tmp_path_factory.mktemp("figures") / "out"
    assert run(["figures", str(room), "--all", *QUICK, "--quiet", "--out", str(out)]) == 0
    return out


def test_all_figures_are_vectors_with_their_numbers(drawn: Path) -> None:
    assert files(drawn) == ALL_FILES | {"claims.csv", "config.toml"}
    for number in NUMBERS:
        assert (drawn / f"figure-{number}.svg").read_bytes().startswith(b"<?xml")
        assert (drawn / f"figure-{number}.pdf").read_bytes().startswith(b"%PDF")


def test_the_same_seed_gives_the_same_bytes(
    capsys: Capsys, room: Path, drawn: Path, tmp_path: Path
) -> None:
    told = succeed(capsys, "figures", room, "--figure", "2…8", *QUICK, "--out", tmp_path / "again")
    assert "gbvs" in told.err
    for name in sorted(ALL_FILES | {"claims.csv"}):
        assert (tmp_path / "again" / name).read_bytes() == (drawn / name).read_bytes(), name


def test_examples_tell_what_depth_says_of_each_pixel(drawn: Path) -> None:
    rows = table(drawn, "figure-2.csv")
    assert [row["id"] for row in rows] == ["000000", "000004"]
    for row in rows:
        shares = [float(value) for name, value in row.items() if name.startswith("depth_says")]
        assert len(shares) == 4
        assert sum(shares) == pytest.approx(1, abs=1e-5)


def test_roc_curves_go_from_corner_to_corner(drawn: Path) -> None:
    points = defaultdict(list)
    for row in table(drawn, "figure-3.csv"):
        rates = float(row["false_positive_rate"]), float(row["true_positive_rate"])
        points[row["method"]].append(rates)
    assert set(points) == set(METHODS)
    for curve in points.values():
        assert (curve[0], curve[-1]) == ((0, 0), (1, 1))
        assert curve == sorted(curve)


def test_maps_are_shown_of_all_methods(drawn: Path) -> None:
    shown = [(row["id"], row["method"]) for row in table(drawn, "figure-4.csv")]
    assert sorted(shown) == sorted((id, name) for id in ("000000", "000004") for name in METHODS)


def test_one_view_is_followed_to_the_last_look(drawn: Path) -> None:
    rows = table(drawn, "figure-5.csv")
    assert [row["looks"] for row in rows] == ["1", "2", "3"]
    assert len({row["id"] for row in rows}) == 1
    assert all(0 <= float(row["error"]) <= 1 for row in rows)


def test_errors_of_strategies_and_what_does_not_learn(drawn: Path) -> None:
    looks = defaultdict(list)
    for row in table(drawn, "figure-6.csv"):
        looks[row["strategy"]].append(row["look"])
        assert 0 <= float(row["error"]) <= 1
    each = {name: ["1", "2", "3", "4"] for name in STRATEGIES}
    assert looks == {**each, "off-line": [""], "bms": [""]}


def test_shares_of_time_sum_to_one(drawn: Path) -> None:
    sums: dict[tuple[str, ...], float] = defaultdict(float)
    for row in table(drawn, "figure-7.csv"):
        sums[row["strategy"], row["seed"], row["look"]] += float(row["share"])
    assert len(sums) == 2 * 2 * 4
    assert all(total == pytest.approx(1, abs=1e-5) for total in sums.values())


def test_trajectory_is_of_the_views_that_can_be_chosen(drawn: Path) -> None:
    rows = table(drawn, "figure-8.csv")
    assert [row["id"] for row in rows] == ["000002", "000006", "000007"]
    assert {row["region"] for row in rows} == {"slice 0", "slice 1"}
    assert all(row["x"] and row["y"] and row["heading_deg"] for row in rows)


def test_each_claim_is_told_with_its_answer(drawn: Path) -> None:
    claims = table(drawn, "claims.csv")
    assert {row["figure"] for row in claims} == {"3", "6", "7"}
    for row in claims:
        value = float(row["value"])
        low, high = (float(row[end] or value) for end in ("low", "high"))
        expected = "yes" if low > 0 else "no" if high <= 0 else "not clear"
        assert row["holds"] == expected


def test_what_a_source_cannot_give_is_said_and_the_others_are_made(
    capsys: Capsys, tmp_path: Path
) -> None:
    source = tmp_path / "bare"
    write_folder(source, 12, with_poses=False, with_ground_truth=False)
    told = call(capsys, "figures", source, "--figure", "2-4,8", *QUICK, "--out", tmp_path / "out")
    warnings = [line for line in told.err.splitlines() if line.startswith("warning: figure")]
    assert told.status == 0
    assert warnings == [
        "warning: figure 3: there is no ground truth to draw a ROC curve against",
        "warning: figure 8: there are no poses to be seen from above",
    ]
    made = {name for name in ALL_FILES if "-2." in name or "-4." in name}
    assert files(tmp_path / "out") == made | {"config.toml"}


def test_nothing_made_is_no_success(capsys: Capsys, tmp_path: Path) -> None:
    source = tmp_path / "bare"
    write_folder(source, 12, with_poses=False, with_ground_truth=False)
    told = call(capsys, "figures", source, "--figure", "8", "--quiet", "--out", tmp_path / "out")
    assert told.status == 2
    assert told.err == "warning: figure 8: there are no poses to be seen from above\n"
    assert not (tmp_path / "out").exists()


def test_where_nothing_is_salient_there_are_still_regions_from_above(
    capsys: Capsys, tmp_path: Path
) -> None:
    source, out = tmp_path / "empty", tmp_path / "out"
    views = write_folder(source, 20)
    for index, view in enumerate(views):
        write_image(source / f"ground_truth/{index:06d}.png", np.zeros_like(view.ground_truth))
    told = call(capsys, "figures", source, "--figure", "2,8", *QUICK, "--out", out)
    assert told.status == 0, told.err
    assert files(out) == {f"figure-8.{e}" for e in ("svg", "pdf", "csv")} | {"config.toml"}
    warnings = [line for line in told.err.splitlines() if line.startswith("warning: figure")]
    assert len(warnings) == 1
    assert "figure 2: " in warnings[0]
    assert "has no test frame with anything salient" in warnings[0]


def test_examples_are_frames_that_show_something(capsys: Capsys, tmp_path: Path) -> None:
    source, out = tmp_path / "few", tmp_path / "out"
    views = write_folder(source, 20)
    for index, view in enumerate(views):
        if index != 10:  # frames 0 and 10 are tested
            write_image(source / f"ground_truth/{index:06d}.png", 0 * view.ground_truth)
    succeed(capsys, "figures", source, "--figure", "2", *QUICK, "--out", out)
    assert [row["id"] for row in table(out, "figure-2.csv")] == ["000010"]


def test_views_of_a_drawn_room_are_joined_only_on_a_path() -> None:
    for source, is_way in (("room:5,views=4", False), ("room:5,views=4,path=orbit", True)):
        dataset = open_source(Path(source))
        views = ViewsFromAbove.of(load_config(None, None, {}), dataset, None)
        assert views.is_way is is_way
        (walls,) = views.outlines
        above = seen_from_above(views.poses, views.up).positions
        assert (walls.min(axis=0) < above.min(axis=0)).all()
        assert (above.max(axis=0) < walls.max(axis=0)).all()


def test_thing_that_is_seen_late_is_followed_in_a_drawn_room(
    capsys: Capsys, tmp_path: Path
) -> None:
    few = tmp_path / "few.toml"
    few.write_text("[test]\nmax_frames = 3\n", encoding="utf-8")
    options = ("--figure", "5", "--steps", "16", "--config", few)
    out = tmp_path / "out"
    succeed(capsys, "figures", "room:5,views=4", *options, "--out", out)
    rows = table(out, "figure-5.csv")
    first = int(rows[0]["thing_first_seen_at_look"])
    assert 1 <= first <= 4
    assert {str(max(1, first - 1)), "1", "2", "4"} <= {row["looks"] for row in rows}
    assert all(row["saliency_on_thing"] for row in rows)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ((), "figure: expected 2 to 8, or --all"),
        (("--figure", "9"), "figure: expected 2 to 8, got '9'"),
        (("--figure", "4-2"), "figure: expected 2 to 8, got '4-2'"),
        (("--figure", "roc"), "figure: expected 2 to 8, such as 2-4 or 2,6, got 'roc'"),
        (("--all", "--seeds", "0"), "seeds: expected 1 or more, got 0"),
        (("--all", "--steps", "0"), "steps: expected 1 or more, got 0"),
        (("--all", "--workers", "0"), "workers: expected 1 or more, got 0"),
        (("--all", "--regions", "pose:0"), "regions: expected"),
        (("--all", "--baselines", "bsm"), "baselines: expected"),
    ],
)
def test_wrong_options_are_refused_in_one_line(
    capsys: Capsys, room: Path, tmp_path: Path, options: tuple[str, ...], expected: str
) -> None:
    out = tmp_path / "out"
    assert expected in refusal(capsys, "figures", room, *options, "--quiet", "--out", out)
    assert not out.exists()
