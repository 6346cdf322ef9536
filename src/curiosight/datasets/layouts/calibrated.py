"""What layouts share whose camera is looked for: their own file, one of others, or the usual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from curiosight.datasets.cameras.calibration import KINECT, KINECTS, find_calibration
from curiosight.datasets.depth_files import ASSUMED, DepthForm
from curiosight.datasets.entries import Entry
from curiosight.datasets.poses_of_entries import with_y_down
from curiosight.datasets.recording import Recording
from curiosight.datasets.sizes import image_size


class Calibrated(Recording):
    """A recording that is read with the camera and the unit that its folder tells.

    usual_camera, usual_form: what the layout is known for, where no file says it; whose: these
    intrinsics are, in words.
    """

    usual_camera = KINECT
    usual_form = ASSUMED
    whose = KINECTS
    # Whether a camera of fy < 0 says that poses are of a y axis that points up.
    poses_follow_camera = True

    def __init__(
        self,
        path: Path,
        entries: Sequence[Entry],
        remarks: Sequence[str] = (),
        *,
        reasons: Sequence[str] = (),
        usual_form: DepthForm | None = None,
        rotated_bits: int = 0,
        camera_folder: Path | None = None,
        avoid: Sequence[str] = (),
    ) -> None:
        """List the frames of a folder.

        camera_folder: where the camera's file is looked for; None = `path`. avoid: names of
        files that hold no camera. rotated_bits: see `DepthForm`.
        """
        found: list[str] = []
        size = image_size(path, [entry.rgb for entry in entries])
        calibration = find_calibration(
            camera_folder or path, size, found, self.usual_camera, whose=self.whose, avoid=avoid
        )
        if calibration.is_y_up and self.poses_follow_camera:
            entries = with_y_down(entries, found)
        form = calibration.depth_form(usual_form or self.usual_form)
        super().__init__(
            path,
            entries,
            calibration.camera,
            depth_form=replace(form, rotated_bits=rotated_bits),
            labels=calibration.labels,
            remarks=[*remarks, *found],
            reasons=reasons,
        )
        self.mount = calibration.mount
