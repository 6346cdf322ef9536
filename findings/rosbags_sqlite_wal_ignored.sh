#!/usr/bin/env bash
# rosbags 0.11.9, seen 2026-11-30.
# Expected: a ROS 2 bag in SQLite form is read with all messages that SQLite has for it.
# Happens: what lies in the database's write-ahead log (the -wal file beside it, where a recorder
#   that was killed leaves its last messages) is not read: 6 of 8 messages, no error, no warning.
#   SQLite itself, opened read-only, sees all 8. rosbags opens the file as immutable, which tells
#   SQLite that there is no log.
# Meets: who reads the bag of a robot that lost power, or a bag that is still being recorded.
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check rosbags==0.11.9
cd "$work"
env/bin/python - <<'PY'
import shutil
import sqlite3
from importlib.metadata import version
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

print("rosbags", version("rosbags"), "SQLite", sqlite3.sqlite_version)
store = get_typestore(Stores.ROS2_JAZZY)
String = store.types["std_msgs/msg/String"]
with Writer(Path("bag"), version=9) as writer:
    chatter = writer.add_connection("/chatter", String.__msgtype__, typestore=store)
    for number in range(6):
        message = store.serialize_cdr(String(data=f"word {number}"), String.__msgtype__)
        writer.write(chatter, number, message)
(database,) = Path("bag").glob("*.db3")

# As a recorder does that writes ahead: two more messages, committed, and not yet moved over.
recorder = sqlite3.connect(database)
recorder.execute("PRAGMA journal_mode=WAL")
recorder.execute("PRAGMA wal_autocheckpoint=0")
for number in (6, 7):
    recorder.execute(
        "INSERT INTO messages (topic_id, timestamp, data)"
        " SELECT topic_id, ?, data FROM messages LIMIT 1",
        (number,),
    )
recorder.commit()

# What is on disk if it is killed now.
Path("left").mkdir()
for path in Path("bag").iterdir():
    if not path.name.endswith("-shm"):
        shutil.copy(path, "left")
print("left on disk:", *sorted(path.name for path in Path("left").iterdir()))
with AnyReader([Path("left")]) as reader:
    by_rosbags = sum(1 for _ in reader.messages())
copy = Path("left") / database.name
by_sqlite = sqlite3.connect(f"file:{copy}?mode=ro", uri=True).execute(
    "SELECT COUNT(*) FROM messages"
).fetchone()[0]
print("messages by rosbags:", by_rosbags, "by SQLite:", by_sqlite)
assert (by_rosbags, by_sqlite) == (6, 8)
PY
