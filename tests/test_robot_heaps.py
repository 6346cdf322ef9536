"""Threads share heaps: what the C library says of itself, in a process of its own."""

from __future__ import annotations

import ctypes
import subprocess
import sys

import pytest

PROGRAM = """
import ctypes, sys, threading
if sys.argv[2] == "shared":
    from curiosight.robot.heaps import share_heaps
    share_heaps()
libc = ctypes.CDLL(None)
libc.malloc.restype, libc.fopen.restype = ctypes.c_void_p, ctypes.c_void_p
libc.malloc_info.argtypes = [ctypes.c_int, ctypes.c_void_p]
libc.fclose.argtypes = [ctypes.c_void_p]
together = threading.Barrier(6)
def work():
    together.wait()
    for _ in range(200):
        libc.malloc(5000)
    together.wait()
threads = [threading.Thread(target=work) for _ in range(6)]
for thread in threads: thread.start()
for thread in threads: thread.join()
file = libc.fopen(sys.argv[1].encode(), b"w")
libc.malloc_info(0, file)
libc.fclose(file)
"""


@pytest.mark.skipif(
    sys.platform != "linux" or not hasattr(ctypes.CDLL(None), "malloc_info"), reason="needs glibc"
)
def test_threads_share_two_heaps(tmp_path):
    n_heaps = {}
    for how in ("alone", "shared"):
        path = tmp_path / how
        subprocess.run([sys.executable, "-c", PROGRAM, str(path), how], check=True)
        n_heaps[how] = path.read_text().count("<heap nr=")
    assert n_heaps["shared"] <= 2 < n_heaps["alone"]
