"""Bottom-up saliency: what pops out of an image, with nothing learned.

Each method is a function of an image, (H, W, 3) uint8, red first, that returns its map, (H, W)
float32 in [0, 1]. Its options are those of its original, and so are their defaults.
"""

from __future__ import annotations

from collections.abc import Callable

from curiosight.evaluation.baselines.bms import bms, bms_fixation, bms_rliac
from curiosight.evaluation.baselines.bms_pami import bms_pami
from curiosight.evaluation.baselines.frequency_tuned import frequency_tuned
from curiosight.evaluation.baselines.gbvs import gbvs, gbvs_fast
from curiosight.evaluation.baselines.itti import itti
from curiosight.evaluation.baselines.maps import Saliency
from curiosight.evaluation.baselines.minimum_barrier import mb, mbplus
from curiosight.evaluation.baselines.opencv import fine_grained
from curiosight.evaluation.baselines.spectral_residual import spectral_residual
from curiosight.evaluation.baselines.vocus2 import vocus2_coffee, vocus2_kitchen, vocus2_msra
from curiosight.frame import Rgb

METHODS: dict[str, Callable[[Rgb], Saliency]] = {
    "bms": bms,
    "bms-fixation": bms_fixation,
    "bms-pami": bms_pami,
    "bms-rliac": bms_rliac,
    "gbvs": gbvs,
    "gbvs-fast": gbvs_fast,
    "vocus2": vocus2_coffee,
    "vocus2-kitchen": vocus2_kitchen,
    "vocus2-msra": vocus2_msra,
    "itti": itti,
    "mb": mb,
    "mbplus": mbplus,
    "spectral-residual": spectral_residual,
    "frequency-tuned": frequency_tuned,
    "fine-grained": fine_grained,
}

__all__ = ["METHODS", "Saliency", "fine_grained", "spectral_residual"]
