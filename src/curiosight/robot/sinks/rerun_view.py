"""A watch in Rerun's viewer: what is newest, and curves (extra `curiosight[viz]`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from curiosight.frame import Viewpoint
from curiosight.robot.pictures import to_grey_png, to_jpeg
from curiosight.robot.sinks.sink import Moment, Sink, places_of
from curiosight.robot.watch import Mapped

OPEN = "open"
# The oldest of its curves goes when the viewer has so much.
VIEWER_MEMORY = "300MB"
ANSWERING_S = 10.0


class RerunView(Sink):
    """Show it in a viewer. target: "open" = start one here; else the address of one that runs.

    Pictures, camera and regions are static: each takes the place of the one before, so that only
    curves grow. Raises ImportError where rerun-sdk is not installed; `begin` raises RuntimeError
    for a viewer that cannot be had.
    """

    def __init__(self, target: str = OPEN) -> None:
        import rerun

        self.name, self._target = "Rerun", target
        self._rerun: Any = rerun
        self._stream: Any = None
        self._places: dict[int, tuple[float, float, float]] = {}
        self._why = ""

    def begin(self, title: str, views: Sequence[Viewpoint]) -> None:
        self._stream = self._rerun.RecordingStream("curiosight")
        self._connect()
        self._stream.send_recording_name(title)
        self._places = places_of(views)

    def _connect(self) -> None:
        if self._target == OPEN:
            self._stream.spawn(memory_limit=VIEWER_MEMORY, hide_welcome_screen=True)
        else:
            self._stream.connect_grpc(self._target)

    def write(self, moment: Moment) -> None:
        rerun, stream = self._rerun, self._stream
        if moment.mapped is not None:
            self._show_map(moment.mapped)
        if moment.verdict is not None:
            labels = to_grey_png(moment.verdict.segmentation.labels)
            self._show_picture("camera/labels", labels, "image/png")
        for look in moment.looks:
            stream.set_time("watch", duration=look["seconds"])
            if look["error"] is not None:
                stream.log("error", rerun.Scalars(look["error"]))
        why = moment.state["why"]
        text = "" if why is None else why["text"]
        if text != self._why:
            self._why = text
            stream.log("why", rerun.TextDocument(f"to region {why['chosen']}: {text}"), static=True)
        self._show_regions(moment, with_curves=bool(moment.looks))
        # What is not taken would pile up in this process: a viewer that has gone is an error.
        stream.flush(timeout_sec=ANSWERING_S)

    def close(self) -> None:
        if self._stream is not None:
            self._stream.disconnect()

    def _show_map(self, mapped: Mapped) -> None:
        rerun, frame = self._rerun, mapped.shot.frame
        self._show_picture("camera/colour", to_jpeg(frame.rgb, None), "image/jpeg")
        self._show_picture("camera/saliency", to_grey_png(255 * mapped.saliency), "image/png")
        camera, pose = frame.camera, frame.T_world_camera
        if camera is not None:
            focal, centre = [camera.fx, camera.fy], [camera.cx, camera.cy]
            told = rerun.Pinhole(
                focal_length=focal,
                principal_point=centre,
                resolution=[camera.width, camera.height],
                camera_xyz=rerun.ViewCoordinates.RDF,
            )
            self._stream.log("camera", told, static=True)
        if pose is not None:
            told = rerun.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3])
            self._stream.log("camera", told, static=True)

    def _show_picture(self, path: str, content: bytes, kind: str) -> None:
        picture = self._rerun.EncodedImage(contents=content, media_type=kind)
        self._stream.log(path, picture, static=True)

    def _show_regions(self, moment: Moment, *, with_curves: bool) -> None:
        regions = moment.state["regions"] or ()
        for region in regions if with_curves else ():
            if region["progress"] is not None:
                path = ["progress", region["name"]]
                self._stream.log(path, self._rerun.Scalars(region["progress"]))
        placed = [region for region in regions if region["id"] in self._places]
        if placed:
            points = [self._places[region["id"]] for region in placed]
            labels = [f"{region['name']}: looks {region['n_looks']}" for region in placed]
            told = self._rerun.Points3D(points, radii=0.15, labels=labels)
            self._stream.log("regions", told, static=True)
