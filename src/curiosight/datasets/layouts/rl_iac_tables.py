"""Read and write the two tables of an RL-IAC folder: region of each image, navigation graph."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from curiosight.errors import DataError
from curiosight.errors.inputs import read_text

REGION_FILE = "input_region_map.dat"
GRAPH_FILE = "region_map.dat"
GRAPH_HEADER = "# region = [up, down, left, right, stay], [durations], [learner];"
_LIST = r"\[([^][]*)\]"
_NODE = re.compile(rf"(\d+)={_LIST},{_LIST},{_LIST};?")
_REGION = re.compile(r"\[(.+)\]=(\d{1,9});?")


@dataclass(frozen=True, slots=True)
class GraphNode:
    """A region of the navigation graph.

    neighbours: where each action leads, in the order up, down, left, right, stay; the region
        itself where there is no way.
    durations: how long each action takes, in the authors' units of time.
    learner: number of the model that learns here.
    """

    neighbours: tuple[int, ...]
    durations: tuple[int, ...]
    learner: int = 0

    def __post_init__(self) -> None:
        if len(self.neighbours) != len(self.durations):
            raise ValueError(
                f"durations: expected {len(self.neighbours)}, one a neighbour, "
                f"got {len(self.durations)}"
            )
        if min((*self.neighbours, *self.durations, self.learner)) < 0:
            raise ValueError(f"node: expected numbers of 0 or more, got {self}")


def is_region_table(path: Path) -> bool:
    """Tell whether a file that can be read as text begins as a table of regions does."""
    _, line = next(_lines(path), (0, ""))
    return _REGION.fullmatch(line) is not None


def read_region_lines(path: Path) -> Iterator[tuple[int, str, int]]:
    """Yield of each line `[image_data/x.png] = region` its number, the path, and the region.

    Paths are without blanks. Raises `DataError` for any other line.
    """
    for number, line in _lines(path):
        match = _REGION.fullmatch(line)
        if match is None:
            raise _malformed(path, number, line, "expected: [image_data/x.png] = 0")
        yield number, match[1], int(match[2])


def read_regions(path: Path) -> dict[str, int]:
    """Read lines of `[image_data/x.png] = region`, as a map from file names to regions.

    Only the last part of a path counts. Raises `DataError` for any other line, and where an
    image has two regions.
    """
    region_of_file: dict[str, int] = {}
    for number, file, region in read_region_lines(path):
        name = file.rpartition("/")[2]
        if region_of_file.setdefault(name, region) != region:
            raise DataError(path, f"line {number} gives {name} two regions", "keep one of them")
    return region_of_file


def read_graph(path: Path) -> tuple[GraphNode, ...]:
    """Read lines of `region = [neighbours], [durations], [learner];`, one a region from 0 up.

    Raises `DataError` for any other line, and for neighbours that do not exist.
    """
    nodes: list[GraphNode] = []
    for number, line in _lines(path):
        match = _NODE.fullmatch(line)
        try:
            assert match is not None
            neighbours, durations, learners = (
                tuple(int(word) for word in match[part].split(",")) for part in (2, 3, 4)
            )
            (learner,) = learners
            node = GraphNode(neighbours, durations, learner)
        except (AssertionError, ValueError):
            remedy = "expected: 0 = [up, down, left, right, stay], [5 durations], [learner];"
            raise _malformed(path, number, line, remedy) from None
        # The authors' program goes by the order of the lines, whatever number they begin with.
        if int(match[1]) != len(nodes):
            remedy = f"expected region {len(nodes)}: list the regions in order, from 0"
            raise _malformed(path, number, line, remedy)
        nodes.append(node)
    for region, node in enumerate(nodes):
        if max(node.neighbours) >= len(nodes):
            found = f"region {region} leads to {max(node.neighbours)}, which is not listed"
            raise DataError(path, found, "give every region a line")
    return tuple(nodes)


def check_listed(path: Path, graph: Sequence[GraphNode], last_region: int) -> None:
    """Raise `DataError` where a graph lacks a region that images are in."""
    if last_region >= len(graph):
        found = f"lists {len(graph)} regions, but images are in region {last_region}"
        raise DataError(path, found, f"add it, or correct {REGION_FILE}")


def file_name(id: str) -> str:
    """Make a name of an id that the authors' program keeps apart from its endings and tables."""
    return re.sub(r"[._-]+(?=depth)|_+(?=GT)", "", re.sub(r"[^\w.-]", "_", id))


def format_regions(region_of_file: Mapping[str, int]) -> str:
    """Return the lines that `read_regions` reads, without any that the authors' would trip on.

    Their program takes a comment or a blank line of this table for an image without a name.
    """
    return "".join(f"[{name}] = {region}\n" for name, region in region_of_file.items())


def format_graph(nodes: Sequence[GraphNode]) -> str:
    """Return the lines that `read_graph` reads."""
    lines = [GRAPH_HEADER]
    for region, node in enumerate(nodes):
        neighbours, durations = (
            ",".join(map(str, numbers)) for numbers in (node.neighbours, node.durations)
        )
        lines.append(f"{region} = [{neighbours}], [{durations}], [{node.learner}];")
    return "\n".join(lines) + "\n"


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield line numbers and lines without blanks; a # anywhere makes a line a comment."""
    try:
        lines = read_text(path, "utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(path, f"cannot be read as text ({error})", "replace the file") from None
    for number, line in enumerate(lines, start=1):
        text = "".join(line.split())
        if text and "#" not in text:
            yield number, text


def _malformed(path: Path, number: int, line: str, remedy: str) -> DataError:
    return DataError(path, f'line {number} is "{line[:60]}"', remedy)
