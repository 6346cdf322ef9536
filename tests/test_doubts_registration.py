"""Depth whose outlines lie beside colour's edges is doubted, and no other."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.datasets import open_dataset
from curiosight.datasets.doubts import find_doubts
from curiosight.datasets.doubts.outlines import find_misplacement
from curiosight.datasets.layouts import seven_scenes
from curiosight.datasets.reading import Reading
from curiosight.datasets.recording import Recording
from curiosight.frame import Frame
from recordings import write_camera_file, write_depth, write_image, write_seven_scenes
from room import kinect, look, render

WIDTH, HEIGHT = 160, 120
POSES = [
    look(heading, distance=distance, height=height)
    for heading, distance, height in ((-30, 1.9, 1.0), (-10, 1.6, 1.2), (10, 2.0, 0.8), (30, 2, 1))
]
Metres = npt.NDArray[np.float32]


def moved(depth: Metres, right: float = 0, down: float = 0, scale: float = 1) -> Metres:
    """Return depth scaled about the image's middle, then moved by pixels."""
    middle_u, middle_v = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
    matrix = np.array(
        [
            [scale, 0, (1 - scale) * middle_u + right],
            [0, scale, (1 - scale) * middle_v + down],
        ]
    )
    size = (depth.shape[1], depth.shape[0])
    spoilt = cv2.warpAffine(np.nan_to_num(depth), matrix, size, flags=cv2.INTER_NEAREST)
    return np.where(spoilt > 0, spoilt, np.nan).astype(np.float32)


def frames(**move: float) -> list[Frame]:
    views = [render(kinect(WIDTH, HEIGHT), pose) for pose in POSES]
    return [
        Frame(str(index), view.rgb, moved(view.depth, **move), kinect(WIDTH, HEIGHT))
        for index, view in enumerate(views)
    ]


def write(folder: Path, depth_scale: float = 0.001, n_bits: int = 0, **move: float) -> Path:
    """Write frames in millimetres, their bits rotated by n_bits, to be read in `depth_scale`."""
    for frame in frames(**move):
        assert frame.depth is not None
        write_image(folder / f"rgb/{frame.id}.png", frame.rgb)
        write_depth(folder / f"depth/{frame.id}.png", np.round(frame.depth, 3) * 2**n_bits)
    write_camera_file(folder, kinect(WIDTH, HEIGHT), depth_scale=depth_scale)
    return folder


@pytest.mark.parametrize("right", [-5, -3, 0, 3, 5])
@pytest.mark.parametrize("down", [-3, 0, 3])
def test_shift_is_measured(right: float, down: float) -> None:
    """Pixels of 160 columns: 3 are 12 of 640."""
    found = find_misplacement(frames(right=right, down=down))
    if right == down == 0:
        assert found is None
        return
    assert found is not None
    assert found.shift_px == pytest.approx((-right, -down), abs=0.6)
    assert found.scale == pytest.approx(1, abs=0.03)
    assert found.distance_px == pytest.approx(np.hypot(right, down), abs=0.8)
    assert found.best > found.given


@pytest.mark.parametrize("scale", [0.7, 0.85, 1.1, 1.3, 1.5])
def test_scale_of_another_lens_is_measured(scale: float) -> None:
    found = find_misplacement(frames(scale=scale))
    assert found is not None
    assert found.scale == pytest.approx(1 / scale, rel=0.04)


def test_a_pixel_is_nothing() -> None:
    assert find_misplacement(frames(right=1, down=-1)) is None


def test_depth_that_lags_behind_in_every_direction_is_not_doubted() -> None:
    """A camera that turns to and fro, whose colour and depth are not of the same moment."""
    several = [frames(right=right, down=down) for right, down in ((4, 0), (-4, 0), (0, 4), (0, -4))]
    assert find_misplacement([shifted[k] for k, shifted in enumerate(several)]) is None


def test_colour_without_edges_tells_nothing() -> None:
    grey = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    blind = [Frame(frame.id, grey, frame.depth, frame.camera) for frame in frames(right=5)]
    assert find_misplacement(blind) is None


def test_colour_of_other_scenes_tells_nothing() -> None:
    rng = np.random.default_rng(0)
    small = rng.integers(0, 255, (len(POSES), 12, 16, 3), np.uint8)
    others = [
        Frame(
            frame.id,
            np.asarray(cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_NEAREST)),
            frame.depth,
            frame.camera,
        )
        for image, frame in zip(small, frames(), strict=True)
    ]
    assert find_misplacement(others) is None


def test_two_frames_are_too_few() -> None:
    assert find_misplacement(frames(right=5)[:2]) is None


def test_images_may_be_large_or_narrow() -> None:
    """What is in pixels is in those of the image."""
    large = [
        Frame(
            frame.id,
            np.asarray(cv2.resize(frame.rgb, None, fx=6, fy=6)),
            np.asarray(cv2.resize(frame.depth, None, fx=6, fy=6, interpolation=cv2.INTER_NEAREST)),
            kinect(6 * WIDTH, 6 * HEIGHT),
        )
        for frame in frames(right=4)
        if frame.depth is not None
    ]
    found = find_misplacement(large)
    assert found is not None
    assert found.shift_px == pytest.approx((-24, 0), abs=4)
    upright = [
        Frame(
            frame.id,
            frame.rgb[:, 40:120].copy(),
            frame.depth[:, 40:120].copy(),
            kinect(80, HEIGHT),
        )
        for frame in frames(down=4)
        if frame.depth is not None
    ]
    found = find_misplacement(upright)
    assert found is not None
    assert found.shift_px == pytest.approx((0, -4), abs=0.6)


def test_doubt_says_how_far(tmp_path: Path) -> None:
    [doubt] = find_doubts(open_dataset(write(tmp_path, right=4)))
    assert (doubt.code, doubt.fix, doubt.factor) == ("registration", "--depth-camera FILE", None)
    assert "its outlines lie 4 pixels beside colour's" in doubt.text
    assert "moved by -4, 0 pixels (right, down)" in doubt.text


def test_right_depth_is_not_doubted(tmp_path: Path) -> None:
    assert find_doubts(open_dataset(write(tmp_path))) == []


def test_a_wrong_unit_comes_first(tmp_path: Path) -> None:
    doubts = find_doubts(open_dataset(write(tmp_path, depth_scale=0.005, right=4)))
    assert [doubt.code for doubt in doubts] == ["unit", "registration"]


def test_rotated_bits_come_alone(tmp_path: Path) -> None:
    """Outlines of wrapped depth are none."""
    doubts = find_doubts(open_dataset(write(tmp_path, n_bits=3, right=4)))
    assert [doubt.code for doubt in doubts] == ["bits"]


def test_raw_depth_of_seven_scenes_in_a_plain_folder(tmp_path: Path) -> None:
    """Read as 7-Scenes it is registered, moved into a plain folder it is not."""
    size = (320, 240)
    write_seven_scenes(tmp_path / "scenes", 5, size=size)
    assert find_doubts(open_dataset(tmp_path / "scenes")) == []
    for kind, folder in (("color", "rgb"), ("depth", "depth")):
        (tmp_path / "plain" / folder).mkdir(parents=True)
        for path in (tmp_path / "scenes").rglob(f"*.{kind}.png"):
            path.rename(tmp_path / "plain" / folder / f"{path.name.split('.')[0]}.png")
    camera = seven_scenes.scaled_camera(seven_scenes.COLOUR_CAMERA, size)
    write_camera_file(tmp_path / "plain", camera)
    [doubt] = find_doubts(open_dataset(tmp_path / "plain"))
    assert doubt.code == "registration"


def test_wrong_unit_of_depth_that_is_registered_here_is_one_doubt(tmp_path: Path) -> None:
    """Five times too near, it is moved five times as much, and lands beside colour."""
    write_seven_scenes(tmp_path, 8, size=(320, 240))
    dataset = open_dataset(tmp_path)
    assert isinstance(dataset, Recording)
    wrong = dataset.read_as(Reading(depth_scale=dataset.depth_scale / 5))
    assert [doubt.code for doubt in find_doubts(wrong)] == ["unit"]
