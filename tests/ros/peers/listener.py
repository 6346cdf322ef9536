"""A listener of another DDS stack (rosless): prints a line of JSON for each message.

listener.py TOPIC TYPE [--reliability R] [--durability D]
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import rosless

MOST = 64
MESSAGES = Path(__file__).parent.parent / "messages"


def plain(value: Any) -> Any:
    """Return a message as JSON has it, long arrays by their beginning."""
    if isinstance(value, rosless.Message):
        return {name: plain(inner) for name, inner in value.to_dict().items()}
    if isinstance(value, dict):
        return {name: plain(inner) for name, inner in value.items()}
    if isinstance(value, bytes | bytearray):
        return {"bytes": len(value), "first": list(value[:8]), "max": max(value, default=0)}
    if isinstance(value, list | tuple) or hasattr(value, "tolist"):
        values = list(value)
        return [plain(inner) for inner in values[:MOST]]
    return value


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("topic")
    parser.add_argument("type")
    parser.add_argument("--reliability", default="best_effort")
    parser.add_argument("--durability", default="volatile")
    parser.add_argument("--domain", type=int, required=True)
    given = parser.parse_args()
    if given.type not in rosless.type_names():
        rosless.register_path(MESSAGES / given.type.partition("/")[0])
    node = rosless.Node(given.domain)
    heard = node.subscribe(
        given.topic, given.type, reliability=given.reliability, durability=given.durability
    )
    while True:
        message = heard.read(1.0)
        if message is None:
            continue
        now = time.time_ns()
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        age = None if stamp is None else (now - stamp.sec * 10**9 - stamp.nanosec) / 1e6
        print(json.dumps({"age_ms": age, "at": now / 1e9, **plain(message)}), flush=True)


if __name__ == "__main__":
    main()
