"""The page in a real browser, where there is one: what it shows is what the watch tells."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from curiosight.robot.page import open_page
from test_robot_advice import NAMES
from test_robot_watch import Knowing, wait_for, watching

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)


@pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")
def test_browser_shows_the_watch(tmp_path: Path) -> None:
    with watching(Knowing()) as (watch, shown):
        wait_for(lambda: watch.lessons.n >= 4)
        page = open_page(shown, 0)
        try:
            dom = rendered(page.url, tmp_path)
        finally:
            page.close()
    assert '<span id="state" class="word">running</span>' in dom
    assert '<span id="text">in turn</span>' in dom
    assert re.search(r'<dd id="map_hz">\d', dom)
    for name in NAMES:
        assert f"</span>{name}</td>" in dom
    assert dom.count(">Pin</button>") == 3
    for picture in ("colour", "teacher", "saliency"):
        assert re.search(rf'<img id="{picture}"[^>]* src="blob:', dom)
    assert '<polygon class="robot"' in dom
    assert dom.count("<circle ") >= 6  # each view, from above
    assert re.search(r'<svg id="error".*?<polyline', dom, re.DOTALL)


def rendered(url: str, profile: Path) -> str:
    """Return a page as it stands in the browser after some seconds."""
    assert BROWSER is not None
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}"]
    options += ["--virtual-time-budget=4000", "--window-size=390,844", "--dump-dom"]
    ended = subprocess.run(
        [BROWSER, *options, url], capture_output=True, text=True, timeout=180, check=True
    )
    return ended.stdout
