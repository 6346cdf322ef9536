"""Where tasks are done: in processes of this machine, or on a Ray cluster; the same bytes.

Both get tasks of paths and plain settings, and give back one number. So what is special about
Ray cannot matter: arrays from its store are read-only, but no array is ever passed; a task whose
worker was killed is tried again, but tasks may be done twice (`work`); a function's globals are
frozen when it is first submitted, but no global is used; and workers run with one OpenMP
thread, as ours do, said explicitly in the environment of both.
"""

from __future__ import annotations

import math
import os
import signal
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

from curiosight.errors import DataError
from curiosight.errors.arguments import check_whole
from curiosight.experiments.contest.tasks import ONE_THREAD, Task, work

Backend = Literal["processes", "ray"]
BACKENDS: tuple[Backend, ...] = get_args(Backend)

# How often it is looked whether to stop, seconds.
POLL_S = 0.2
MAX_WORKERS = 1024
# Workers that are killed one after the other, without a task done between, before it is given up.
MAX_LOST = 3
# How long a Ray cluster may take to answer, seconds.
ANSWER_S = 10.0
_SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]


class Workers(Protocol):
    """Do tasks, in any order."""

    def begin(self) -> None:
        """Make ready; raises ValueError where that cannot be."""
        ...

    def submit(self, task: Task) -> None:
        """Take a task."""
        ...

    def finished(self, is_stopped: Callable[[], bool]) -> Iterator[Task]:
        """Yield tasks as they are done; more may be submitted meanwhile. Raises as they do."""
        ...

    def close(self) -> None:
        """End the workers, whatever they do."""
        ...


def make_workers(backend: str, *, n_workers: int | None = None, address: str = "") -> Workers:
    """Return workers; n_workers: None = one a core. address: of a Ray cluster; "" = of our own.

    Raises ValueError for what there is not.
    """
    if n_workers is not None:
        check_whole("workers", n_workers, 1, MAX_WORKERS)
    if backend == "ray":
        return RayCluster(n_workers, address)
    if backend != "processes":
        raise ValueError(f"backend: expected {' or '.join(BACKENDS)}, got {backend!r}")
    if address:
        raise ValueError("address: expected --backend ray, too")
    return Processes(n_workers or _n_cores())


def _n_cores() -> int:
    has_affinity = hasattr(os, "sched_getaffinity")
    return len(os.sched_getaffinity(0)) if has_affinity else os.cpu_count() or 1


class Processes:
    """Processes of this machine, started afresh (spawn), on one thread each.

    One that is killed, by a machine short of memory, say, is replaced, and its task done again.
    """

    def __init__(self, n_workers: int) -> None:
        self._n_workers = n_workers
        self._waiting: list[Task] = []
        self._pending: dict[Future[float], Task] = {}
        self._children: set[BaseProcess] = set()
        self._n_lost = 0
        self._executor = self._new_executor()

    def begin(self) -> None:
        """Do nothing: they start with the first tasks."""

    def submit(self, task: Task) -> None:
        self._waiting.append(task)

    def finished(self, is_stopped: Callable[[], bool]) -> Iterator[Task]:
        while (self._waiting or self._pending) and not is_stopped():
            self._hand_out()
            done, _ = wait(self._pending, POLL_S, FIRST_COMPLETED)
            lost = []
            for future in done:
                task = self._pending.pop(future)
                try:
                    future.result()
                except BrokenProcessPool:
                    lost.append(task)
                    continue
                self._n_lost = 0
                yield task
            if lost and not is_stopped():
                self._begin_again(lost)

    def close(self) -> None:
        for child in self._children:
            child.kill()
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _new_executor(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(
            self._n_workers, mp_context=get_context("spawn"), initializer=_begin_work
        )

    def _hand_out(self) -> None:
        with _as_children_start():
            before = set(active_children())
            while self._waiting:
                try:
                    future = self._executor.submit(work, self._waiting[0])
                except BrokenProcessPool:
                    break  # what is pending will tell
                self._pending[future] = self._waiting.pop(0)
            self._children |= set(active_children()) - before

    def _begin_again(self, lost: list[Task]) -> None:
        """Replace all workers: where one was killed, the pool is of no more use."""
        self._n_lost += 1
        if self._n_lost > MAX_LOST:
            found = "were killed again and again"
            raise DataError("workers", found, "see whether memory suffices, or use fewer --workers")
        lost += self._pending.values()
        self._pending.clear()
        self.close()
        self._children.clear()
        self._executor = self._new_executor()
        self._waiting = [*lost, *self._waiting]


@contextmanager
def _as_children_start() -> Iterator[None]:
    """Let processes that are started now have one thread, and no ear for Ctrl-C.

    A signal to stop goes to a whole group of processes; the first of them tells its workers. One
    that comes now is answered after.
    """
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    can_block = hasattr(signal, "pthread_sigmask")
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS) if can_block else None
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        if mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _begin_work() -> None:
    """End with the process that started this one: a killed one tells nobody."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _check_answers(address: str) -> None:
    """Raise OSError where nobody answers at HOST:PORT; Ray would try for a quarter of an hour."""
    host, colon, port = address.rpartition("//")[2].rpartition(":")
    if colon and port.isdecimal():
        socket.create_connection((host.strip("[]"), int(port)), ANSWER_S).close()


class RayCluster:
    """A Ray cluster; its workers must see the folder of the results under the same path."""

    def __init__(self, n_workers: int | None, address: str) -> None:
        try:
            import ray
        except ImportError as error:
            found = "expected Ray to be installed"
            raise ValueError(f"backend: {found} (pip install 'curiosight[ray]')") from error
        self._ray: Any = ray
        self._n_workers, self._address = n_workers, address
        # A cluster of our own has so many workers; of another we take no more.
        self._most = n_workers if address and n_workers else math.inf
        self._work: Any = None
        self._waiting: deque[Task] = deque()
        self._pending: dict[Any, Task] = {}

    def submit(self, task: Task) -> None:
        self._waiting.append(task)

    def finished(self, is_stopped: Callable[[], bool]) -> Iterator[Task]:
        while (self._waiting or self._pending) and not is_stopped():
            self._hand_out()
            done, _ = self._ray.wait(list(self._pending), num_returns=1, timeout=POLL_S)
            for reference in done:
                task = self._pending.pop(reference)
                self._get(reference)
                yield task

    def close(self) -> None:
        if self._work is not None:
            self._ray.shutdown()

    def begin(self) -> None:
        is_own = not self._address
        try:
            _check_answers(self._address)
            self._ray.init(
                address=self._address or "local",  # whatever RAY_ADDRESS says
                num_cpus=(self._n_workers or _n_cores()) if is_own else None,
                include_dashboard=False if is_own else None,
                log_to_driver=False,
                logging_level="ERROR",
                # Ray's own choice of OMP_NUM_THREADS goes by what a task asks for, and other
                # libraries have other names for it: said here, it is one whatever they are.
                runtime_env={"env_vars": ONE_THREAD},
            )
        except (OSError, OverflowError, RuntimeError, ValueError) as error:
            text = " ".join(str(error).split())
            if is_own:
                raise ValueError(f"backend: expected Ray to start ({text})") from error
            expected = "expected HOST:PORT or auto, of a Ray cluster that answers"
            raise ValueError(f"address: {expected}, got {self._address!r} ({text})") from error
        # Of a module that workers import, so that no global is sent along as it was when the
        # first task was. The retries are Ray's default, said because `work` allows for them.
        self._work = self._ray.remote(num_cpus=1, max_retries=MAX_LOST)(work)

    def _hand_out(self) -> None:
        while self._waiting and len(self._pending) < self._most:
            task = self._waiting.popleft()
            self._pending[self._work.remote(task)] = task

    def _get(self, reference: Any) -> None:
        errors = self._ray.exceptions
        try:
            self._ray.get(reference)
        except errors.RayTaskError as error:
            raise error.cause from None
        except errors.RayError as error:
            found = f"lost a task ({type(error).__name__})"
            raise DataError(Path("the Ray cluster"), found, "see to it, then --resume") from error
