"""Curves of a contest: what is quick can be told apart beside what is slow."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from curiosight.viewing.contest import figures


@pytest.mark.parametrize(
    ("slowest", "scale", "left"), [(390.0, "linear", 0.0), (4000.0, "log", 5.0)]
)
def test_axis_is_logarithmic_where_one_takes_many_times_as_long(
    slowest, scale, left, tmp_path, monkeypatch
):
    drawn = []
    monkeypatch.setattr(figures, "save_figure", lambda figure, _: drawn.append(figure))
    ends = {"quick": 100.0, "slow": slowest}
    bands = {
        name: SimpleNamespace(x=np.array([1, end]), mean=np.ones(2), deviation=np.zeros(2))
        for name, end in ends.items()
    }
    figures.draw_errors(bands, 0.3, "seconds", tmp_path / "a.png")
    (axes,) = drawn[0].axes
    assert axes.get_xscale() == scale
    assert axes.get_xlim() == (left, slowest)
