"""A camera as a feed: its frames are taken off it in a thread, and the newest one wins."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol

from curiosight.frame import Frame
from curiosight.robot.feed import PAUSE_S, Shot
from curiosight.robot.newest import Newest

# A camera that gives nothing for so long is unplugged, or its driver has given up.
SILENT_S = 5.0
GRAB_S, NAP_S = 0.2, 0.02
# Who asks a camera to stop waits so long: a driver whose camera is gone may never answer.
PATIENCE_S = 2.0


class CameraError(Exception):
    """Report a camera that is not there or was lost: which, what was found, what to do."""

    def __init__(self, source: str, found: str, remedy: str) -> None:
        super().__init__(source, found, remedy)
        self.source, self.found, self.remedy = source, found, remedy

    def __str__(self) -> str:
        return f"{self.source}: {self.found}; {self.remedy}"


@contextmanager
def importing(name: str, package: str, extra: str, remedy: str) -> Iterator[None]:
    """Import a camera's package inside; raise `CameraError` where it is missing or cannot load.

    name: of the camera. extra: what the package comes with. remedy: where it is there, and a
    library of the system that it needs is not.
    """
    try:
        yield
    except ModuleNotFoundError:
        found = f"needs {package}, which is missing"
        raise CameraError(name, found, f"pip install 'curiosight[{extra}]'") from None
    except ImportError as error:
        raise CameraError(name, f"{package} cannot be loaded ({error})", remedy) from None


class Device(Protocol):
    """A camera, or what stands in for one.

    name: what the owner knows it by. remarks: sentences on how it is read.
    has_depth: its frames carry depth, registered to colour, and intrinsics.
    waits: what it shows does not go on while nobody asks.
    """

    name: str
    remarks: tuple[str, ...]
    has_depth: bool
    waits: bool

    def grab(self, timeout_s: float) -> Any | None:
        """Wait for what the camera gives next, not decoded; None = nothing in about that time.

        Raises `EndedError` where there will be no more, `CameraError` where the camera is lost.
        """
        ...

    def frame(self, grabbed: Any) -> Frame:
        """Make a frame of what was grabbed; another thread may grab meanwhile."""
        ...

    def silence(self) -> str:
        """Say what is known of why nothing comes."""
        ...

    def close(self) -> None:
        """Let go of the camera; may be called twice."""
        ...


class CameraFeed:
    """A `Feed` of what a camera sees now. Only frames that are asked for are decoded.

    silent_s: raise `CameraError` where nothing has come for so long.
    """

    def __init__(
        self,
        device: Device,
        *,
        silent_s: float = SILENT_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.device, self.n_missed = device, 0
        self._silent_s, self._clock = silent_s, clock
        self._newest = Newest[tuple[Any, float]]()
        self._failure: BaseException | None = None
        self._heard_at = self._asked_at = 0.0
        self._is_closed = False
        self._thread = threading.Thread(target=self._grab, name="camera", daemon=True)

    def newest(self, timeout_s: float) -> Shot | None:
        self._asked_at = self._clock()
        if self._thread.ident is None:
            self._heard_at = self._asked_at
            self._thread.start()
        taken = self._newest.take(timeout_s)
        if taken is not None:
            grabbed, at = taken
            return Shot(self.device.frame(grabbed), None, at)
        if self._failure is not None:
            raise self._failure
        if self._clock() - self._heard_at > self._silent_s:
            found = f"has given no frame for {self._silent_s:g} s ({self.device.silence()})"
            raise CameraError(self.device.name, found, "see that it is plugged in, and start again")
        return None

    def _grab(self) -> None:
        try:
            while not self._is_closed:
                if self.device.waits and self._clock() - self._asked_at > PAUSE_S:
                    time.sleep(NAP_S)
                    continue
                grabbed = self.device.grab(GRAB_S)
                if grabbed is None:
                    continue
                self._heard_at = self._clock()
                self.n_missed += self._newest.put((grabbed, self._heard_at))
        except BaseException as error:  # whoever asks for the frame is told
            self._failure = error

    def close(self) -> None:
        """Stop grabbing and let go of the camera."""
        self._is_closed = True
        if self._thread.ident is not None:
            self._thread.join(PATIENCE_S)
            if self._thread.is_alive():
                return  # closing it under the driver's feet would be worse than leaving it
        self.device.close()
