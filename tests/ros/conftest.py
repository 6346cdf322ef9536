"""A ROS graph for each test: processes of their own, in a domain of their own."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
PEERS = HERE / "peers"
ROS = Path(os.environ.get("CURIOSIGHT_ROS", HERE.parent.parent / ".ros"))
INSTALL = ROS / "install"
FIRST_DOMAIN = 40


class Process:
    """A process whose lines of output can be waited for."""

    def __init__(self, command: list[str], env: dict[str, str]) -> None:
        self.process = subprocess.Popen(
            command,
            env=env,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.lines: list[str] = []
        self._fresh: queue.Queue[str] = queue.Queue()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)
            self._fresh.put(line)

    def wait_for(self, wanted: Callable[[str], bool], seconds: float) -> str:
        """Return the first line of that kind that has not been waited for before."""
        until = time.monotonic() + seconds
        while True:
            try:
                line = self._fresh.get(timeout=max(0.01, until - time.monotonic()))
            except queue.Empty:
                tail = "".join(self.lines[-30:])
                raise AssertionError(f"not said in {seconds} s; last lines:\n{tail}") from None
            if wanted(line):
                return line

    def wait_for_text(self, text: str, seconds: float) -> str:
        return self.wait_for(lambda line: text in line, seconds)

    def json(self, seconds: float, wanted: Callable[[Any], bool] = lambda _: True) -> Any:
        def is_it(line: str) -> bool:
            return line.startswith("{") and wanted(json.loads(line))

        return json.loads(self.wait_for(is_it, seconds))

    def ask(self, within: float = 40.0, **request: Any) -> Any:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        answer = self.json(within)
        assert "failure" not in answer, answer
        return answer

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait(10)

    def end(self, seconds: float = 30.0) -> int:
        """Ask it to end; return its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.process.wait(seconds)


class Graph:
    """The processes of a test."""

    def __init__(self, domain: int, scene: Path, folder: Path) -> None:
        self.domain, self.scene, self.folder = domain, scene, folder
        self.processes: list[Process] = []
        libraries = f"{INSTALL / 'lib'}{os.pathsep}{os.environ.get('LD_LIBRARY_PATH', '')}"
        python = f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
        self.env = os.environ | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "AMENT_PREFIX_PATH": str(INSTALL),
            "LD_LIBRARY_PATH": libraries,
            "PYTHONPATH": str(INSTALL / python),
            "PYTHONUNBUFFERED": "1",
            "ROS_LOG_DIR": str(folder / "log"),
            "NUMBA_NUM_THREADS": "1",
            # Found by others on the loopback without multicast.
            "CYCLONEDDS_URI": "<General><Interfaces><NetworkInterface address='127.0.0.1'/>"
            "</Interfaces></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
            "<Peers><Peer address='127.0.0.1'/></Peers></Discovery>",
        }
        # The wheels start Python anew to set the paths of their libraries; of ours it was done.
        self.env.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None)

    def start(self, *command: str, **env: str) -> Process:
        process = Process(list(command), self.env | env)
        self.processes.append(process)
        return process

    def peer(self, name: str, *arguments: str, **env: str) -> Process:
        return self.start(sys.executable, str(PEERS / f"{name}.py"), *arguments, **env)

    def camera(self, *arguments: str) -> Process:
        return self.peer("camera", str(self.scene), "--domain", str(self.domain), *arguments)

    def listener(self, topic: str, kind: str, *arguments: str) -> Process:
        return self.peer("listener", topic, kind, "--domain", str(self.domain), *arguments)

    def caller(self) -> Process:
        caller = self.peer("caller")
        caller.json(30)
        return caller

    def node(self, *options: str, **parameters: Any) -> Process:
        """Start `curiosight ros --out FOLDER/run`; parameters of ROS by name."""
        given = [part for name, value in parameters.items() for part in ("-p", f"{name}:={value}")]
        out = ["--out", str(self.folder / "run"), "--overwrite"]
        program = str(Path(sys.executable).parent / "curiosight")
        return self.start(program, "ros", *options, *out, "--ros-args", *given)

    @property
    def model(self) -> Path:
        return self.folder / "run" / "model.npz"

    def close(self) -> None:
        for process in self.processes:
            if process.process.poll() is None:
                process.process.kill()
        for process in self.processes:
            process.process.wait(10)
            process.reader.join(10)
            for pipe in (process.process.stdin, process.process.stdout):
                with suppress(BrokenPipeError):
                    pipe.close()


@pytest.fixture(scope="session")
def scene() -> Path:
    """Frames of a drive through a drawn room, drawn once."""
    path = ROS / "scene.npz"
    if not path.is_file():
        half = path.with_name("half.npz")
        subprocess.run([sys.executable, PEERS / "scene.py", half], check=True)
        half.rename(path)
    return path


_domains = iter(range(FIRST_DOMAIN, 100))


@pytest.fixture
def graph(scene: Path, tmp_path: Path) -> Iterator[Graph]:
    graph = Graph(next(_domains), scene, tmp_path)
    yield graph
    graph.close()
