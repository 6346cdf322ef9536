"""Read camera poses: one 4x4 matrix a file, or a trajectory in the form of TUM RGB-D."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.pose_text import MAX_HEADER_LINES, w_is_first
from curiosight.errors import DataError
from curiosight.errors.inputs import read_bytes, read_text
from curiosight.frame import MAX_AWAY, Pose, is_rigid
from curiosight.frame.rotations import between, matrix_of

MAX_GAP_NS = 500_000_000
MAX_STAMP_NS = np.iinfo(np.int64).max
# Digits of a number that cannot be seconds, for that would be after the year 5000, and the
# decimals that its own unit has down to nanoseconds: nano-, micro- and milliseconds.
CLOCKS = ((18, 0), (15, 3), (12, 6))


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Poses over time, sorted by stamp.

    stamps_ns: (N,) int64; positions: (N, 3) metres; quaternions: (N, 4) x, y, z, w. Rows with
    NaN, a zero quaternion or a place beyond 10 km stay in: `valid` (N,) bool tells them.
    """

    stamps_ns: npt.NDArray[np.int64]
    positions: npt.NDArray[np.float64]
    quaternions: npt.NDArray[np.float64]

    @property
    def valid(self) -> npt.NDArray[np.bool_]:
        """Tell which rows are poses: within 10 km, with a quaternion of about unit length."""
        # What is NaN compares false.
        near = (np.abs(self.positions) <= MAX_AWAY).all(1)
        finite = near & np.isfinite(self.quaternions).all(1)
        lengths = np.linalg.norm(self.quaternions, axis=1)
        is_valid: npt.NDArray[np.bool_] = finite & (np.abs(lengths - 1) < 0.1)
        return is_valid

    def poses(self) -> list[Pose | None]:
        """Return every row as a (4, 4) pose, None where the row is not valid."""
        return [
            _pose(position, quaternion) if is_valid else None
            for position, quaternion, is_valid in zip(
                self.positions, self.quaternions, self.valid, strict=True
            )
        ]

    def interpolated(
        self, stamps_ns: Sequence[int], *, max_gap_ns: int = MAX_GAP_NS
    ) -> list[Pose | None]:
        """Return the pose at each stamp: position linear, rotation slerp between neighbours.

        None outside the trajectory, and where the neighbours are more than `max_gap_ns` apart.
        """
        stamps, first = np.unique(self.stamps_ns[self.valid], return_index=True)
        positions = self.positions[self.valid][first]
        rotations = self.quaternions[self.valid][first]
        wanted = np.asarray(stamps_ns, np.int64)
        after = np.searchsorted(stamps, wanted)
        poses: list[Pose | None] = []
        for stamp, right in zip(wanted, after, strict=True):
            if right == len(stamps):
                poses.append(None)
            elif stamps[right] == stamp:
                poses.append(_pose(positions[right], rotations[right]))
            elif right == 0 or stamps[right] - stamps[right - 1] > max_gap_ns:
                poses.append(None)
            else:
                left = right - 1
                share = float(stamp - stamps[left]) / float(stamps[right] - stamps[left])
                position = (1 - share) * positions[left] + share * positions[right]
                rotation = between(rotations[left], rotations[right], share)
                poses.append(_pose(position, rotation))
        return poses


def read_pose(path: Path) -> Pose:
    """Read a 4x4 matrix; raise `UnreadableFile` where it is no rigid pose."""
    try:
        numbers = [float(word) for word in read_text(path, "utf-8-sig").split()]
    except FileNotFoundError:
        raise UnreadableFile(f"{path.name} is missing") from None
    except (OSError, ValueError):
        raise UnreadableFile(f"{path.name} does not hold numbers") from None
    if len(numbers) != 16:
        raise UnreadableFile(f"{path.name} holds {len(numbers)} numbers, not the 16 of a pose")
    pose = np.array(numbers).reshape(4, 4)
    if not np.isfinite(pose).all():
        raise UnreadableFile(f"{path.name} holds NaN or infinite numbers")
    if not is_rigid(pose):
        raise UnreadableFile(f"{path.name} is not a rigid pose within 10 km")
    return pose


def parse_stamp(text: str) -> int:
    """Turn seconds into nanoseconds exactly, as floats cannot; ValueError if no such time.

    A number too large for seconds is of milli-, micro- or nanoseconds, see `CLOCKS`.

    >>> parse_stamp("1305031229.528748"), parse_stamp("1.305031229528748e+09")
    (1305031229528748000, 1305031229528748000)
    >>> parse_stamp("1305031229528748000")
    1305031229528748000
    """
    match = re.fullmatch(r"(\d+)(?:\.(\d*))?(?:[eE]([+-]?\d{1,2}))?", text)
    if match is None:
        raise ValueError(f"text: expected seconds such as 1305031229.528748, got {text!r}")
    whole, fraction = match[1], match[2] or ""
    digits = (whole + fraction).lstrip("0")
    n_whole = len(digits) - len(fraction) + int(match[3] or 0)
    n_decimals = _decimals(n_whole)
    n_digits = n_whole + n_decimals
    # Longer numbers are no times, and Python refuses to read the longest.
    stamp_ns = MAX_STAMP_NS + 1 if n_digits > 19 else _leading(digits, n_digits)
    if stamp_ns > MAX_STAMP_NS:
        raise ValueError(f"text: expected seconds, got {text!r}")
    return stamp_ns


def _decimals(n_whole: int) -> int:
    """Return how many decimals make nanoseconds of a number with so many digits before them."""
    for n_digits_of_clock, n_decimals in CLOCKS:
        if n_whole >= n_digits_of_clock:
            return n_decimals
    return 9


def _leading(digits: str, count: int) -> int:
    """Return the first digits as a number, or 0 where the decimal point is before them all."""
    return int(digits[:count].ljust(count, "0")) if count > 0 and digits else 0


def text_lines(path: Path) -> list[str]:
    """Read the lines of a text file, as any system ends and encodes them; `DataError`."""
    try:
        content = read_bytes(path)
        is_wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        text = content.decode("utf-16" if is_wide else "utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(path, f"cannot be read as text ({error})", "replace the file") from None
    return re.split(r"\r\n|\r|\n", text)


def table_rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield line numbers and words of a text table, without comments and blank lines."""
    for number, line in enumerate(text_lines(path), start=1):
        words = line.partition("#")[0].replace(",", " ").split()
        if words:
            yield number, words


def read_trajectory(path: Path) -> Trajectory:
    """Read lines of `stamp tx ty tz qx qy qz qw`, sorted by stamp; `DataError` if malformed.

    A comment that names qw before qx says that the quaternions stand so.
    """
    rows: list[tuple[int, list[float]]] = []
    for number, words in table_rows(path):
        try:
            if len(words) != 8:
                raise ValueError(f"words: expected 8, got {len(words)}")
            rows.append((parse_stamp(words[0]), [float(word) for word in words[1:]]))
        except ValueError:
            raise DataError(
                path,
                f'line {number} is "{" ".join(words)[:60]}"',
                "expected: stamp tx ty tz qx qy qz qw, the stamp in seconds",
            ) from None
    if not rows:
        raise DataError(path, "holds no poses", "fill it or delete it")
    rows.sort(key=lambda row: row[0])
    numbers = np.array([row[1] for row in rows], np.float64)
    stamps_ns = np.array([row[0] for row in rows], np.int64)
    comments = " ".join(line.partition("#")[2] for line in text_lines(path)[:MAX_HEADER_LINES])
    n_ahead = 1 if w_is_first(comments) else 0
    return Trajectory(stamps_ns, numbers[:, :3], np.roll(numbers[:, 3:], -n_ahead, axis=1))


def _pose(position: npt.NDArray[np.float64], quaternion: npt.NDArray[np.float64]) -> Pose:
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(quaternion)
    pose[:3, 3] = position
    return pose
