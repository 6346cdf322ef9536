#!/usr/bin/env bash
# pyrealsense2 2.59.1.11053 (wheel for CPython 3.11, Linux x86-64), seen 2026-12-01.
# Expected: a wheel named manylinux1 runs with glibc 2.5 and needs no library beyond that
#   tag's list (PEP 513), so that `pip install` is all it takes.
# Happens: its module needs libusb-1.0 and libudev of the system, which are on no such list and
#   not in the wheel, and glibc 2.29. Inside, the wheel calls itself linux_x86_64, and pure Python.
# Meets: who installs it in a slim container: pip says all is well, and the import fails with
#   "libusb-1.0.so.0: cannot open shared object file".
set -euo pipefail
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pyelftools==0.32
cd "$work"
env/bin/pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: \
  --python-version 3.11 --implementation cp --platform manylinux1_x86_64 pyrealsense2==2.59.1.11053
env/bin/python - <<'PY'
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

from elftools.elf.elffile import ELFFile

(wheel,) = Path().glob("pyrealsense2-*.whl")
with ZipFile(wheel) as inside:
    names = inside.namelist()
    (module,) = (n for n in names if n.startswith("pyrealsense2/pyrealsense2.") and n.endswith(".so"))
    elf = ELFFile(BytesIO(inside.read(module)))
    (about,) = (n for n in names if n.endswith(".dist-info/WHEEL"))
    said = inside.read(about).decode().splitlines()
tags = elf.get_section_by_name(".dynamic").iter_tags()
needed = {tag.needed for tag in tags if tag.entry.d_tag == "DT_NEEDED"}
outside = sorted(n for n in needed if n.startswith(("libusb", "libudev")))
versions = elf.get_section_by_name(".gnu.version_r").iter_versions()
glibc = max(
    tuple(map(int, one.name.removeprefix("GLIBC_").split(".")))
    for _, many in versions
    for one in many
    if one.name.startswith("GLIBC_2")
)
carried = [n for n in names if "libusb" in n or "libudev" in n]
print("named   ", wheel.name)
print("inside  ", [line for line in said if line.startswith(("Tag", "Root"))])
print("needs   ", outside, "carried:", carried, "glibc:", glibc)
assert "manylinux1_x86_64" in wheel.name
assert "Tag: cp311-cp311-linux_x86_64" in said
assert "Root-Is-Purelib: true" in said
assert outside == ["libudev.so.1", "libusb-1.0.so.0"]
assert not carried
assert glibc == (2, 29)
PY
