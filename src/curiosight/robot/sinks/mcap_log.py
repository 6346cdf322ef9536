"""A watch as a log that lasts: MCAP with Foxglove's schemas, in JSON (`curiosight[mcap]`)."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import IO, Any

from curiosight.frame import Viewpoint
from curiosight.robot.pictures import to_grey_png, to_jpeg
from curiosight.robot.sinks import foxglove
from curiosight.robot.sinks.sink import Moment, Sink, places_of
from curiosight.robot.watch import Mapped

WORLD, CAMERA = "world", "camera"
# What a kill may cost is what was written since the last chunk.
CHUNK_BYTES = 1 << 19
REGION_METRES = 0.3
GOAL, OTHER = (0.9, 0.6, 0.0), (0.0, 0.78, 0.55)
# What changes slowly is written so often.
STATE_EVERY_NS = 1_000_000_000
LOOK, STATE = "curiosight.Look", "curiosight.State"
# Of our own making: any values.
OWN = {name: {"type": "object", "title": name} for name in (LOOK, STATE)}


class McapLog(Sink):
    """A log file: images, camera, pose, regions, why; `/state` and `/looks` as they are elsewhere.

    open_file: makes the file, when it begins. Needs mcap.
    """

    def __init__(self, name: str, open_file: Callable[[], IO[bytes]]) -> None:
        self.name, self._open_file = name, open_file
        self._file: IO[bytes] | None = None
        self._writer: Any = None
        self._channels: dict[str, int] = {}
        self._places: dict[int, foxglove.Place] = {}
        self._why, self._state_ns = "", 0

    def begin(self, title: str, views: Sequence[Viewpoint]) -> None:
        from mcap.writer import Writer

        self._file = self._open_file()
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES)
        self._writer.start("", library="curiosight")
        self._writer.add_metadata("curiosight", {"watched": title})
        self._places = places_of(views)

    def write(self, moment: Moment) -> None:
        if moment.mapped is not None:
            self._write_map(moment, moment.mapped)
        if moment.verdict is not None:
            shot, labels = moment.verdict.shot, moment.verdict.segmentation.labels
            self._write_picture("/labels", moment.stamp_of(shot), to_grey_png(labels), "png")
        for look in moment.looks:
            self._add("/looks", LOOK, look, moment.stamp_ns)
        self._write_state(moment)
        assert self._file is not None
        self._file.flush()  # what is in a whole chunk is in the file

    def close(self) -> None:
        if self._file is None:
            return
        with self._file:
            if self._writer is not None:
                self._writer.finish()

    def _write_map(self, moment: Moment, mapped: Mapped) -> None:
        """Write a frame's colour, camera and pose, and its map: all with the frame's time."""
        frame, stamp_ns = mapped.shot.frame, moment.stamp_of(mapped.shot)
        self._write_picture("/camera/colour", stamp_ns, to_jpeg(frame.rgb, None), "jpeg")
        grey = to_grey_png(255 * mapped.saliency)
        self._write_picture("/saliency", stamp_ns, grey, "png")
        if frame.camera is not None:
            told = foxglove.camera_calibration(stamp_ns, CAMERA, frame.camera)
            self._add("/camera/calibration", "foxglove.CameraCalibration", told, stamp_ns)
        if frame.T_world_camera is not None:
            told = foxglove.frame_transform(stamp_ns, WORLD, CAMERA, frame.T_world_camera)
            self._add("/tf", "foxglove.FrameTransform", told, stamp_ns)

    def _write_picture(self, topic: str, stamp_ns: int, content: bytes, kind: str) -> None:
        told = foxglove.compressed_image(stamp_ns, CAMERA, content, kind)
        self._add(topic, "foxglove.CompressedImage", told, stamp_ns)

    def _write_state(self, moment: Moment) -> None:
        """Write why, where that is new, and once a second the state and the regions."""
        why = moment.state["why"]
        text = "" if why is None else f"to region {why['chosen']}: {why['text']}"
        is_new = text != self._why
        if is_new:
            self._why = text
            told = foxglove.log(moment.stamp_ns, text, "curiosight")
            self._add("/why", "foxglove.Log", told, moment.stamp_ns)
        if not is_new and moment.stamp_ns - self._state_ns < STATE_EVERY_NS:
            return
        self._state_ns = moment.stamp_ns
        self._add("/state", STATE, moment.state, moment.stamp_ns)
        entities = [
            self._entity(moment, region, self._places[region["id"]])
            for region in moment.state["regions"] or ()
            if region["id"] in self._places
        ]
        if entities:
            scene = foxglove.scene_update(entities)
            self._add("/regions", "foxglove.SceneUpdate", scene, moment.stamp_ns)

    def _entity(
        self, moment: Moment, region: Mapping[str, Any], place: foxglove.Place
    ) -> dict[str, Any]:
        error = "" if region["error"] is None else f", error {region['error']:.2f}"
        return foxglove.ball(
            moment.stamp_ns,
            WORLD,
            f"region {region['id']}",
            place,
            metres=REGION_METRES,
            colour=GOAL if region["id"] == moment.state["goal"] else OTHER,
            text=f"{region['name']}: looks {region['n_looks']}{error}",
        )

    def _add(self, topic: str, kind: str, message: Mapping[str, Any], stamp_ns: int) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            content = json.dumps({**foxglove.SCHEMAS, **OWN}[kind]).encode()
            schema = self._writer.register_schema(kind, "jsonschema", content)
            channel = self._writer.register_channel(topic, "json", schema)
            self._channels[topic] = channel
        data = json.dumps(message, allow_nan=False).encode()
        self._writer.add_message(channel, stamp_ns, data, stamp_ns)
