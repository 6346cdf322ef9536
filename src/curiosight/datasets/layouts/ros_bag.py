"""Read bags of ROS 1 and ROS 2: a .bag, a folder of rosbag2, a bare .mcap or .db3."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from curiosight.datasets.association import MAX_OFFSET_NS, associate
from curiosight.datasets.bags.bag import Bag, Topic, is_bag
from curiosight.datasets.bags.bag_camera import bag_camera, depth_camera_of, told_unit
from curiosight.datasets.bags.bag_poses import find_bag_poses
from curiosight.datasets.bags.choice import Choice, choose_topics
from curiosight.datasets.bags.images import to_depth, to_rgb
from curiosight.datasets.bags.message_types import TF_MESSAGE, require_rosbags
from curiosight.datasets.bags.messages import NS_PER_SECOND
from curiosight.datasets.bags.realsense import Times, frame_times
from curiosight.datasets.bags.transforms import Transforms
from curiosight.datasets.cameras.depth_camera import with_window
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.depth_files import DepthForm, Raw
from curiosight.datasets.entries import Entry
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import image_size
from curiosight.errors import DataError
from curiosight.frame import Rgb

Listed = list[tuple[int, Path]]
# It calls its own messages sensor_msgs/Image: read as those, they would be wrong.
ORBBEC = re.compile(r"/cam/(sensor_\d+/frameType_\d+|streamProfileType_\d+)$")
ZERO_OR_ONE_TIME = "are all stamped alike: the times of recording are taken"


class RosBag(Recording):
    """A bag; frames are called after the stamps of their colour images, seconds with 9 decimals.

    topics: which to read, `color=/a,depth=/b,info=/c,pose=/d`; those not named are guessed.
    Raises `DataError` where there are no colour images, a named topic is not there or of another
    type, or rosbags is not installed; ValueError where `topics` is no such list.
    """

    name = "ROS bag"
    evidence = "the ending of a bag, or a folder of bags with metadata.yaml"

    @classmethod
    def recognises(cls, path: Path) -> bool:
        """Tell whether the path is a bag: a file by its ending, a folder by its metadata.yaml."""
        return is_bag(path)

    def __init__(self, path: Path, topics: str = "") -> None:
        require_rosbags(path)
        self._bag = Bag(path)
        if any(map(ORBBEC.match, self._bag.topics)):
            found = "is a recording of Orbbec's SDK, whose images are not those of ROS"
            remedy = "play it into ROS (orbbec_camera, bag_filename) and record that, or save "
            raise DataError(path, found, f"{remedy}colour and 16-bit depth with pyorbbecsdk")
        choice = choose_topics(self._bag, topics)
        remarks = list(self._bag.remarks)
        self._topics = {"colour": choice.colour, "depth": choice.depth}
        self._numbers: dict[Path, int] = {}
        entries = self._list_frames(path, choice, remarks)
        colours = [entry.rgb for entry in entries]
        size = image_size(path, colours, self.read_rgb)
        tf = [topic for topic in self._bag.topics.values() if topic.type == TF_MESSAGE]
        transforms = Transforms(tf)
        stamps = [entry.stamp_ns or 0 for entry in entries]
        poses, of_poses = find_bag_poses(choice, tf, transforms, stamps)
        remarks += [_told(choice, of_poses), *of_poses[1:]]
        camera, depth_camera, form = None, None, DepthForm()
        if choice.depth is not None:
            calibration = bag_camera(self._bag, choice, size, stamps, remarks)
            self.mount, camera = calibration.mount, calibration.camera
            form = calibration.depth_form(told_unit(self._bag, remarks))
            depth_size = self._depth_size(entries)
            depth_camera = depth_camera_of(
                self._bag, choice, camera, depth_size, transforms, remarks
            )
            if depth_camera is not None:
                camera = with_window(path, camera, depth_camera)
            cameras = calibration.of_frames or [None] * len(entries)
            entries = [replace(e, camera=own) for e, own in zip(entries, cameras, strict=True)]
        entries = [replace(e, T_world_camera=pose) for e, pose in zip(entries, poses, strict=True)]
        super().__init__(
            path,
            entries,
            camera,
            depth_form=form,
            depth_camera=depth_camera,
            remarks=remarks,
        )

    def read_rgb(self, path: Path) -> Rgb:
        """Decode a colour image; raises `UnreadableFile`. path: as an entry has it."""
        topic = self._topics["colour"]
        assert topic is not None
        return to_rgb(topic.message(self._numbers[path]), path.name)

    def read_raw(self, path: Path) -> Raw:
        """Decode depth as it was recorded; raises `UnreadableFile`. path: as an entry has it."""
        topic = self._topics["depth"]
        assert topic is not None
        return to_depth(topic.message(self._numbers[path]), path.name)

    def _list_frames(self, path: Path, choice: Choice, remarks: list[str]) -> list[Entry]:
        """Pair colour with depth by their stamps."""
        topics = [topic for topic in (choice.colour, choice.depth) if topic is not None]
        alike = [topic.name for topic in topics if _is_stamped_alike(topic)]
        if alike:
            remarks.append(f"images of {' and '.join(alike)} {ZERO_OR_ONE_TIME}")
        colour, *depth = (
            self._listed(path, role, topic, by_log=bool(alike), remarks=remarks)
            for role, topic in zip(("colour", "depth"), topics, strict=False)
        )
        if not depth:
            return [Entry(frame_id(stamp), file, stamp_ns=stamp) for stamp, file in colour]
        assert choice.depth is not None
        times = frame_times(self._bag, choice.colour, choice.depth)
        if times is not None:
            remarks.append("colour and depth are paired by the frames' own times")
        pairs = self._paired(colour, depth[0], times)
        within = f"within {MAX_OFFSET_NS // 1_000_000} ms"
        if not pairs:
            raise DataError(
                path,
                f"none of its {len(colour)} colour images has depth {within}: the nearest is "
                f"{_nearest_ms(colour, depth[0]):.0f} ms off",
                "record both by one clock, or name others: --topics color=/a,depth=/b",
            )
        left = len(colour) - len(pairs)
        rest = f"; {left} colour images have none: left out" if left else ""
        remarks.append(f"depth is the nearest in time {within}{rest}")
        return [Entry(frame_id(stamp), rgb, file, stamp_ns=stamp) for stamp, rgb, file in pairs]

    def _paired(
        self, colour: Listed, depth: Listed, times: tuple[Times, Times] | None
    ) -> list[tuple[int, Path, Path]]:
        """Pair by stamps, or by the times of each image where these are known."""
        if times is None:
            return associate(colour, depth)
        own = [
            sorted((int(of_images[self._numbers[file]]), file) for _, file in listed)
            for listed, of_images in zip((colour, depth), times, strict=True)
        ]
        stamp_of = {file: stamp for stamp, file in colour}
        return sorted((stamp_of[rgb], rgb, file) for _, rgb, file in associate(*own))

    def _listed(
        self, path: Path, role: str, topic: Topic, *, by_log: bool, remarks: list[str]
    ) -> list[tuple[int, Path]]:
        """Return stamps and made-up paths of images in the order of time, none twice."""
        stamps = topic.logged_ns if by_log else topic.stamped_ns
        files: dict[int, Path] = {}
        for number in np.argsort(stamps, kind="stable").tolist():
            stamp = int(stamps[number])
            if stamp not in files:
                files[stamp] = path / f"{role} {frame_id(stamp)}"
                self._numbers[files[stamp]] = number
        if len(files) < len(topic):
            n_left_out = len(topic) - len(files)
            remarks.append(f"{n_left_out} {role} images have another's stamp: left out")
        return list(files.items())

    def _depth_size(self, entries: Sequence[Entry]) -> tuple[int, int]:
        for entry in entries:
            try:
                assert entry.depth is not None
                shape = self.read_raw(entry.depth).shape
            except UnreadableFile:
                continue
            return shape[1], shape[0]
        return (0, 0)


def frame_id(stamp_ns: int) -> str:
    """Return a stamp as seconds with nine decimals.

    >>> frame_id(1305031229_528748000)
    '1305031229.528748000'
    """
    sign = "-" if stamp_ns < 0 else ""
    seconds, rest = divmod(abs(stamp_ns), NS_PER_SECOND)
    return f"{sign}{seconds}.{rest:09d}"


def _is_stamped_alike(topic: Topic) -> bool:
    stamps: npt.NDArray[np.int64] = topic.stamped_ns
    return len(stamps) > 1 and bool((stamps == stamps[0]).all())


def _nearest_ms(colour: Sequence[tuple[int, Path]], depth: Sequence[tuple[int, Path]]) -> float:
    first, second = (np.array([stamp for stamp, _ in listed]) for listed in (colour, depth))
    after = np.searchsorted(second, first).clip(max=len(second) - 1)
    before = (after - 1).clip(min=0)
    offsets = [np.abs(second[place] - first) for place in (before, after)]
    return float(np.minimum(*offsets).min()) / 1e6


def _told(choice: Choice, of_poses: Sequence[str]) -> str:
    """Say which topics are read."""
    named = {"color": choice.colour, "depth": choice.depth, "info": choice.info}
    parts = [f"{role} {topic.name}" for role, topic in named.items() if topic is not None]
    return "topics: " + ", ".join([*parts, *filter(None, of_poses[:1])])
