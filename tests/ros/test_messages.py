"""The messages that were built have the fields of the real ones: their type hashes are equal."""

from __future__ import annotations

import json

import pytest

from conftest import INSTALL

# As Jazzy's own packages have them.
KNOWN = {
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "nav2_msgs/action/NavigateToPose_FeedbackMessage": "9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478"
    "b6559feed9a50bdfd82b3",
}


@pytest.mark.parametrize("name", KNOWN)
def test_type_hash_is_that_of_the_real_package(name: str) -> None:
    package, kind, message = name.split("/")
    file = message.partition("_")[0]
    content = json.loads((INSTALL / "share" / package / kind / f"{file}.json").read_text())
    hashes = {one["type_name"]: one["hash_string"] for one in content["type_hashes"]}
    assert hashes[name] == f"RIHS01_{KNOWN[name]}"
