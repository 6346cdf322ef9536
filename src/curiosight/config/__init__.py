"""Every setting of a run in one place: two presets, a TOML file, and what overrides what."""

from curiosight.config.loading import config_of, load_config, with_model
from curiosight.config.settings import (
    PRESETS,
    Config,
    ForestConfig,
    LearnerConfig,
    Preset,
    TeacherConfig,
)
from curiosight.config.toml import read_toml, to_toml, toml_value

__all__ = [
    "PRESETS",
    "Config",
    "ForestConfig",
    "LearnerConfig",
    "Preset",
    "TeacherConfig",
    "config_of",
    "load_config",
    "read_toml",
    "to_toml",
    "toml_value",
    "with_model",
]
