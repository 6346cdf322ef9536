"""Where to look next, as Gymnasium environments (extra `curiosight[gym]`, docs/gym.md).

Importing this registers them: `gymnasium.make("curiosight.gym:curiosight/Look-v0", source=…)`.
"""

from __future__ import annotations

# Over regions, and over viewpoints.
IDS = {"curiosight/Look-v0": "LookEnv", "curiosight/LookView-v0": "LookViewEnv"}


def _register() -> None:
    try:
        import gymnasium
    except ImportError as error:
        raise ImportError(
            "curiosight.gym needs gymnasium: pip install 'curiosight[gym]'"
        ) from error
    for name, environment in IDS.items():
        if name not in gymnasium.registry:
            entry_point = f"curiosight.gym.environment:{environment}"
            gymnasium.register(id=name, entry_point=entry_point)


_register()
