"""A bag as a whole: which files it is made of, and its topics over all of them."""

from __future__ import annotations

import atexit
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

from curiosight.datasets.bags.mcap_file import McapFile
from curiosight.datasets.bags.message_types import ENCODINGS, decode
from curiosight.datasets.bags.messages import Messages
from curiosight.datasets.bags.ros1_file import Ros1File
from curiosight.datasets.bags.sources import BagFile, zstd_module
from curiosight.datasets.bags.sqlite_file import SqliteFile
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.listing import natural_key
from curiosight.errors import DataError
from curiosight.errors.inputs import read_text

METADATA = "metadata.yaml"
KINDS: dict[str, type[BagFile]] = {
    ".bag": Ros1File,
    ".mcap": McapFile,
    ".db3": SqliteFile,
}
# What a database that is open has beside it.
BESIDE = ("-wal", "-shm", "-journal")
PART = re.compile(r"(.*?)_\d+$")


@dataclass(frozen=True, eq=False)
class Topic:
    """The messages of a topic over all files of a bag, in their order."""

    name: str
    type: str
    encoding: str
    parts: tuple[tuple[BagFile, Messages], ...]

    def __len__(self) -> int:
        return sum(len(messages) for _, messages in self.parts)

    @cached_property
    def logged_ns(self) -> npt.NDArray[np.int64]:
        """When each was recorded, (N,)."""
        return np.concatenate([np.array(m.logged_ns, np.int64) for _, m in self.parts])

    @cached_property
    def stamped_ns(self) -> npt.NDArray[np.int64]:
        """What its header says, (N,); as logged where it has none."""
        return np.concatenate([np.array(m.stamped_ns, np.int64) for _, m in self.parts])

    def message(self, number: int) -> Any:
        """Decode a message; raises `UnreadableFile`."""
        for file, messages in self.parts:
            if number < len(messages):
                return decode(file.read(messages, number), self.type, self.encoding)
            number -= len(messages)
        raise IndexError(number)

    def readable(self) -> Iterator[tuple[int, Any]]:
        """Yield the number and content of each message that can be decoded."""
        start = 0
        for file, messages in self.parts:
            for number, content in file.contents(messages):
                with suppress(UnreadableFile):
                    yield start + number, decode(content, self.type, self.encoding)
            start += len(messages)

    def first(self) -> Any | None:
        """Return the first message that can be decoded; None if none can."""
        for number in range(len(self)):
            with suppress(UnreadableFile):
                return self.message(number)
        return None


class Bag:
    """A bag of ROS 1 or 2: its topics, by name, and what there is to remark on its files.

    Raises `DataError` where it cannot be read at all, or holds no messages.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remarks: list[str] = []
        metadata = _read_metadata(path) if path.is_dir() else {}
        self.files = [self._open(file, metadata) for file in self._paths(metadata)]
        self._compare_counts(metadata)
        self.topics = self._topics()
        if not self.topics:
            why = "".join(f" ({remark})" for remark in self.remarks)
            raise DataError(path, f"is a bag without any message{why}", "record it again")

    def _paths(self, metadata: dict[str, Any]) -> list[Path]:
        if not self.path.is_dir():
            return [self.path]
        found = bag_files(self.path)
        named = [self.path / Path(str(n)).name for n in metadata.get("relative_file_paths") or ()]
        if not named:
            is_there = (self.path / METADATA).is_file()
            what = f"{METADATA} tells nothing" if is_there else f"there is no {METADATA}"
            self.remarks.append(f"{what}: it was not closed")
        missing = [file.name for file in named if not file.is_file()]
        if missing:
            self.remarks.append(f"{', '.join(missing)} is missing, though {METADATA} names it")
        files = [file for file in named if file.is_file()] or found
        if not files:
            raise DataError(self.path, "is a bag without its files", "copy it again, whole")
        return files

    def _open(self, path: Path, metadata: dict[str, Any]) -> BagFile:
        mode = str(metadata.get("compression_mode") or "").lower()
        if path.suffix == ".zstd":
            self.remarks.append(f"{path.name} is unpacked to a temporary folder")
            path = _unpack(path)
        try:
            opened = KINDS[bag_ending(path)](path, are_zstd=mode == "message")
        except OSError as error:
            raise DataError(path, f"cannot be read ({error.strerror})", "check it") from error
        name = f"{path.name}: " if self.path.is_dir() else ""
        self.remarks += [f"{name}{fault}" for fault in dict.fromkeys(opened.faults)]
        return opened

    def _compare_counts(self, metadata: dict[str, Any]) -> None:
        """Remark where another number of messages was read than announced."""
        n_read = sum(len(m) for file in self.files for m in file.topics.values())
        announced = metadata.get("message_count")
        if not isinstance(announced, int):
            told = [file.n_announced for file in self.files]
            announced = None if None in told else sum(filter(None, told))
        if announced is not None and announced != n_read:
            self.remarks.append(f"it announces {announced} messages, {n_read} were read")

    def _topics(self) -> dict[str, Topic]:
        """Return the topics with messages; of one that has several types the most frequent."""
        parts: dict[tuple[str, str, str], list[tuple[BagFile, Messages]]] = {}
        for file in self.files:
            for messages in file.topics.values():
                if len(messages):
                    key = messages.topic, messages.type, messages.encoding
                    parts.setdefault(key, []).append((file, messages))
        topics: dict[str, Topic] = {}
        for (name, kind, encoding), of_topic in sorted(parts.items()):
            topic = Topic(name, kind, encoding, tuple(of_topic))
            if name not in topics or len(topics[name]) < len(topic):
                topics[name] = topic
        return topics

    def is_of_ros(self) -> bool:
        """Tell whether any of its messages are encoded as ROS does."""
        return any(topic.encoding in ENCODINGS for topic in self.topics.values())


def is_bag(path: Path) -> bool:
    """Tell whether a path is a bag: a file by its ending, or a folder of such files.

    A folder is one where it has a `metadata.yaml` of rosbag2, or nothing but the parts of one
    recording, `x_0.mcap`, `x_1.mcap`, say, as a recorder leaves it that was killed.
    """
    if path.is_file():
        return bag_ending(path) in KINDS
    files = bag_files(path) if path.is_dir() else []
    if path.is_dir() and (path / METADATA).is_file():
        return bool(files) or "rosbag2_bagfile_information" in _head(path / METADATA)
    one_recording = len({_stem(file) for file in files}) == 1
    return one_recording and all(name.startswith(".") for name in beside_bag(path))


def beside_bag(folder: Path) -> set[str]:
    """Return the names of what lies in the folder of a bag and is no part of it."""
    names = {child.name for child in folder.iterdir()}
    names -= {METADATA, *(file.name for file in bag_files(folder))}
    return {name for name in names if not name.endswith(BESIDE)}


def bag_files(folder: Path) -> list[Path]:
    """Return the files of bags that lie in a folder, in natural order."""
    files = (child for child in folder.iterdir() if child.is_file())
    bags = [file for file in files if bag_ending(file) in KINDS and not file.name.startswith(".")]
    return sorted(bags, key=lambda file: natural_key(file.name))


def bag_ending(path: Path) -> str:
    """Return the ending that says what kind of bag a file is.

    >>> bag_ending(Path("a_0.db3.zstd")), bag_ending(Path("a.bag.active"))
    ('.db3', '.bag')
    """
    name = path.name.lower()
    for last in (".zstd", ".active"):
        name = name.removesuffix(last)
    return Path(name).suffix


def _stem(path: Path) -> str:
    stem = path.name[: path.name.lower().index(bag_ending(path))]
    part = PART.match(stem)
    return part[1] if part else stem


def _head(path: Path) -> str:
    with path.open("rb") as file:
        return file.read(1000).decode("utf-8", "replace")


def _read_metadata(folder: Path) -> dict[str, Any]:
    """Return what `metadata.yaml` says; nothing where there is none, or it is cut."""
    path = folder / METADATA
    if not path.is_file():
        return {}
    try:
        content = yaml.safe_load(read_text(path))
        told = content["rosbag2_bagfile_information"]
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
        return {}
    return told if isinstance(told, dict) else {}


def _unpack(path: Path) -> Path:
    """Decompress a file into a folder that goes when the program ends."""
    folder = Path(tempfile.mkdtemp(prefix="curiosight-bag-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    target = folder / path.stem
    try:
        with zstd_module().open(path, "rb") as packed, target.open("wb") as file:
            shutil.copyfileobj(packed, file)
    except EOFError:
        pass  # cut short: what is there is read
    except Exception as error:
        raise DataError(path, f"cannot be unpacked ({error})", "copy it again") from error
    return target
