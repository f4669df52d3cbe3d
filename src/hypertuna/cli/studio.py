"""The command `hypertuna studio`."""

import contextlib
import os
import re
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Annotated, Any

import typer

from hypertuna.cli import options as opt
from hypertuna.cli import streams
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import GaitOptions
from hypertuna.errors import InputError
from hypertuna.ranges import Whole

LOCALHOST = "127.0.0.1"  # the page is for this machine alone
# Host names by which a browser may request the page; a tunnel may use another port.
HOST_NAMES = re.compile(r"(127\.0\.0\.1\.?|localhost\.?|\[::1\])(:\d+)?", re.ASCII | re.IGNORECASE)
PATIENCE = 60.0  # s until a connection is closed: enough to send the page through a slow tunnel
MAX_CONNECTIONS = 64  # at a time; browsers open a few in advance
PORTS = Whole(min=1, max=65535)  # TCP ports that may be given
# Content security policy: the page may run its own code, also in workers, and fetch nothing.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; media-src data: blob:; font-src data:; connect-src data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {  # HTTP headers of every answer
    "Content-Type": "text/html; charset=utf-8",
    "Content-Security-Policy": POLICY,
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
}


def _offered(incomplete: str) -> list[str]:
    """Return the robots, robot files and logs whose names begin with the incomplete one."""
    return opt.offered_robots(incomplete) + opt.offered_files(incomplete, (".toml", ".mcap"))


@opt.grouped
def studio_command(
    gait: GaitOptions,
    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT|LOG.mcap",
            help="Name of a robot that comes with hypertuna, path of its file, a fitted one too, or a mission's log.",
            envvar="HYPERTUNA_ROBOT",
            autocompletion=_offered,
            show_default=False,
        ),
    ] = opt.ROBOT,
    log: Annotated[str | None, opt.text("--log", "Log of a mission to play with ROBOT.", "FILE")] = None,
    joints: opt.JointLaw = None,
    areas: opt.Areas = None,
    water: opt.WaterLaw = None,
    port: Annotated[int | None, opt.whole_number("--port", "Port of the address. (default: a free one)")] = None,
    no_open: Annotated[bool, opt.flag("--no-open", "Print the address; open no browser.")] = False,
    output: Annotated[str | None, opt.file("--output", "the page, instead of serving it,", ".html")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Turn the knobs of a swimming robot in the browser: a page of this machine alone, until Ctrl-C.

    It begins with the gait of the options, or the robot's first. A log of a mission is played in the view Sea, which
    needs the extra log; alone, it is played with the robot of its name that comes with hypertuna.
    """
    from hypertuna.reports.studio import Studio, robot_and_log

    subject, replayed = robot_and_log(robot, log)
    subject = subject.using(joints=joints, areas=areas, water=water)
    start = gait.make(subject) if gait.gait is not None or gait.given else None
    studio = Studio(subject, start, 0, replayed)
    if output is not None:
        _check_output(port, no_open)
        studio.save(output)
        emit({"file": output}, record=dict, lines=lambda _: (), written=(output,), as_json=as_json)
        return
    if port is not None:
        PORTS.check(port, "--port", "leave it out for a free one")
    with _server(studio.html.encode(), port or 0) as server:
        address = f"http://{LOCALHOST}:{server.server_port}/"
        streams.state["done"] = f"the studio at {address} is closed"
        first = next(iter(subject.gaits), "") if start is None and len(subject.gaits) > 1 else ""
        emit({"address": address}, record=dict, lines=lambda one: _lines(one["address"], first), as_json=as_json)
        if not no_open:
            _open(address)
        server.serve_forever()


def _check_output(port: int | None, no_open: bool) -> None:
    """Check that options of the server are not given together with --output."""
    for key, given in {"--port": port is not None, "--no-open": no_open}.items():
        if given:
            fix = "leave it out with --output, or leave --output out"
            raise InputError("applies to a page that is served", key=key, fix=fix)


def _lines(address: str, first: str) -> Iterator[Any]:
    """Yield the lines that the terminal shows: the studio's address, and the gait chosen among several."""
    yield f"studio: {address}", "bold"
    if first:
        yield f"It begins with the robot's first gait, {first}. The page has the others; --gait begins with another."
    yield "This machine alone can open it. Ctrl-C ends it."


class _Server(ThreadingHTTPServer):
    """A server that closes connections that last too long, and the oldest ones if there are too many."""

    request_queue_size = MAX_CONNECTIONS

    def __init__(self, page: bytes, port: int) -> None:
        self.begun: dict[socket.socket, float] = {}  # connection -> monotonic time [s] of its start
        super().__init__((LOCALHOST, port), _handler(page))

    def process_request(self, request: Any, client_address: Any) -> None:
        self.begun[request] = time.monotonic()
        super().process_request(request, client_address)

    def service_actions(self) -> None:
        """Close connections that last too long or are too many; called at each connection and twice a second."""
        now, ages = time.monotonic(), list(self.begun.items())
        for number, (connection, start_time) in enumerate(ages, start=MAX_CONNECTIONS - len(ages)):
            if number < 0 or now - start_time > PATIENCE:
                with contextlib.suppress(OSError):  # the browser has closed its end
                    connection.shutdown(socket.SHUT_RDWR)  # ends the reading of its thread

    def shutdown_request(self, request: Any) -> None:
        super().shutdown_request(request)
        self.begun.pop(request, None)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print no traceback for a browser that has closed its connection."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


def _server(page: bytes, port: int) -> _Server:
    """Return a server of a page for this machine alone; port 0 chooses a free one."""
    try:
        return _Server(page, port)
    except OSError as error:
        fix = "give another one, or leave it out for a free one"
        raise InputError("must be a free port", key="--port", value=f"{port} ({error.strerror})", fix=fix) from None


def _handler(page: bytes) -> type[BaseHTTPRequestHandler]:
    """Return a class of request handlers that serve the page at / alone."""

    class Handler(BaseHTTPRequestHandler):
        server_version, sys_version = "hypertuna", ""

        def do_GET(self) -> None:
            self._answer(body=True)

        def do_HEAD(self) -> None:
            self._answer(body=False)

        def log_message(self, *_: Any) -> None:
            """Print nothing: the terminal shows the address only."""

        def _answer(self, body: bool) -> None:
            """Send the page, or the error of the request; body: whether to send more than the headers."""
            # A page of another site, whose name resolves to this machine (DNS rebinding), must not read the robot.
            if not HOST_NAMES.fullmatch(self.headers.get("Host", "")):
                self.send_error(HTTPStatus.FORBIDDEN)
            elif self.path == "/favicon.ico":
                self.send_response(HTTPStatus.NO_CONTENT)
                self.end_headers()
            elif self.path.partition("?")[0] != "/":
                self.send_error(HTTPStatus.NOT_FOUND)
            else:
                self.send_response(HTTPStatus.OK)
                for name, value in HEADERS.items():
                    self.send_header(name, value)
                self.send_header("Content-Length", f"{len(page)}")
                self.end_headers()
                if body:
                    self.wfile.write(page)

    return Handler


def _open(address: str) -> None:
    """Open an address in the desktop's browser, if there is a desktop: a text browser would occupy the terminal."""
    desktop = sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
    if desktop:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
