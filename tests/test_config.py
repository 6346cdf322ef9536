"""Settings: presets, TOML, what overrides what, and what is refused."""

from __future__ import annotations

import re
import tomllib
from dataclasses import FrozenInstanceError, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curiosight.config import PRESETS, Config, load_config, to_toml
from curiosight.errors import DataError
from curiosight.experiments.components import choose_strategy, make_learner
from curiosight.frame import Viewpoint
from curiosight.learner.learner import SaliencyLearner


@pytest.fixture
def write(tmp_path: Path):
    def write_file(text: str) -> Path:
        path = tmp_path / "config.toml"
        path.write_text(text)
        return path

    return write_file


def test_paper_holds_the_papers_numbers() -> None:
    config = Config.of_preset("paper")
    learner, forest, explorer = config.learner, config.forest, config.explorer
    assert (learner.rows_per, learner.colour_space, learner.n_pixels) == ("pixel", "rgb", 700)
    assert not learner.contrast
    assert (forest.n_trees, forest.n_regrown, forest.share) == (30, 4, 0.7)
    assert forest.max_samples == 100_000
    assert (forest.max_depth, forest.min_split, forest.vote) == (10, 11, "hard")
    assert forest.n_split_features == 0
    assert (explorer.n_stay, explorer.random_share, explorer.theta) == (10, 0.25, 15)
    assert (explorer.smoothing, explorer.exponent, explorer.negative) == (1, 1.0, "clip")
    assert config == Config()


def test_range_is_that_of_the_teacher_that_is_used() -> None:
    paper, default = Config.of_preset("paper"), Config.of_preset("default")
    nearer = {
        "segmentation": replace(paper.segmentation, max_range=3.0),
        "paper_segmentation": replace(paper.paper_segmentation, max_range=2.0),
    }
    assert paper.max_range == default.max_range == 4.0
    assert replace(paper, **nearer).max_range == 2.0
    assert replace(default, **nearer).max_range == 3.0


def test_default_differs_from_paper_only_where_it_says() -> None:
    def numbers(preset: str) -> dict[str, Any]:
        table = tomllib.loads(to_toml(Config.of_preset(preset)))
        del table["preset"]
        return flat(table)

    paper, default = numbers("paper"), numbers("default")
    assert {key: value for key, value in default.items() if value != paper[key]} == {
        "learner.rows_per": "superpixel",
        "learner.colour_space": "lab",
        "learner.features": "surroundings+texture+height",
        "learner.superpixels": "cells",
        "learner.n_superpixels": 1500,
        "learner.blind_share": 0.02,
        "learner.salient_share": 0.5,
        "learner.max_places": 16,
        "learner.is_calibrated": True,
        "learner.follow_edges": True,
        "learner.edge_stride": 2,
        "segmentation.follow_sensor": True,
        "teacher.pipeline": "default",
        "teacher.temporal": True,
        "forest.max_depth": 24,
        "forest.n_regrown": 2,
        "forest.share": 0.9,
        "forest.min_split": 20,
        "forest.leaf_share": 0.002,
        "forest.n_split_features": 12,
        "forest.max_rows": 16_000,
        "forest.vote": "soft",
    }


def flat(table: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables as one, of dotted keys."""
    keys: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{prefix}{key}"
        keys |= flat(value, name + ".") if isinstance(value, dict) else {name: value}
    return keys


@pytest.mark.parametrize("preset", PRESETS)
def test_library_defaults_are_the_papers(preset: str) -> None:
    """The components' own defaults and the preset `paper` must not drift apart."""
    made = make_learner(Config.of_preset(preset), None, np.random.default_rng(0))
    plain = SaliencyLearner()
    is_same = made.forest.settings() == plain.forest.settings()
    assert is_same == (preset == "paper")
    assert (made.describer.rows_per == plain.describer.rows_per) == (preset == "paper")
    assert (made.describer.features == plain.describer.features) == (preset == "paper")
    assert (made.describer.superpixels == plain.describer.superpixels) == (preset == "paper")
    assert made.n_pixels == plain.n_pixels


@pytest.mark.parametrize("preset", PRESETS)
def test_toml_comes_back_as_it_was(preset: str, write) -> None:
    config = Config.of_preset(preset)
    assert load_config(path=write(to_toml(config))) == config
    changed = replace(
        config,
        forest=replace(config.forest, n_trees=7, share=1e-05),
        explorer=replace(config.explorer, regions='C:\\my "rooms"\nü.csv', exponent=3.0),
        run=replace(config.run, seed=2**40),
    )
    assert load_config(path=write(to_toml(changed))) == changed


@given(text=st.text(st.characters(codec="utf-8")), number=st.floats(allow_nan=False))
@settings(max_examples=40, deadline=None)
def test_any_text_and_number_can_be_written(text: str, number: float) -> None:
    config = Config()
    config = replace(config, explorer=replace(config.explorer, regions=text, exponent=number))
    read = tomllib.loads(to_toml(config))["explorer"]
    assert (read["regions"], read["exponent"]) == (text, number)


def test_every_setting_is_written() -> None:
    def keys(section: Any, prefix: str = "") -> set[str]:
        found: set[str] = set()
        for entry in fields(section):
            value, name = getattr(section, entry.name), f"{prefix}{entry.name}"
            found |= keys(value, name + ".") if is_dataclass(value) else {name}
        return found

    config = Config.of_preset("default")
    assert set(flat(tomllib.loads(to_toml(config)))) == keys(config)


def test_flags_go_over_the_file_and_the_file_over_the_preset(write) -> None:
    path = write('preset = "paper"\n[forest]\nn_trees = 8\nmax_depth = 5\n')
    config = load_config(path=path, overrides={"forest.n_trees": 9, "forest.share": None})
    assert (config.forest.n_trees, config.forest.max_depth) == (9, 5)
    assert config.forest.share == 0.7
    assert (config.preset, config.learner.rows_per) == ("paper", "pixel")
    assert load_config("paper", path) == load_config(path=path)
    with pytest.raises(ValueError, match=r"preset: .* starts from 'paper'; drop one"):
        load_config("default", path)


@pytest.mark.parametrize("name", ["explorer.stratgy", "explor.n_steps", "n_steps"])
def test_overrides_must_name_a_setting(name: str) -> None:
    with pytest.raises(ValueError, match="overrides: expected a key like"):
        load_config(overrides={name: 1})


def test_without_anything_it_is_the_default_preset(write) -> None:
    assert load_config() == load_config(path=write("")) == Config.of_preset("default")
    assert load_config("paper") == Config.of_preset("paper")


def test_whole_numbers_do_for_fractions(write) -> None:
    config = load_config(path=write("[explorer]\nexponent = 2\n"))
    assert isinstance(config.explorer.exponent, float)
    assert config.explorer.exponent == 2


@pytest.mark.parametrize(
    ("text", "found", "remedy"),
    [
        ("prest = 'paper'", "unknown key `prest`", "did you mean `preset`?"),
        ("[lerner]\nn_pixels = 5", "unknown key `lerner`", "did you mean `learner`?"),
        ("[forest]\nn_tres = 5", "unknown key `forest.n_tres`", "`forest.n_trees`?"),
        ("[teacher]\nsene = 'floor'", "unknown key `teacher.sene`", "`teacher.scene`?"),
        ("[forest]\nn_trees = 'many'", "`forest.n_trees` is 'many'", "expected int"),
        ("[forest]\nn_trees = 7.5", "`forest.n_trees` is 7.5", "expected int"),
        ("[forest]\nn_trees = true", "`forest.n_trees` is True", "expected int"),
        ("[learner]\ncontrast = 1", "`learner.contrast` is 1", "expected bool"),
        ("[forest]\nshare = '70%'", "`forest.share` is '70%'", "expected float"),
        ("[forest]\nvote = 'loud'", "`forest.vote` is 'loud'", "use one of 'hard', 'soft'"),
        ("[forest]\nvote = 1", "`forest.vote` is 1", "use one of 'hard', 'soft'"),
        ("[explorer]\nregions = 5", "`explorer.regions` is 5", "expected str"),
        ("forest = 30", "`forest` is 30", "write a section [forest]"),
        ("preset = 'fast'", "`preset` is 'fast'", "use one of 'default', 'paper'"),
        ("preset = 3", "`preset` is 3", "use one of 'default', 'paper'"),
        ("[forest\nn_trees = 5", "is no TOML", "mend that line"),
        ("[explorer]\nn_steps = 0", "[explorer] n_steps: expected 1 or more", "that value"),
        ("[run]\nn_threads = -1", "[run] n_threads: expected 1 or more", "that value"),
        ("[teacher]\npipeline = 'ours'", "`teacher.pipeline` is 'ours'", "'paper', 'default'"),
        ("[teacher]\npipeline = 'paper'", "[teacher] temporal: expected false", "that value"),
        ("[paper_segmentation.table]\nleaf = 0", "[paper_segmentation.table] leaf", "that value"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(write, text: str, found: str, remedy: str) -> None:
    path = write(text)
    with pytest.raises(DataError, match=re.escape(found)) as caught:
        load_config(path=path)
    assert caught.value.path == path
    assert remedy in caught.value.remedy


def test_unreadable_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="cannot be read"):
        load_config(path=tmp_path / "none.toml")
    with pytest.raises(DataError, match="cannot be read"):
        load_config(path=tmp_path)
    (tmp_path / "latin1.toml").write_bytes(b"x = '\xe9'")
    with pytest.raises(DataError, match="is no TOML"):
        load_config(path=tmp_path / "latin1.toml")


def test_an_unknown_preset_is_named() -> None:
    with pytest.raises(ValueError, match="preset: expected default or paper, got 'fast'"):
        load_config("fast")


def test_settings_cannot_be_changed_by_accident() -> None:
    config = Config()
    with pytest.raises(FrozenInstanceError):
        config.forest.n_trees = 5  # type: ignore[misc]
    with pytest.raises((AttributeError, TypeError)):
        config.forrest = None  # type: ignore[attr-defined]


@pytest.mark.parametrize("section", ["learner", "forest"])
def test_every_setting_of_the_learner_reaches_it(section: str) -> None:
    """A setting that changes nothing would be a lie in the saved config.toml."""
    other: dict[str, Any] = {
        "rows_per": "superpixel",
        "colour_space": "lab",
        "contrast": True,
        "features": "surroundings",
        "superpixels": "cells",
        "edge_stride": 3,
        "n_superpixels": 333,
        "n_pixels": 77,
        "blind_share": 0.1,
        "salient_share": 0.3,
        "max_places": 5,
        "is_calibrated": True,
        "follow_edges": True,
        "threshold": 0.4,
        "n_trees": 5,
        "n_regrown": 2,
        "share": 0.5,
        "max_samples": 999,
        "max_depth": 3,
        "min_split": 50,
        "n_split_features": 6,
        "n_levels": 64,
        "leaf_share": 0.01,
        "max_rows": 500,
        "vote": "soft",
    }

    def state(config: Config) -> tuple[object, ...]:
        learner = make_learner(config, None, np.random.default_rng(0))
        features = learner.describer.definition()
        edges = learner.follow_edges, learner.edge_stride
        options = (learner.n_pixels, learner.blind_share, learner.salient_share, learner.threshold)
        places = learner.experts.places
        parts = (places and places.settings(), learner.calibration is not None)
        return options, edges, features, parts, learner.forest.settings()

    config = Config()
    for entry in fields(getattr(config, section)):
        changes = {entry.name: other[entry.name]}
        changed = replace(config, **{section: replace(getattr(config, section), **changes)})
        assert state(changed) != state(config), entry.name


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("n_stay", 0),
        ("n_warm_up", -1),
        ("random_share", 2.0),
        ("theta", 1),
        ("smoothing", 0),
        ("min_errors", 1),
        ("undefined", "ignore"),
        ("negative", "drop"),
        ("exponent", -1.0),
        ("progress", "sideways"),
    ],
)
def test_every_setting_of_the_explorer_reaches_the_strategy(key: str, value: Any) -> None:
    config = load_config(overrides={f"explorer.{key}": value, "explorer.strategy": "iac"})
    views = (Viewpoint(0, 0), Viewpoint(1, 1))
    with pytest.raises(ValueError, match=rf"{key}.*: expected"):
        choose_strategy(config, views, np.random.default_rng(0))


def test_unknown_strategies_are_refused_with_the_nearest_name(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"strategy: expected .*, got 'ica'; did you mean iac\?"):
        load_config(overrides={"explorer.strategy": "ica"})
    path = tmp_path / "mine.toml"
    path.write_text('[explorer]\nstrategy = "covrage"\n', encoding="utf-8")
    with pytest.raises(DataError, match=r"\[explorer\] strategy: .*did you mean coverage\?"):
        load_config(path=path)
    for name in ("sweep:3", "rl-iac:sampled", "oracle", "my_package.looking:Around"):
        assert load_config(overrides={"explorer.strategy": name}).explorer.strategy == name
