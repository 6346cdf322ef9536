"""What the segmentation of a recording tells at its end."""

from __future__ import annotations

from pathlib import Path

import pytest

from curiosight.config import load_config
from curiosight.datasets import open_dataset
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.segmenting import Segmenting


@pytest.mark.parametrize(
    "order", [("floor", "table", "furniture"), ("furniture", "table", "floor")]
)
def test_supports_are_told_in_the_same_order_however_they_were_found(
    order: tuple[str, ...], room: Path, tmp_path: Path
) -> None:
    folder = OutputFolder(tmp_path / "out", "segment", room)
    segmenting = Segmenting(load_config(), open_dataset(room), folder)
    for kind in order:
        segmenting._n_showing.update({kind: 1 if kind == "furniture" else 2})
    told = segmenting.finish()["supports"]
    assert list(told.items()) == [("floor", 2), ("table", 2), ("furniture", 1)]
