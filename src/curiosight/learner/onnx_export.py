"""Export what was learned as an ONNX file: forests, their mean, and the threshold at one half.

Nothing but this program is needed to write it; any ONNX runtime that knows `ai.onnx.ml` runs it.
"""

from __future__ import annotations

import json
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.errors.files import replace_file
from curiosight.learner.experts import COMMON
from curiosight.learner.features.describer import Describer
from curiosight.learner.features.sets import COLOURS, CONTRAST, HEIGHT, ITTI, SURROUNDINGS, TEXTURE
from curiosight.learner.forest import Forest
from curiosight.learner.learner import SaliencyLearner
from curiosight.learner.onnx_messages import constant, model, node, value

OPERATORS = {"": 17, "ai.onnx.ml": 3}
NOT_INCLUDED = (
    "superpixels and features of an image; which place a view shows, from its pose or look, which "
    "gives `weights`; probabilities; maps that follow edges; fusing with depth; uncertainty; "
    "the samples, so it cannot learn on"
)
_SAID = "The saliency of superpixels, learned by curiosight. See the metadata for its features."
_NODE = ("nodes_treeids", "nodes_nodeids", "nodes_featureids")
# What 0 to 255 mean in the columns of a set; docs/features.md tells more.
UNITS = {
    COLOURS: "8-bit value of the channel, mean over the superpixel at that place",
    CONTRAST: "difference of 8-bit values + 128, cut at 0 and 255; deviation: 2 standard ones",
    SURROUNDINGS: "8-bit values, differences + 128, deviations times 2; patterns are bits",
    TEXTURE: "deviation times 2; gradient: 16 times its root; directions: 128 is both alike",
    HEIGHT: "rows from the top of the image, 255 is the bottom",
    ITTI: "8-bit value of the conspicuity map, 255 is its maximum",
}
_OWN = "whole number, as the set of features gives it"


def export_onnx(learner: SaliencyLearner, path: Path | str) -> dict[str, str]:
    """Write the forests of a learner as an ONNX file; return its metadata.

    Inputs: `rows` (n, F) float32, the 8-bit features in the order of the metadata's `features`,
    and, where there are several forests, `weights` (k,) float32 that sum up to 1, of each in the
    order of `forests`. Outputs, (n, 1) float32: `votes`, the mean of the trees, and `saliency`,
    votes scaled so that the threshold is 0.5 where the learner is calibrated. These are what
    `vote` and `predict` return, but for rounding; what is not included, `not_included` says.

    Raises `ValueError` while nothing was learned, `DataError` where the file cannot be written.
    """
    forests = {key: one for key, one in learner.experts.forests().items() if one.is_trained}
    if not forests:
        raise ValueError("learner: expected one that has learned something, got an untrained one")
    nodes = [_trees(forest, f"votes_{place}") for place, forest in enumerate(forests.values())]
    names = [f"votes_{place}" for place in range(len(forests))]
    constants: list[bytes] = []
    inputs = [value("rows", ("n", learner.describer.n_features), "features, whole, 0 to 255")]
    if len(forests) == 1:
        nodes.append(node("Identity", names, "votes"))
    else:
        inputs.append(value("weights", (len(forests),), "how much each forest counts, in all 1"))
        constants.append(constant("column", np.array([len(forests), 1], np.int64)))
        nodes.append(node("Concat", names, "of_each", {"axis": 1}))
        nodes.append(node("Reshape", ("weights", "column"), "weight_of_each"))
        nodes.append(node("MatMul", ("of_each", "weight_of_each"), "votes"))
    threshold = 0.5 if learner.calibration is None else learner.calibration.threshold
    scaling = _scaling(np.float32(threshold))
    nodes += scaling[0]
    constants += scaling[1]
    facts = _facts(learner, list(forests), threshold)
    outputs = [
        value("votes", ("n", 1), "mean vote of the trees, 0 to 1"),
        value("saliency", ("n", 1), "0 to 1; the metadata tell from where it is salient"),
    ]
    content = model(
        nodes,
        constants,
        inputs,
        outputs,
        operators=OPERATORS,
        producer=("curiosight", facts["version"]),
        said=_SAID,
        facts=facts,
    )
    replace_file(Path(path), content)
    return facts


def _trees(forest: Forest, output: str) -> bytes:
    """Return the step that gives the mean vote of a forest's trees."""
    arrays = forest.state_arrays()
    sizes = arrays["tree_sizes"].astype(np.int64)
    tree = np.repeat(np.arange(len(sizes)), sizes)
    place = np.arange(len(tree)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    left = arrays["node_left_children"].astype(np.int64)
    is_leaf = left == place
    votes = arrays["node_values"].astype(np.float32)
    if forest.vote == "hard":
        votes = (votes > 0.5).astype(np.float32)
    features = np.where(is_leaf, 0, arrays["node_features"]).astype(np.int64)
    attributes: dict[str, Any] = dict(zip(_NODE, (tree, place, features), strict=True))
    attributes |= {
        "nodes_modes": np.where(is_leaf, "LEAF", "BRANCH_LEQ").tolist(),
        "nodes_values": np.where(is_leaf, 0, arrays["node_thresholds"]).astype(np.float32),
        "nodes_truenodeids": np.where(is_leaf, 0, left),
        "nodes_falsenodeids": np.where(is_leaf, 0, left + 1),
        "target_treeids": tree[is_leaf],
        "target_nodeids": place[is_leaf],
        "target_ids": np.zeros(int(is_leaf.sum()), np.int64),
        "target_weights": votes[is_leaf],
        "n_targets": 1,
        "aggregate_function": "AVERAGE",
        "post_transform": "NONE",
    }
    return node("TreeEnsembleRegressor", ["rows"], output, attributes, domain="ai.onnx.ml")


def _scaling(threshold: np.float32) -> tuple[list[bytes], list[bytes]]:
    """Return the steps from votes to saliency, see `Calibration.scaled`, and their constants."""
    half, one = np.float32(0.5), np.float32(1)
    numbers: dict[str, npt.NDArray[np.float32]] = {
        "threshold": np.array(threshold, np.float32),
        "half": np.array(half, np.float32),
        "below_slope": np.array(half / threshold, np.float32),
        "above_slope": np.array(half / (one - threshold), np.float32),
    }
    nodes = [
        node("Less", ("votes", "threshold"), "is_below"),
        node("Mul", ("votes", "below_slope"), "below"),
        node("Sub", ("votes", "threshold"), "over"),
        node("Mul", ("over", "above_slope"), "over_scaled"),
        node("Add", ("over_scaled", "half"), "above"),
        node("Where", ("is_below", "below", "above"), "saliency"),
    ]
    return nodes, [constant(name, number) for name, number in numbers.items()]


def _facts(learner: SaliencyLearner, forests: list[int], threshold: float) -> dict[str, str]:
    try:
        ours = version("curiosight")
    except PackageNotFoundError:
        ours = "unknown"
    names = ["everywhere" if key == COMMON else f"place {key}" for key in forests]
    return {
        "version": ours,
        "features": json.dumps(_columns(learner.describer)),
        "superpixels": json.dumps(learner.describer.definition()),
        "forests": json.dumps(names),
        "threshold": repr(float(threshold)),
        "salient_from": repr(float(learner.threshold)),
        "not_included": NOT_INCLUDED,
    }


def _columns(describer: Describer) -> list[dict[str, Any]]:
    """Return of each column its index, name, set, colour space, and what its numbers are."""
    columns: list[dict[str, Any]] = []
    for one in describer.sets:
        unit = UNITS.get(one.name, _OWN)
        for name in one.columns:
            columns.append(
                {
                    "index": len(columns),
                    "name": name,
                    "set": one.name,
                    "colour_space": one.colour_space,
                    "unit": unit,
                }
            )
    return columns
