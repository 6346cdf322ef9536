"""Every setting of a run in one place: two presets, a TOML file, and what overrides what."""

from curiosight.config.loading import load_config, with_model
from curiosight.config.settings import (
    PRESETS,
    Config,
    ForestConfig,
    LearnerConfig,
    Preset,
    TeacherConfig,
)
from curiosight.config.toml import to_toml

__all__ = [
    "PRESETS",
    "Config",
    "ForestConfig",
    "LearnerConfig",
    "Preset",
    "TeacherConfig",
    "load_config",
    "to_toml",
    "with_model",
]
