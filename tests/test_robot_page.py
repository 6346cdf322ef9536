"""The page: served on this machine to itself alone, and no request makes it grow or fall."""

from __future__ import annotations

import http.client
import json
import re
import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from curiosight.robot.page import Page, open_page
from curiosight.robot.page import server as page_server
from curiosight.robot.state import KEYS, Preparing


class Recorded(Preparing):
    """A subject that takes down commands, and shows one picture."""

    def __init__(self) -> None:
        super().__init__("recorded")
        self.commands: list[tuple[str, Any]] = []

    def picture(self, name: str) -> bytes | None:
        if name == "broken":
            raise RuntimeError("it cannot be drawn")
        return b"jpeg" if name == "colour" else None

    def command(self, name: str, value: Any) -> str:
        if name == "full":
            raise OSError("no space left")
        if name == "wrong":
            raise ValueError("wrong: expected another, got this")
        self.commands.append((name, value))
        return "as you wish"


@pytest.fixture
def subject() -> Recorded:
    return Recorded()


@pytest.fixture
def page(subject: Recorded) -> Iterator[Page]:
    page = open_page(subject, 0)
    yield page
    page.close()


def port_of(page: Page) -> int:
    return int(page.url.rstrip("/").rpartition(":")[2])


def ask(
    page: Page, path: str, method: str = "GET", body: str | None = None, **headers: str
) -> tuple[int, bytes, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", port_of(page), timeout=10)
    connection.request(method, path, body, headers)
    answer = connection.getresponse()
    found = answer.status, answer.read(), dict(answer.getheaders())
    connection.close()
    return found


def test_state_is_there_from_the_first_answer(page: Page) -> None:
    status, body, headers = ask(page, "/state.json")
    assert status == 200
    assert headers["Content-Type"] == "application/json"
    assert headers["Cache-Control"] == "no-store"
    assert json.loads(body) == {**dict.fromkeys(KEYS), "state": "preparing"}
    assert json.loads(ask(page, "/live.json")[1]) == {"note": "recorded"}
    assert json.loads(ask(page, "/plan.json?again=1")[1]) == {"outlines": [], "regions": []}


def test_page_asks_nobody_but_itself(page: Page) -> None:
    for path in ("/", "/page.css", "/page.js"):
        status, body, headers = ask(page, path)
        assert status == 200
        text = body.decode().replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"https?://|//[a-z]+\.", text)
        assert "default-src 'none'" in headers["Content-Security-Policy"]
    html = ask(page, "/")[1].decode()
    assert 'name="viewport"' in html
    shown = set(re.findall(r'\bid="(\w+)"', html))
    asked_for = set(re.findall(r'at\("(\w+)"\)', ask(page, "/page.js")[1].decode()))
    assert asked_for <= shown


def test_pictures(page: Page) -> None:
    assert ask(page, "/colour.jpg")[:2] == (200, b"jpeg")
    assert ask(page, "/teacher.jpg")[0] == 404
    assert ask(page, "/../server.py")[0] == 404
    status, body, _ = ask(page, "/broken.jpg")
    assert (status, json.loads(body)) == (500, {"error": "it cannot be drawn"})
    status, body, headers = ask(page, "/colour.jpg", "HEAD")
    assert (status, body, headers["Content-Length"]) == (200, b"", "4")


def test_commands(page: Page, subject: Recorded) -> None:
    status, body, _ = ask(page, "/pin", "POST", "3")
    assert (status, json.loads(body)) == (200, {"done": "as you wish"})
    assert ask(page, "/save", "POST")[0] == 200
    assert subject.commands == [("pin", 3), ("save", None)]
    status, body, _ = ask(page, "/wrong", "POST", "1")
    assert (status, json.loads(body)) == (400, {"error": "wrong: expected another, got this"})
    assert ask(page, "/full", "POST", "1")[0] == 500
    assert ask(page, "/pin", "POST", "{")[0] == 400
    assert ask(page, "/pin", "POST", "1" * 2000)[0] == 400
    assert len(subject.commands) == 2


def test_another_site_cannot_press_its_buttons(page: Page, subject: Recorded) -> None:
    here = f"127.0.0.1:{port_of(page)}"
    assert ask(page, "/pause", "POST", "true", Origin="https://elsewhere.example")[0] == 403
    assert ask(page, "/state.json", Host="elsewhere.example")[0] == 403
    assert subject.commands == []
    assert ask(page, "/pause", "POST", "true", Origin=f"http://{here}")[0] == 200
    assert ask(page, "/state.json", Host=f"localhost:{port_of(page)}")[0] == 200


def test_another_subject_is_shown_from_then_on(page: Page) -> None:
    page.show(Preparing("another"))
    assert json.loads(ask(page, "/live.json")[1]) == {"note": "another"}


def test_who_says_nothing_holds_nobody_up(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    """More silent callers than there are threads: they are left after the timeout."""
    monkeypatch.setattr(page_server._Handler, "timeout", 0.2)
    address = ("127.0.0.1", port_of(page))
    silent = [socket.create_connection(address) for _ in range(2 * page_server.N_ANSWERING)]
    assert ask(page, "/state.json")[0] == 200
    for caller in silent:
        caller.close()


def test_threads_stay_few(page: Page) -> None:
    for _ in range(60):
        ask(page, "/state.json")
    names = [thread.name for thread in threading.enumerate()]
    n_answering = sum(name.startswith("page_") for name in names)
    assert n_answering <= page_server.N_ANSWERING * 2  # another test's may end meanwhile


def test_ports_and_hosts_that_cannot_be_had(page: Page, subject: Recorded) -> None:
    port = port_of(page)
    with pytest.raises(ValueError, match=f"page: port {port} is in use; give another, or 0"):
        open_page(subject, port)
    with pytest.raises(ValueError, match="page: expected a port from 0 to 65535, got 70000"):
        open_page(subject, 70_000)
    with pytest.raises(ValueError, match="host: expected an address of this machine, got '192"):
        open_page(subject, 0, "192.0.2.1")
    with pytest.raises(ValueError, match="host: expected an address of this machine, got 'no ad"):
        open_page(subject, 0, "no address")


def test_closed_page_gives_its_port_back(subject: Recorded) -> None:
    page = open_page(subject, 0)
    port = port_of(page)
    ask(page, "/")
    page.close()
    again = open_page(subject, port)
    assert ask(again, "/")[0] == 200
    again.close()
