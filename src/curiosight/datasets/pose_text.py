"""Read poses from text or arrays in any usual form, told by what the numbers are."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.datasets.arrays import read_array
from curiosight.errors.inputs import read_text
from curiosight.frame import MAX_AWAY, Pose, is_rigid
from curiosight.frame.rotations import matrix_of

MAX_BYTES = 100_000_000
# Of lines that are not as long as the others, in a file that is still a trajectory.
MAX_SHARE_ODD = 0.1
# Of what claims to be a pose: where less is one, the numbers mean something else.
MIN_SHARE_RIGID = 0.5
UNIT_LENGTH = 0.1
COMMENT = re.compile(r"(?:^|\s)(?:#|//|%)(.*)")
NOT_A_NUMBER = re.compile(r"[-+]?nan(?:\(\w*\))?|[-+]?1\.#\w+", re.IGNORECASE)
BETWEEN = re.compile(r"[\s,;\[\]]+")
QUATERNION_WORD = re.compile(r"q(?:uat)?\w*?_?([wx])", re.IGNORECASE)
MATRIX_SIZES = (12, 16)
MAX_HEADER_LINES = 50
N_OF_QUATERNION = 7

Numbers = Sequence[float]


@dataclass(frozen=True, slots=True, eq=False)
class PoseRow:
    """One pose of a file.

    key: what stands before the numbers, such as a stamp, a number or a name; None = nothing.
    pose: (4, 4) as the file has it; None = lost. is_openly_lost: it does not claim to be one.
    """

    key: str | None
    pose: Pose | None
    is_openly_lost: bool = False


@dataclass(frozen=True, slots=True)
class _Line:
    """A line of text: the first word where that is no number, and the numbers."""

    name: str | None
    words: Sequence[str]
    numbers: Numbers


def read_pose_rows(path: Path) -> list[PoseRow] | None:
    """Return the poses of a file, in order; None where it holds anything else.

    Lines of 16 or 12 numbers are matrices in rows (or 16 in columns); lines of 7 are a position
    and a quaternion x, y, z, w, or a quaternion w, x, y, z and a position: its length tells, and
    a header where there is one. A stamp, a number or a name may stand before them. Blocks of
    four or three lines of four numbers are matrices, each after a line of up to three numbers or
    all without. `.npy` holds (N, 4, 4), (N, 3, 4), (4, 4) or such lines.
    """
    lines, header = _array(path) if path.suffix.lower() == ".npy" else _text(path)
    if not lines:
        return None
    is_short = all(len(line.numbers) <= 4 for line in lines)
    rows = _blocks(lines) if is_short else _table(lines, header)
    if not rows:
        return None
    n_claimed = sum(not row.is_openly_lost for row in rows)
    n_rigid = sum(row.pose is not None for row in rows)
    return rows if n_rigid >= MIN_SHARE_RIGID * n_claimed else None


def _array(path: Path) -> tuple[list[_Line], str]:
    try:
        content = np.asarray(read_array(path), np.float64)
    except (OSError, ValueError, TypeError):
        return [], ""
    if not content.size or content.ndim not in (2, 3):
        return [], ""
    is_one = content.shape in ((4, 4), (3, 4))
    table = content.reshape(1 if is_one else len(content), -1)
    return [_Line(None, [repr(float(n)) for n in row[:1]], row.tolist()) for row in table], ""


def _text(path: Path) -> tuple[list[_Line], str]:
    """Return the lines that hold numbers, and what stands before them or in comments."""
    try:
        text = read_text(path, "utf-8-sig", MAX_BYTES)
    except (OSError, UnicodeDecodeError):
        return [], ""
    lines: list[_Line] = []
    header: list[str] = []
    for whole in text.splitlines():
        comment = COMMENT.search(whole)
        words = [word for word in BETWEEN.split(COMMENT.sub("", whole)) if word]
        if comment and not lines:
            header.append(comment[1])
        if not words:
            continue
        numbers = [_number(word) for word in words]
        name = words[0] if numbers[0] is None else None
        values = [number for number in numbers[name is not None :] if number is not None]
        if len(values) == len(words) - (name is not None):
            lines.append(_Line(name, words, values))
        elif lines or len(header) > MAX_HEADER_LINES:
            return [], ""  # words amid numbers: some other list
        else:
            header.append(whole)
    return lines, " ".join(header[:MAX_HEADER_LINES])


def _number(word: str) -> float | None:
    if NOT_A_NUMBER.fullmatch(word):
        return np.nan
    try:
        return float(word)
    except ValueError:
        return None


def _table(lines: Sequence[_Line], header: str) -> list[PoseRow]:
    """Return the poses of lines that each hold one."""
    ((has_name, n_numbers), n_usual), *_ = Counter(
        (line.name is not None, len(line.numbers)) for line in lines
    ).most_common(1)
    if len(lines) - n_usual > MAX_SHARE_ODD * len(lines) + 1:
        return []
    n_keys = next((n for n in (0, 1) if n_numbers - n in (*MATRIX_SIZES, N_OF_QUATERNION)), None)
    if n_keys is None or (has_name and n_keys):
        return []
    usual = [
        line.numbers[n_keys:]
        if (line.name is not None, len(line.numbers)) == (has_name, n_numbers)
        else None
        for line in lines
    ]
    keys = [line.words[0] if has_name or n_keys else None for line in lines]
    if n_numbers - n_keys in MATRIX_SIZES:
        made = [None if numbers is None else pose_of_matrix(numbers) for numbers in usual]
    else:
        made = _of_quaternions(usual, header)
    return [
        PoseRow(key, pose, numbers is None or _is_openly_lost(numbers))
        for key, pose, numbers in zip(keys, made, usual, strict=True)
    ]


def _blocks(lines: Sequence[_Line]) -> list[PoseRow]:
    """Return the poses of matrices that are written over several lines."""
    keys: list[str | None] = []
    blocks: list[list[Numbers]] = []
    has_heads = len(lines[0].numbers) < 4
    height = 4 if len(lines) % 4 == 0 and all(map(_is_bottom, lines[3::4])) else 3
    for index, line in enumerate(lines):
        is_head = len(line.numbers) < 4
        if is_head or (not has_heads and index % height == 0):
            keys.append(line.words[0] if is_head else None)
            blocks.append([])
        if not is_head:
            blocks[-1].append(line.numbers)
    whole = [[*block[0], *block[1], *block[2]] for block in blocks if len(block) in (3, 4)]
    if len(whole) < len(blocks) - 1 or (not has_heads and any(len(n.numbers) < 4 for n in lines)):
        return []
    rows = [
        PoseRow(key, pose_of_matrix(numbers), _is_openly_lost(numbers))
        for key, numbers in zip(keys, whole, strict=False)
    ]
    # The last one may be cut short.
    return rows + [PoseRow(key, None, is_openly_lost=True) for key in keys[len(whole) :]]


def _is_bottom(line: _Line) -> bool:
    numbers = np.asarray(line.numbers)
    is_lost = not np.isfinite(numbers).all() or not numbers.any()
    return numbers.shape == (4,) and (is_lost or bool(np.allclose(numbers, (0, 0, 0, 1))))


def pose_of_matrix(numbers: Numbers) -> Pose | None:
    """Return the pose (4, 4) of 16 numbers in rows or columns, or of 12 in rows; None if lost."""
    pose = np.eye(4)
    pose.ravel()[: len(numbers)] = numbers
    if is_rigid(pose):
        return pose
    return pose.T.copy() if len(numbers) == 16 and is_rigid(pose.T) else None


def _of_quaternions(rows: Sequence[Numbers | None], header: str) -> list[Pose | None]:
    """Return the poses of positions with quaternions; None where a quaternion is none."""
    empty = (np.nan,) * N_OF_QUATERNION
    table = np.array([empty if row is None else row for row in rows], np.float64)
    is_last = _is_unit(table[:, 3:]).sum() >= _is_unit(table[:, :4]).sum()
    quaternions, positions = (
        (table[:, 3:], table[:, :3]) if is_last else (table[:, :4], table[:, 4:])
    )
    named = w_is_first(header)
    if named or (named is None and not is_last):
        quaternions = np.roll(quaternions, -1, axis=1)
    is_valid = _is_unit(quaternions) & (np.abs(positions) <= MAX_AWAY).all(axis=1)
    return [
        _pose(position, quaternion) if valid else None
        for position, quaternion, valid in zip(positions, quaternions, is_valid, strict=True)
    ]


def w_is_first(header: str) -> bool | None:
    """Tell whether a header names a quaternion's w before its x; None where it names neither."""
    named = [match.lower() for match in QUATERNION_WORD.findall(header)]
    return named[0] == "w" if named else None


def _is_unit(quaternions: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    lengths = np.linalg.norm(quaternions, axis=1)
    is_unit: npt.NDArray[np.bool_] = np.abs(lengths - 1) < UNIT_LENGTH
    return is_unit


def _pose(position: npt.NDArray[np.float64], quaternion: npt.NDArray[np.float64]) -> Pose:
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(quaternion)
    pose[:3, 3] = position
    return pose


def _is_openly_lost(numbers: Numbers) -> bool:
    """Tell whether numbers say themselves that they are no pose: NaN, infinite, all zero."""
    values = np.asarray(numbers)
    # Trackers leave the bottom row of a lost matrix as it is.
    top = values[:12]
    return not np.isfinite(values).all() or not top.any()
