"""curiosight bench --soak: does memory grow over many looks?"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from curiosight.cli.interrupt import CtrlC
from curiosight.cli.talk import Talk
from curiosight.config import Config
from curiosight.datasets import Dataset
from curiosight.experiments.output import OutputFolder, write_json_file
from curiosight.experiments.soaking import Soak
from curiosight.viewing.live import announce_compilation


def run_soak(talk: Talk, config: Config, dataset: Dataset, n_looks: int, json: Path | None) -> int:
    """Explore for so many looks in a folder of its own, tell the figures; return the status."""
    with tempfile.TemporaryDirectory(prefix="curiosight-soak-") as folder:
        out = OutputFolder(Path(folder) / "run", "soak", Path(folder) / "source")
        with announce_compilation(talk.console):
            soak = Soak(config, dataset, out, n_looks)
            with CtrlC() as ctrl_c, talk.following("soak", n_looks, "look") as shown:
                for _ in ctrl_c.until_pressed(soak):
                    shown.advance(_memory(soak))
        figures = soak.figures()
    if json is not None:
        write_json_file(json, figures)
    talk.results("soak", _rows(figures), figures)
    return ctrl_c.status


def _memory(soak: Soak) -> str:
    return f"{soak.readings[-1][1]:.0f} MB" if soak.readings else ""


def _rows(figures: dict[str, Any]) -> dict[str, Any]:
    readings, deviation = figures["resident_mb"], figures["deviation"]
    rows: dict[str, Any] = {
        "looks": figures["looks"],
        "image": figures["image"],
        "a look (ms)": figures["ms_a_look"],
    }
    if deviation is not None:
        rows["resident memory (MB)"] = f"{readings[0][1]:.0f}, at the end {readings[-1][1]:.0f}"
        rows["deviation"] = f"{100 * deviation:.1f} %"
    for name, size in figures["bytes"].items():
        a_look = figures["bytes_a_look"].get(name)
        rows[f"{name} (bytes)"] = f"{size}" + (f", {a_look:.0f} a look" if a_look else "")
    return rows
