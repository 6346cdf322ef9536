"""Modules import only from lower rows, and the heavy optional packages only where used."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import curiosight

ROWS = (
    {"frame", "errors"},
    {"metrics"},
    {"datasets", "rooms"},
    {"teacher"},
    {"learner"},
    {"explorer", "worlds"},
    {"evaluation", "explore", "config", "robot", "catalogue"},
    {"experiments", "viewing"},
    {"cli", "gym"},
    {"__main__"},
)
ROW_OF = {part: row for row, parts in enumerate(ROWS) for part in parts}
# Inside the teacher: a depth image goes down one staircase, and no value comes back up.
STAIRS = (
    {"settings", "cloud"},
    {"supports"},
    {"walls"},
    {"things"},
    {"segmented"},
    {"labelling", "mask_edges", "confidence", "turning", "resizing"},
    {"teacher", "paper"},
    {"memory", "given", "depth_and_masks"},
)
STAIR_OF = {part: row for row, parts in enumerate(STAIRS) for part in parts}
# The Gymnasium environments are a room of their own, and look into three others; the robot's is
# one, too, and looks into six; the catalogue looks into two, and four look into it.
MAX_ROOMS, MAX_ARROWS = 19 + 1 + 1 + 1, 85 + 3 + 6 + 6
OPTIONAL = {"sklearn", "onnxruntime", "rembg", "rerun", "ray", "gymnasium", "rclpy", "rosbags"}
OPTIONAL |= {"matplotlib", "scipy", "PIL"}
OPTIONAL |= {"lz4", "backports", "mcap", "pyrealsense2", "depthai", "av", "lzfse", "liblzfse"}

# What others' base classes make of ours; only who uses them imports these.
ADAPTERS = {Path("learner/sklearn_estimator.py"), Path("gym/environment.py")}

ROOT = Path(curiosight.__file__).parent
COMMAND = ROOT.parent / "curiosight_command.py"
REPOSITORY = Path(__file__).parent.parent
MODULES = sorted(path.relative_to(ROOT) for path in ROOT.rglob("*.py"))


def part_of(module: Path) -> str:
    """Return what the layout calls a module: its package, or its own name."""
    return module.parts[0].removesuffix(".py")


def imported(nodes: Iterator[ast.AST], module: Path) -> set[str]:
    """Return the absolute dotted names that import statements among the nodes ask for."""
    names: set[str] = set()
    package = ("curiosight", *module.parts[:-1])
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            base = ".".join((*above, *filter(None, [node.module])))
            names |= {f"{base}.{alias.name}" for alias in node.names}
    return names


def run_at_import(tree: ast.AST) -> Iterator[ast.AST]:
    """Walk a module without the bodies of its functions, and what only type checkers read."""
    yield tree
    for child in ast.iter_child_nodes(tree):
        is_for_types = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
        is_body = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        if not is_body and not is_for_types:
            yield from run_at_import(child)


def upward_imports(source: str, module: Path) -> set[str]:
    part = part_of(module)
    names = imported(ast.walk(ast.parse(source)), module)
    used = {name.split(".")[1] for name in names if name.startswith("curiosight.")} - {part}
    # The public names stand over all but what a user calls.
    if "curiosight" in names and ROW_OF[part] < ROW_OF["cli"]:
        return {"__init__"}
    return {other for other in used & ROW_OF.keys() if ROW_OF[other] >= ROW_OF[part]}


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_module_imports_only_from_lower_rows(module: Path) -> None:
    part = part_of(module)
    if part == "__init__":
        return
    assert part in ROW_OF, f"{part} has no row in the layout"
    assert upward_imports((ROOT / module).read_text("utf-8"), module) == set()


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_optional_packages_are_imported_at_use(module: Path) -> None:
    if module in ADAPTERS:
        return
    tree = ast.parse((ROOT / module).read_text("utf-8"))
    names = {name.split(".")[0] for name in imported(run_at_import(tree), module)}
    assert names & OPTIONAL == set()


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_adapters_are_imported_by_no_part_of_ours(module: Path) -> None:
    names = imported(ast.walk(ast.parse((ROOT / module).read_text("utf-8"))), module)
    adapters = {".".join(("curiosight", *path.with_suffix("").parts)) for path in ADAPTERS}
    assert not {name for name in names if name.startswith(tuple(adapters))}


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_kernels_are_compiled_by_the_one_who_knows_what_to_do_without_a_cache(module: Path) -> None:
    if module == Path("errors/compiling.py"):
        return
    names = imported(ast.walk(ast.parse((ROOT / module).read_text("utf-8"))), module)
    assert names & {"numba", "numba.njit", "numba.jit", "numba.vectorize"} == set()


@pytest.mark.parametrize("module", [m for m in MODULES if m.parts[0] == "teacher"], ids=str)
def test_teacher_is_one_staircase(module: Path) -> None:
    stair = module.parts[1].removesuffix(".py")
    if stair == "__init__":
        return
    assert stair in STAIR_OF, f"teacher/{stair} has no place on the stairs"
    names = imported(ast.walk(ast.parse((ROOT / module).read_text("utf-8"))), module)
    used = {name.split(".")[2] for name in names if name.startswith("curiosight.teacher.")}
    assert {other for other in used - {stair} if STAIR_OF[other] > STAIR_OF[stair]} == set()
    assert "curiosight.teacher" not in {name.rpartition(".")[0] for name in names}


def test_house_is_small_enough_to_know() -> None:
    """Rooms are package folders and top-level files, benchmarks and the entry files among them."""
    sources = {part_of(module): set[str]() for module in MODULES}
    for module in MODULES:
        names = imported(ast.walk(ast.parse((ROOT / module).read_text("utf-8"))), module)
        sources[part_of(module)] |= rooms_named(names)
    beside = {"benchmarks": REPOSITORY / "benchmarks", "command": COMMAND}
    for room, place in beside.items():
        sources[room] = set()
        for path in [place] if place.is_file() else place.glob("*.py"):
            names = imported(ast.walk(ast.parse(path.read_text("utf-8"))), Path(path.name))
            sources[room] |= rooms_named(names)
    arrows = {(room, other) for room, used in sources.items() for other in used - {room}}
    assert len(sources) <= MAX_ROOMS
    assert len(arrows) <= MAX_ARROWS


def rooms_named(names: set[str]) -> set[str]:
    whole = {"__init__"} if "curiosight" in names else set()
    inside = {name.split(".")[1] for name in names if name.startswith("curiosight.")}
    return whole | {name if name in ROW_OF else "__init__" for name in inside}


@pytest.mark.parametrize(
    ("module", "source", "expected"),
    [
        ("metrics.py", "from curiosight.learner import SaliencyLearner", {"learner"}),
        ("worlds/replay.py", "from curiosight.explorer.regions import Regions", {"explorer"}),
        ("worlds/replay.py", "from ..explore import explore", {"explore"}),
        ("worlds/replay.py", "def f():\n    import curiosight.cli", {"cli"}),
        ("worlds/replay.py", "from curiosight import cli, frame", {"cli"}),
        ("worlds/replay.py", "from .world import World\nimport numpy", set()),
        ("learner/forest.py", "from curiosight.learner.forest_kernels import grow", set()),
        ("experiments/racing.py", "import curiosight", {"__init__"}),
        ("cli/app.py", "import curiosight", set()),
    ],
)
def test_upward_imports_are_found(module: str, source: str, expected: set[str]) -> None:
    assert upward_imports(source, Path(module)) == expected
