"""What overrides what: a preset, a file of settings, flags, and a model learned before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from curiosight.config.settings import PRESETS, Config, ForestConfig, LearnerConfig, Preset
from curiosight.config.toml import checked, read_toml, updated


def load_config(
    preset: str | None = None,
    path: Path | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Config:
    """Return a preset, changed by a TOML file, changed by overrides.

    preset: None = the file's, else `default`; one that the file contradicts is refused.
    overrides: "section.key" to value; None values are passed over.
    """
    config = Config.of_preset(preset or "default")
    if path is not None:
        table = read_toml(path)
        named = checked(table.get("preset", config.preset), Preset, path, "preset")
        if preset is not None and named != preset:
            raise ValueError(f"preset: {path} starts from {named!r}; drop one of the two")
        config = config_of({**table, "preset": named}, path)
    for name, value in (overrides or {}).items():
        if value is not None:
            section, _, key = name.partition(".")
            if not hasattr(getattr(config, section, None), key):
                raise ValueError(f"overrides: expected a key like explorer.n_steps, got {name!r}")
            changed = replace(getattr(config, section), **{key: value})
            config = replace(config, **{section: changed})
    return config


def config_of(table: Mapping[str, Any], path: Path) -> Config:
    """Return what a table of TOML says over its preset; path: of its file, for what is refused."""
    named = checked(table.get("preset", "default"), Preset, path, "preset")
    rest = {key: value for key, value in table.items() if key != "preset"}
    config: Config = updated(Config.of_preset(named), rest, path, "")
    return config


def with_model(config: Config, learner: LearnerConfig, forest: ForestConfig) -> Config:
    """Return a config with the settings of a model that was learned before.

    It is called after the preset that the model is of, where it is of one.
    """
    made = {preset: Config.of_preset(preset) for preset in PRESETS}
    matching = [p for p, c in made.items() if (c.learner, c.forest) == (learner, forest)]
    preset = matching[0] if matching else config.preset
    return replace(config, preset=preset, learner=learner, forest=forest)
