"""Serve the live page: on the loopback unless asked, nothing from outside, in bounded memory."""

from __future__ import annotations

import errno
import json
import socket
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, HTTPServer
from importlib.resources import files
from ipaddress import ip_address
from typing import Any

from curiosight.robot.state import Subject

HOST = "127.0.0.1"
# Requests that are answered at once, that wait, and how long one may take to be told.
N_ANSWERING, N_WAITING, TIMEOUT_S = 6, 32, 5.0
MOST_BODY = 1000
FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
}
POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
POLICY += "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_NOT_THERE = (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT)


class Page:
    """A page that is being served. subject: what it shows; another may be put there at any time."""

    def __init__(self, server: _Server) -> None:
        self._server = server
        # A daemon, so that an interrupted program does not wait for it.
        self._thread = threading.Thread(
            target=server.serve_forever, kwargs={"poll_interval": 0.1}, name="page", daemon=True
        )
        self._thread.start()

    @property
    def url(self) -> str:
        host, port = str(self._server.server_address[0]), self._server.server_address[1]
        name = f"[{host}]" if ":" in host else host
        return f"http://{name}:{port}/"

    def show(self, subject: Subject) -> None:
        """Show something else from now on."""
        self._server.subject = subject

    def close(self) -> None:
        """Stop serving; may be called twice."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


def open_page(subject: Subject, port: int, host: str = HOST) -> Page:
    """Serve a page about a subject; port: 0 = any that is free; host: an address of this machine.

    Raises ValueError for a port or host that cannot be had.
    """
    if not 0 <= port <= 65535:
        raise ValueError(f"page: expected a port from 0 to 65535, got {port}")
    try:
        return Page(_Server(host, port, subject))
    except socket.gaierror as error:
        raise ValueError(f"host: expected an address of this machine, got {host!r}") from error
    except OSError as error:
        if error.errno in _NOT_THERE:
            raise ValueError(f"host: expected an address of this machine, got {host!r}") from error
        if error.errno == errno.EADDRINUSE:
            raise ValueError(f"page: port {port} is in use; give another, or 0 for any") from error
        found = error.strerror or "it cannot be had"
        raise ValueError(f"page: expected a port that may be used, got {port} ({found})") from error


class _Server(HTTPServer):
    """A server with a few threads; who comes while too many wait is sent away."""

    request_queue_size = 16
    allow_reuse_address = sys.platform != "win32"  # there it means to share a port

    def __init__(self, host: str, port: int, subject: Subject) -> None:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        self.address_family = family
        self.subject = subject
        self.is_loopback = _is_loopback(host)
        self._pool = ThreadPoolExecutor(N_ANSWERING, thread_name_prefix="page")
        self._places = threading.BoundedSemaphore(N_ANSWERING + N_WAITING)
        super().__init__((host, port), _Handler)

    def server_bind(self) -> None:
        """Bind without asking the network for a name, which may take long."""
        self.socket.setsockopt(
            socket.SOL_SOCKET, socket.SO_REUSEADDR, int(self.allow_reuse_address)
        )
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()

    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._places.acquire(blocking=False):
            self.shutdown_request(request)
            return
        self._pool.submit(self._answer, request, client_address)

    def _answer(self, request: Any, client_address: Any) -> None:
        try:
            self.finish_request(request, client_address)
        except OSError:
            pass  # a browser that has gone
        finally:
            self.shutdown_request(request)
            self._places.release()

    def server_close(self) -> None:
        super().server_close()
        self._pool.shutdown(wait=False, cancel_futures=True)


class _Handler(BaseHTTPRequestHandler):
    """Answer one request and close: a browser that is left open holds no thread."""

    server: _Server
    timeout = TIMEOUT_S
    server_version = "curiosight"
    sys_version = ""

    def do_GET(self) -> None:
        if not self._is_from_here():
            return
        try:
            self._show()
        except OSError:
            raise  # a browser that has gone
        except Exception as error:  # what is shown fails, the page does not
            self._send_json({"error": str(error)}, HTTPStatus.INTERNAL_SERVER_ERROR)

    do_HEAD = do_GET

    def _show(self) -> None:
        path = self.path.partition("?")[0]
        subject = self.server.subject
        if path in FILES:
            name, kind = FILES[path]
            self._send(HTTPStatus.OK, kind, files(__package__).joinpath(name).read_bytes())
        elif path in ("/state.json", "/live.json", "/plan.json"):
            answer = {"/state.json": subject.state, "/live.json": subject.live}
            self._send_json(answer.get(path, subject.plan)())
        elif path.endswith(".jpg") and (jpeg := subject.picture(path[1:-4])) is not None:
            self._send(HTTPStatus.OK, "image/jpeg", jpeg)
        else:
            self._send_json({"error": "there is no such thing"}, HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        if not self._is_from_here(is_command=True):
            return
        try:
            said = self.server.subject.command(self.path[1:], self._value())
        except ValueError as mistake:
            self._send_json({"error": str(mistake)}, HTTPStatus.BAD_REQUEST)
        except Exception as error:  # a disk that is full, say: the watch goes on
            self._send_json({"error": str(error)}, HTTPStatus.INTERNAL_SERVER_ERROR)
        else:
            self._send_json({"done": said})

    def _value(self) -> Any:
        """Return what a command's body says: JSON, null where there is none."""
        length = self.headers.get("Content-Length", "0")
        if not length.isdecimal() or int(length) > MOST_BODY:
            raise ValueError(f"body: expected up to {MOST_BODY} bytes of JSON, got {length}")
        body = self.rfile.read(int(length))
        try:
            return json.loads(body) if body.strip() else None
        except ValueError as error:
            raise ValueError(f"body: expected JSON, got {body[:40]!r}") from error

    def _is_from_here(self, *, is_command: bool = False) -> bool:
        """Refuse what another site asks a browser to send, or a name that it made its own."""
        host = self.headers.get("Host", "")
        origin = self.headers.get("Origin")
        is_ours = not self.server.is_loopback or _is_loopback(_name_of(host))
        if is_command and origin is not None:
            is_ours = is_ours and origin.partition("://")[2] == host
        if not is_ours:
            self._send_json({"error": "this page answers itself alone"}, HTTPStatus.FORBIDDEN)
        return is_ours

    def _send_json(self, content: Any, status: HTTPStatus = HTTPStatus.OK) -> None:
        body = json.dumps(content, allow_nan=False).encode()
        self._send(status, "application/json", body)

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: the terminal is the program's."""


def _name_of(host: str) -> str:
    """Return a Host header without its port."""
    if host.startswith("["):
        return host[1:].partition("]")[0]
    return host.partition(":")[0]


def _is_loopback(name: str) -> bool:
    if name == "localhost":
        return True
    try:
        return ip_address(name).is_loopback
    except ValueError:
        return False
