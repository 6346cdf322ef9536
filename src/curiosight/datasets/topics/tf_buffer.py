"""Where frames are, by the transforms of the last seconds."""

from __future__ import annotations

import threading
from bisect import bisect_left
from typing import Any

import numpy as np

from curiosight.datasets.bags.transforms import Link, Transforms, clean, numbers_of, stamp_of
from curiosight.frame import Pose

KEPT_NS = 10_000_000_000
# Neighbours of a stamp that its interpolation looks at: their usual distance tells gaps.
N_BESIDE = 6


class TfBuffer(Transforms):
    """The tree of frames that /tf and /tf_static tell, as they come.

    A frame that is told another parent hangs there from then on. Several threads may ask and add.
    """

    def __init__(self, kept_ns: int = KEPT_NS) -> None:
        super().__init__(())
        self._kept_ns = kept_ns
        self._lock = threading.Lock()

    def take(self, message: Any, *, is_static: bool) -> None:
        """Add the transforms of a TFMessage; those with numbers that are none are left out."""
        for transform in message.transforms:
            numbers = numbers_of(transform.transform)
            child, parent = clean(transform.child_frame_id), clean(transform.header.frame_id)
            if np.isfinite(numbers).all() and child and parent and child != parent:
                with self._lock:
                    self._put(child, parent, stamp_of(transform.header), numbers, is_static)

    def _put(
        self, child: str, parent: str, stamp: int, numbers: tuple[float, ...], is_static: bool
    ) -> None:
        link = self.parents.get(child)
        if link is None or link.parent != parent or link.is_static != is_static:
            link = self.parents[child] = Link(parent, is_static)
        rows = link.rows
        if is_static or (rows and stamp < rows[-1][0] - self._kept_ns):
            rows.clear()  # once and for all; or the clock began again
        place = bisect_left(rows, stamp, key=lambda row: row[0])
        if place < len(rows) and rows[place][0] == stamp:
            rows[place] = stamp, numbers
        else:
            rows.insert(place, (stamp, numbers))
        del rows[: bisect_left(rows, rows[-1][0] - self._kept_ns, key=lambda row: row[0])]

    def pose(self, target: str, frame: str, stamp_ns: int, *, hold_ns: int = 0) -> Pose | None:
        """Return T_target_frame at a stamp, interpolated; None where it is not known.

        hold_ns: so long after the last that was told a link counts as it was then.
        """
        with self._lock:
            joint = self._joint(target, frame)
            if joint is None:
                return None
            up = [self._up(one, joint, stamp_ns, hold_ns) for one in (target, frame)]
        if up[0] is None or up[1] is None:
            return None
        T_target_frame: Pose = np.linalg.inv(up[0]) @ up[1]
        return T_target_frame

    def why_not(self, target: str, frame: str, stamp_ns: int) -> str | None:
        """Say in words what is missing to tell T_target_frame; None where nothing is."""
        with self._lock:
            tops = [self.lineage(one)[-1] for one in (target, frame)]
            is_joined = self._joint(target, frame) is not None
            known = {link.parent for link in self.parents.values()} | self.parents.keys()
            late = [
                (child, link)
                for child, link in zip(self.lineage(frame), self.chain(frame), strict=False)
                if not link.is_static and not link.rows[0][0] <= stamp_ns <= link.rows[-1][0]
            ]
        start = f"no tf from {target} to {frame}"
        if not known:
            return f"{start}: nothing comes on /tf or /tf_static"
        strangers = [one for one in (target, frame) if one not in known]
        if strangers:
            return f"{start}: tf does not tell of {' and '.join(strangers)}"
        if not is_joined:
            return f"{start}: {frame} hangs on {tops[1]}, and nothing joins that to {tops[0]}"
        if self.pose(target, frame, stamp_ns) is not None:
            return None
        for child, link in late:
            early_s, late_s = ((stamp_ns - row[0]) / 1e9 for row in (link.rows[0], link.rows[-1]))
            what = f"{late_s:.2f} s old" if late_s > 0 else f"told only {-early_s:.2f} s later"
            return f"{start} at the image's stamp: {link.parent} to {child} is {what}"
        return f"{start} at the image's stamp: there is a gap"

    def _joint(self, target: str, frame: str) -> str | None:
        ancestors = self.lineage(target)
        return next((one for one in self.lineage(frame) if one in ancestors), None)

    def _up(self, frame: str, ancestor: str, stamp_ns: int, hold_ns: int) -> Pose | None:
        pose: Pose = np.eye(4)
        for link in self.chain(frame):
            if frame == ancestor:
                break
            upper = _at(link, stamp_ns, hold_ns)
            if upper is None:
                return None
            pose, frame = upper @ pose, link.parent
        return pose


def _at(link: Link, stamp_ns: int, hold_ns: int) -> Pose | None:
    if not link.rows:
        return None
    last = link.rows[-1][0]
    if not link.is_static and last < stamp_ns <= last + hold_ns:
        stamp_ns = last
    place = bisect_left(link.rows, stamp_ns, key=lambda row: row[0])
    beside = link.rows[max(0, place - N_BESIDE) : place + N_BESIDE]
    return Link(link.parent, link.is_static, beside).at([stamp_ns])[0] if beside else None
