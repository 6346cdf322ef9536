"""Names that other programs give to frames, and which frame each means."""

from __future__ import annotations

import pytest

from curiosight.datasets.frame_names import frame_of_file, match_names

PLAIN = ["000001", "000002", "000003"]
SEQUENCES = ["seq-01/frame-000001", "seq-02/frame-000001"]
STAMPS = ["1305031229.500000", "1305031229.700000"]


@pytest.mark.parametrize(
    ("names", "ids", "expected"),
    [
        (["000001", "000002.png"], PLAIN, {"000001": "000001", "000002": "000002.png"}),
        (["rgb/000001.png"], PLAIN, {"000001": "rgb/000001.png"}),
        (["C:\\d\\rgb\\000001.png"], PLAIN, {"000001": "C:\\d\\rgb\\000001.png"}),
        (["/home/me/r/rgb/000003.JPG"], PLAIN, {"000003": "/home/me/r/rgb/000003.JPG"}),
        (["depth/000001.png", "rgb/000001.png"], PLAIN, {"000001": "rgb/000001.png"}),
        ([f"d/{id}.color.png" for id in SEQUENCES], SEQUENCES,
         {id: f"d/{id}.color.png" for id in SEQUENCES}),
        (["seq-02/rgb/frame-000001.png"], SEQUENCES,
         {"seq-02/frame-000001": "seq-02/rgb/frame-000001.png"}),
        (["frame-000001.png"], SEQUENCES, {}),
        (["frame-000001.png"], SEQUENCES[:1], {SEQUENCES[0]: "frame-000001.png"}),
        (["rgb/1305031229.700000.png"], STAMPS, {STAMPS[1]: "rgb/1305031229.700000.png"}),
        (["3", "1"], PLAIN, {"000001": "1", "000003": "3"}),
        (["2"], ["learn1", "learn2"], {"learn2": "2"}),
        (["000002", "2"], PLAIN, {"000002": "000002"}),
        (["1", "01"], PLAIN, {}),
        (["1"], SEQUENCES, {}),
        (["700000"], STAMPS, {}),
        (["cat7.jpg", "000009.png", "9" * 5000], PLAIN, {}),
        (["a/000001.png", "b/000001.png"], PLAIN, {}),
        (["", ".", "/"], PLAIN, {}),
        ([], PLAIN, {}),
    ],
)  # fmt: skip
def test_names_are_matched(names: list[str], ids: list[str], expected: dict[str, str]) -> None:
    assert match_names(names, ids).name_of == expected


def test_doubt_is_told() -> None:
    found = match_names(["a/000001.png", "b/000001.png"], PLAIN)
    assert found.doubtful == ("a/000001.png", "b/000001.png")
    assert match_names(["frame-000001.png"], SEQUENCES).doubtful == ("frame-000001.png",) * 2
    assert match_names(["000001.png"], PLAIN).doubtful is None


def test_name_with_a_point_is_no_ending() -> None:
    assert frame_of_file("1305031229.528748") == "1305031229.528748"
    assert frame_of_file("seq-01/frame-000001.color.png") == "seq-01/frame-000001"
