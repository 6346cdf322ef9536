"""curiosight learn: the off-line model of a whole recording."""

from __future__ import annotations

from curiosight.cli import options
from curiosight.cli.talk import Talk, open_source, warn_of_problems
from curiosight.config import load_config, to_toml
from curiosight.experiments.exploring import MODEL
from curiosight.experiments.learning import OffLine
from curiosight.experiments.output import OutputFolder
from curiosight.viewing.live import announce_compilation


def learn(
    source: options.Source,
    seed: options.Seed = None,
    scene: options.Scene = None,
    threads: options.Threads = None,
    preset: options.Preset = None,
    config: options.ConfigFile = None,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
    json: options.Json = False,
) -> None:
    """Learn a whole recording at once: the off-line model, the least error to expect.

    Every frame gives up to 700 labelled pixels; where all together are more than the buffer's
    100 000, a uniformly random choice of that many is kept.
    """
    talk = Talk(quiet=quiet, as_json=json)
    settings = load_config(
        preset,
        config,
        {"run.seed": seed, "teacher.scene": scene, "run.n_threads": threads},
    )
    dataset = open_source(talk, source)
    folder = OutputFolder(out, "learn", overwrite=overwrite)
    with announce_compilation(talk.console):
        off_line = OffLine(settings, dataset)
        with talk.following("learn", len(dataset)) as shown:
            for _ in off_line:
                shown.advance()
        learner = off_line.finish()
    folder.write_text("config.toml", to_toml(settings))
    learner.save(folder.file(MODEL), {"source": dataset.name})
    summary = off_line.summary()
    folder.write_json("summary.json", summary)
    warn_of_problems(talk, off_line.problems, len(dataset))
    drawn, kept = summary["samples_drawn"], summary["samples_kept"]
    rows = {
        "frames": summary["frames"],
        "samples": drawn if drawn == kept else f"{kept} of {drawn}, chosen at random",
        "written to": folder.path,
    }
    talk.results("learn", rows, {**summary, "out": str(folder.path)})
