"""What `curiosight watch` does once its page answers: prepare, run, keep."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from curiosight.cli.interrupt import CtrlC
from curiosight.cli.lessons import LEARNED_NOTHING_STATUS, tell_alarms, tell_lessons
from curiosight.cli.resume import go_on_with, open_watch, read_summary
from curiosight.cli.talk import Talk, count
from curiosight.cli.watch_sinks import SinksAsked, SinkTrouble, recorded
from curiosight.config import Config, load_config
from curiosight.datasets import Dataset
from curiosight.errors import DataError
from curiosight.experiments.camera_start import BEGUN, Begun, FirstFrames, for_camera, open_live
from curiosight.experiments.command_file import GivenWatch
from curiosight.experiments.driving import DrawnDrive, parse_drawn, plan_drive
from curiosight.experiments.exploring import CONFIG, load_run_model
from curiosight.experiments.live_page import LivePage
from curiosight.experiments.output import OutputFolder
from curiosight.experiments.watch_keeping import WatchKeeper, check_kept
from curiosight.experiments.watch_parts import Asked, check_regions
from curiosight.experiments.watching import Watching
from curiosight.rooms import DrawnViews
from curiosight.viewing.live import announce_compilation
from curiosight.worlds import is_drawn, open_source
from curiosight.worlds.sources import check_drawn, is_camera

# Between two lines of a run that nobody looks at in a terminal.
LINE_EVERY_S = 5.0


def run_watch(
    talk: Talk,
    live: LivePage,
    config: Config,
    given: GivenWatch,
    folder: OutputFolder,
    sinks: SinksAsked,
    strategy: str | None,
) -> int:
    """Begin a watch; else as `_watch`. strategy: see `Asked`."""
    source = Path(given.source)
    opened = sinks.open(source)
    model = None if given.from_ is None else Path(given.from_)
    asked = Asked(model, is_learning=given.learn, strategy=strategy, sinks=opened)
    if asked.model is not None:
        load_run_model(asked.model)  # a wrong one is refused before anything is drawn
    check_regions(config)
    config = for_camera(config) if is_camera(source) else config
    return _watch(talk, live, config, given, folder, asked, is_resumed=False)


def resume_watch(talk: Talk, live: LivePage, run: Path, sinks: SinksAsked) -> int:
    """Go on with a watch, or say that it is over; else as `_watch`."""
    given, folder = open_watch(run)
    settings, summary = load_config(None, run / CONFIG, {}), read_summary(run)
    ended = None if summary is None else summary.get("ended")
    if summary is not None and ended is not None:
        looks = count(summary["looks"], "look")
        talk.note(f"{run}: the watch is finished after {looks}: {ended}")
        return 0
    check_kept(run)
    model = None if given.from_ is None else Path(given.from_)
    asked = Asked(
        model,
        is_learning=given.learn,
        strategy=settings.explorer.strategy,
        sinks=sinks.open(Path(given.source)),
    )
    return _watch(talk, live, settings, given, folder, asked, is_resumed=True)


def _watch(
    talk: Talk,
    live: LivePage,
    config: Config,
    given: GivenWatch,
    folder: OutputFolder,
    asked: Asked,
    *,
    is_resumed: bool,
) -> int:
    """Watch until it is to end, keep everything, tell the results; return the exit status."""
    source = Path(given.source)
    lost = None
    with ExitStack() as stack, announce_compilation(talk.console):
        begun = _begun(folder, given) if is_resumed and is_camera(source) else None
        dataset, drawn = _open(talk, live, config, source, asked, stack, begun)
        live.say("surveying what is to be seen")
        run = Watching(
            config, dataset, folder, asked, drawn=drawn, given=given, is_resumed=is_resumed
        )
        if drawn is None:
            _tell_page(talk, live)
        _introduce(talk, run, source, dataset)
        live.show(run.shown)
        with CtrlC() as ctrl_c:
            try:
                _follow(talk, run, given.seconds, ctrl_c)
            except DataError as error:
                lost = error  # said when all is told
            finally:  # whatever happens, what was learned is kept
                summary = run.finish()
    if run.ended is not None and not run.seconds:
        lost = DataError(dataset.name, "was at its end before the first map", "give a longer one")
    if lost is not None and not run.seconds:
        raise lost
    talk.warn_of(run.problems, len(dataset), "taught nothing")
    if asked.is_learning:
        tell_lessons(talk, run.lessons, has_learned=run.has_learned)
    talk.results("watch", _rows(run, summary, folder), {**summary, "out": str(folder.path)})
    if lost is not None:
        raise lost
    if run.ended is not None:
        talk.note(run.ended)
    if ctrl_c.is_pressed:
        kept = "what was learned is kept" if asked.is_learning else "the run is kept"
        again = go_on_with("watch", folder.path)
        talk.note(f"stopped after {summary['seconds']:.0f} s; {kept}; {again}")
        return ctrl_c.status
    return LEARNED_NOTHING_STATUS if asked.is_learning and not run.has_learned else 0


def _begun(folder: OutputFolder, given: GivenWatch) -> Begun | None:
    """Return what the watch found out of its camera; None where it had not come to that."""
    path = folder.path / BEGUN
    return Begun.read(path, given.version) if path.is_file() else None


def _open(
    talk: Talk,
    live: LivePage,
    config: Config,
    source: Path,
    asked: Asked,
    stack: ExitStack,
    begun: Begun | None,
) -> tuple[Dataset, DrawnViews | None]:
    """Open a recording or a camera, or draw the drive through what is drawn."""
    if is_camera(source):
        return _look_round(live, config, source, asked, stack, begun), None
    if not is_drawn(source):
        live.say(f"opening {source}")
        return open_source(source, reading=config.reading), None
    check_drawn(config.reading)
    settings = parse_drawn(str(source))
    _tell_page(talk, live)
    live.say(f"planning a drive through {source}")
    views, said = plan_drive(settings)
    drive = stack.enter_context(closing(DrawnDrive(views)))
    talk.note(f"a drive is drawn first: {count(len(drive), 'frame')}{said and f', {said}'}")
    with talk.following("draw", len(drive)) as shown:
        for number in drive.draw():
            live.say(f"drawing the drive: {number + 1} of {len(drive)} frames")
            shown.advance()
    views.let_go()
    return drive, views


def _look_round(
    live: LivePage,
    config: Config,
    source: Path,
    asked: Asked,
    stack: ExitStack,
    begun: Begun | None,
) -> FirstFrames:
    """Open a camera, and look at what it sees at first."""
    live.say(f"opening {source}")
    feed = stack.enter_context(closing(open_live(str(source))))
    if asked.is_learning and not feed.device.has_depth:
        found = f"{feed.device.name} sees colour alone: it is mapped, with --model RUN"
        raise ValueError(f"learn: expected a camera with depth, {found}")
    live.say("looking round")
    return FirstFrames(feed, config.teacher.n_survey_frames, begun=begun)


def _tell_page(talk: Talk, live: LivePage) -> None:
    """Say where the page is, once nothing can be refused that a refusal of one line was for."""
    if live.url is not None:
        talk.note(f"the page: {live.url}")


def _introduce(talk: Talk, run: Watching, source: Path, dataset: Dataset) -> None:
    if isinstance(dataset, FirstFrames):
        known = "looked round" if dataset.begun is None else "known from before"
        talk.note(f"{dataset.name}: {known}, {count(len(dataset), 'frame')}")
        for remark in dataset.remarks:
            talk.note(f"  {remark}")
    else:
        talk.introduce(source, dataset, for_depth=False)
    talk.note(
        f"{count(run.regions.n_regions, 'region')} ({run.regions.kind}), strategy {run.strategy}"
    )
    for note in run.continued.notes if run.continued is not None else ():
        talk.note(note)
    _tell_keeping(talk, run.keeper)


def _tell_keeping(talk: Talk, keeper: WatchKeeper) -> None:
    """Say where it goes on, and what of it is not what it was."""
    if keeper.so_far.n_looks:
        talk.note(f"goes on after {count(keeper.so_far.n_looks, 'look')}")
    if keeper.n_cut:
        talk.warn(
            f"the journal's last record is not whole, {keeper.n_cut} bytes: that look is lost"
        )
    if keeper.unkept is not None:
        talk.warn(f"{keeper.unkept}: with --resume the strategy begins anew, and all else goes on")


def _follow(talk: Talk, run: Watching, seconds: float | None, ctrl_c: CtrlC) -> None:
    """Run to the end, with a line now and then."""
    told_at, trouble, last = 0.0, SinkTrouble(talk, run.recorders), -1
    for passed_s in run.run(seconds, lambda: not ctrl_c.is_pressed):
        trouble.tell()
        for event in run.watch.events:
            if event.look > last:
                talk.note(event.sentence)
                last = event.look
        if passed_s - told_at < LINE_EVERY_S:
            continue
        told_at = passed_s
        state = run.shown.state()
        hz, age = state["map_hz"], state["map_age_s"]
        line = f"{passed_s:.0f} s, {hz:.1f} maps/s, {state['learn_hz']:.1f} learned/s"
        why = state["why"]
        goal = "" if why is None else f", to {run.regions.names[why['chosen']]}: {why['text']}"
        talk.note(f"{line}, map {1000 * age:.0f} ms old{goal}")
    trouble.tell()


def _rows(run: Watching, summary: dict[str, Any], folder: OutputFolder) -> dict[str, Any]:
    """Return what a person wants to see of the summary."""
    p50, p99 = summary["map_age_p50_ms"], summary["map_age_p99_ms"]
    return {
        "seconds": summary["seconds"],
        "maps a second": summary["map_hz"],
        "learned a second": summary["learn_hz"],
        "age of a map (ms)": None if p50 is None else f"{p50}, p99 {p99}",
        "looks": summary["looks"],
        "frames not compared": summary["dropped"],
        **({"places that changed": tell_alarms(alarms)} if (alarms := summary["alarms"]) else {}),
        **recorded(run.recorders),
        "written to": folder.path,
    }
