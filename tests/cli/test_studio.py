"""`hypertuna studio`: the page of the package with a robot in it, served to this machine alone or written to a file."""

import base64
import contextlib
import gzip
import html
import http.client
import json
import os
import re
import shlex
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import hypertuna as ht
from hypertuna.identification.image import sampled_image
from hypertuna.mission.log import write_log
from hypertuna.reports.studio import studio_command as command_at
from program import Run
from voyage import voyage

ROOT = Path(__file__).parents[2]
LOG = re.compile(r'<script type="text/plain" id="log" data-name="([^"]*)">([^<]*)</script>')
SCRIPT = re.compile(r'<script type="application/json" id="robots">(.*?)</script>', re.DOTALL)


def robots_of(page: str) -> dict[str, Any]:
    """Read the robots of a page, of which it has one list."""
    (content,) = SCRIPT.findall(page)
    data: dict[str, Any] = json.loads(content)
    return data


@contextmanager
def serving(*arguments: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """Run the command until the end of the test."""
    command = [sys.executable, "-m", "hypertuna", "studio", *arguments]
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # a shell may have its jobs ignore it
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(command, env=os.environ | environment, preexec_fn=heard, **pipes)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def address_of(process: subprocess.Popen[str]) -> tuple[str, int]:
    """Return host and port of the address that a command prints first."""
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.fullmatch(r"studio: http://([\d.]+):(\d+)/\n", line)
    assert found, line
    return found[1], int(found[2])


def get(host: str, port: int, path: str = "/", method: str = "GET", **headers: str) -> http.client.HTTPResponse:
    """Ask a server."""
    connection = http.client.HTTPConnection(host, port, timeout=60)
    connection.request(method, path, headers=headers)
    return connection.getresponse()


def test_the_page_is_served_with_the_robot_and_its_gait() -> None:
    with serving("rexeel", "--gait", "wave-30", "--no-open") as process:
        host, port = address_of(process)
        answer = get(host, port)
        page = answer.read().decode()
        assert answer.status == 200
        assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
        assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
        data, fish = robots_of(page), ht.load("rexeel")
        assert data["robots"][0]["name"] == "rexeel"
        assert gzip.decompress(base64.b64decode(data["robots"][0]["image"])) == sampled_image(fish)
        names = [one["name"] for one in data["robots"]]
        assert len(set(names)) == len(names)
        assert "hypertuna" in names  # the robots of the page stay
        gait = ht.named_gait(fish, "wave-30")
        assert data["start"]["robot"] == "rexeel"
        assert ht.Gait(**data["start"]["gait"]) == gait
        assert get(host, port, method="HEAD").read() == b""
        assert get(host, port, "/etc/passwd").status == 404
        assert get(host, port, "/favicon.ico").status == 204
        assert get(host, port, Host=f"elsewhere.example:{port}").status == 403
        assert get(host, port, Host="localhost:1").status == 200  # through a tunnel


def test_the_gait_that_the_studio_takes_is_named_where_there_is_a_choice() -> None:
    """`hypertuna swim` asks which of several gaits is meant: the studio takes the first, and says so."""
    named = (
        "It begins with the robot's first gait, unoptimised-max. The page has the others; --gait begins with another."
    )
    for arguments, told in ((), True), (("--gait", "turning"), False), (("rexeel-theory", "--gait", "wave-30"), False):
        with serving(*arguments, "--no-open") as process:
            address_of(process)
            assert process.stdout is not None
            lines = [process.stdout.readline() for _ in range(1 + told)]
            text = " ".join("".join(lines).split())
            assert (named in text) is told, text


def test_only_this_machine_is_served() -> None:
    with serving("--no-open") as process:
        host, port = address_of(process)
        assert host == "127.0.0.1"
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", port), timeout=5)  # another address of this very machine
        sockets = Path(f"/proc/{process.pid}/net/tcp").read_text().splitlines()[1:]
        listening = [
            row.split()[1] for row in sockets if row.split()[3] == "0A" and row.split()[1].endswith(f"{port:04X}")
        ]
        assert listening == [f"0100007F:{port:04X}"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_it_in_a_sentence(number: signal.Signals) -> None:
    with serving("--no-open") as process:
        _, port = address_of(process)
        process.send_signal(number)
        _, told = process.communicate(timeout=60)
        assert told == f"interrupted: the studio at http://127.0.0.1:{port}/ is closed\n"
        assert process.returncode == 130


def test_a_busy_port_is_a_sentence(run: Run) -> None:
    with socket.create_server(("127.0.0.1", 0)) as busy:
        port = busy.getsockname()[1]
        code, _, told = run("studio", "--no-open", "--port", f"{port}")
    assert code == 2
    assert told == (
        f"error: --port must be a free port, but is {port} (Address already in use): give another one, or leave it "
        "out for a free one.\n"
    )


PAGE = b"<title>page</title>" + bytes(4_000_000)  # more than the system keeps of what nobody reads


@contextmanager
def server(**limits: float) -> Iterator[int]:
    """Serve a page in this process, by other limits; return the port."""
    from hypertuna.cli import studio

    with pytest.MonkeyPatch.context() as patch, studio._server(PAGE, 0) as made:
        for name, value in limits.items():
            patch.setattr(studio, name, value)
        thread = threading.Thread(target=made.serve_forever, args=(0.05,))
        thread.start()
        try:
            yield made.server_port
        finally:
            made.shutdown()
            thread.join()


def ended(connection: socket.socket, seconds: float) -> bool:
    """Return whether the server ends a connection within a time."""
    connection.settimeout(seconds)
    try:
        while connection.recv(65536):
            pass
    except TimeoutError:
        return False
    except ConnectionError:
        pass
    return True


@pytest.mark.parametrize(
    ("name", "status"),
    [
        *((name, 200) for name in ("127.0.0.1", "localhost", "LOCALHOST", "localhost.", "127.0.0.1.", "[::1]")),
        *((name, 403) for name in ("", "elsewhere.example", "localhost.example", "127.0.0.1.example", "localhost@x")),
        *((name, 403) for name in ("xlocalhost", "127.0.0.11", "localhost:80x", "[::1", "::1", "localhost:")),
    ],
)
def test_a_browser_asks_by_a_name_of_this_machine(name: str, status: int) -> None:
    """Port 80 is not named by a browser, and a tunnel has a port of its own."""
    with server() as port:
        for suffix in ("", ":80", f":{port}"):
            assert get("127.0.0.1", port, method="HEAD", Host=name + suffix).status == status, name + suffix


def test_a_browser_that_goes_away_is_no_traceback(capfd: pytest.CaptureFixture[str]) -> None:
    reset = struct.pack("ii", 1, 0)  # linger for no time: a reset in place of an end
    with server() as port:
        for request in (b"", b"G", b"GET / HTTP/1.1\r\nHost: local", b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"):
            for hard in (False, True):
                with socket.create_connection(("127.0.0.1", port), timeout=5) as connection:
                    connection.sendall(request)
                    time.sleep(0.1)
                    if hard:
                        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, reset)
        assert get("127.0.0.1", port).read() == PAGE
        time.sleep(0.2)
    assert capfd.readouterr() == ("", "")


def test_a_fault_of_the_server_is_told(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from hypertuna.cli import studio

    monkeypatch.setattr(studio, "HEADERS", None)
    with server() as port, pytest.raises(http.client.HTTPException):
        get("127.0.0.1", port)
    assert "AttributeError" in capfd.readouterr().err


def test_a_connection_ends_that_lasts_too_long() -> None:
    """One that says nothing, one that asks a byte at a time, and one that reads nothing of what it asked for."""
    with server(PATIENCE=0.6) as port:
        idle, slow, deaf = (socket.create_connection(("127.0.0.1", port), timeout=5) for _ in range(3))
        with idle, slow, deaf:
            deaf.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
            begun = time.monotonic()
            with contextlib.suppress(ConnectionError):
                for byte in b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 100:
                    slow.sendall(bytes([byte]))
                    time.sleep(0.05)
                    if time.monotonic() - begun > 5:
                        pytest.fail("a slow request is read for ever")
            assert all(ended(one, 2) for one in (idle, slow))
            time.sleep(0.5)
            assert ended(deaf, 2)
        assert threading.active_count() < 10


def test_idle_connections_do_not_keep_a_browser_out() -> None:
    with server(MAX_CONNECTIONS=5, PATIENCE=100) as port, contextlib.ExitStack() as opened:
        before = threading.active_count()
        for _ in range(50):
            idle = [opened.enter_context(socket.create_connection(("127.0.0.1", port), timeout=5))]
        assert get("127.0.0.1", port).read() == PAGE
        time.sleep(0.3)
        assert threading.active_count() <= before + 5
        assert not ended(idle[-1], 0.2)  # the newest stay


def test_the_address_is_json_for_programs_and_opened_for_people(tmp_path: Path) -> None:
    seen = tmp_path / "seen"
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {seen}.new; mv {seen}.new {seen}\n')
    browser.chmod(0o755)
    with serving("--json", BROWSER=f"{browser} %s") as process:
        assert process.stdout is not None
        address = json.loads("".join(process.stdout.readline() for _ in range(3)))["address"]
        deadline = time.monotonic() + 60
        while not seen.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        assert seen.read_text().strip() == address


def test_no_browser_is_opened_where_there_is_no_desktop(tmp_path: Path) -> None:
    """A browser of the terminal would take the terminal."""
    from hypertuna.cli import studio

    opened: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(studio.webbrowser, "open", opened.append)
        patch.setattr(studio.sys, "platform", "linux")
        for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
            patch.delenv(name, raising=False)
        studio._open("http://127.0.0.1:1/")
        time.sleep(0.2)
    assert not opened


def test_the_page_is_written_whole(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "fish.html"
    assert run("studio", "hypertuna", "--gait", "turning", "-o", str(file), "--json") == (
        0,
        json.dumps({"file": str(file)}, indent=2) + "\n",
        "",
    )
    data = robots_of(file.read_text(encoding="utf-8"))
    assert data["start"]["gait"]["bias"] == pytest.approx([0.279, 0.436], abs=1e-3)
    assert run("studio", "hypertuna", "-o", str(file)) == (0, f"written: {file}\n", "")
    assert "gait" not in robots_of(file.read_text(encoding="utf-8"))["start"]
    assert os.listdir(tmp_path) == ["fish.html"]


def test_the_robot_of_a_fit_takes_the_place_of_its_namesake(run: Run, tmp_path: Path) -> None:
    document = (ROOT / "robots/hypertuna.toml").read_text(encoding="utf-8")
    fitted, file = tmp_path / "fit.toml", tmp_path / "fish.html"
    fitted.write_text(document.replace("mass_kg = 3.3", "mass_kg = 3.5"), encoding="utf-8")
    assert run("studio", str(fitted), "-o", str(file))[0] == 0
    data = robots_of(file.read_text(encoding="utf-8"))
    images = [one["image"] for one in data["robots"] if one["name"] == "hypertuna"]
    assert [gzip.decompress(base64.b64decode(image)) for image in images] == [sampled_image(ht.load(fitted))]


@pytest.mark.parametrize(
    ("robot", "gait", "model"),
    [
        ("hypertuna", "turning", {}),
        ("hypertuna", "optimised-0.4", {"water": "strip", "joints": "ideal"}),
        ("hypertuna", ht.Gait(2.0, (0.2, 0.3), (0.0, -1 / 3)), {"areas": "as-printed"}),
        ("examples/minnow.toml", "cruise", {}),
    ],
)
def test_the_command_on_a_page_opens_the_studio_where_the_page_is(
    run: Run, tmp_path: Path, robot: str, gait: str | ht.Gait, model: dict[str, str]
) -> None:
    fish = ht.load(ROOT / robot if "/" in robot else robot).using(**model)
    known = gait if isinstance(gait, ht.Gait) else ht.named_gait(fish, gait)
    words = shlex.split(command_at(fish, known))
    file = tmp_path / "fish.html"
    assert words[0] == "hypertuna"
    assert run(*words[1:], "-o", str(file))[0] == 0
    data = robots_of(file.read_text(encoding="utf-8"))
    assert gzip.decompress(base64.b64decode(data["robots"][0]["image"])) == sampled_image(fish)
    start = ht.Gait(**data["start"]["gait"])
    for key in ("frequency", "amplitude", "phase", "bias"):
        assert getattr(start, key) == pytest.approx(getattr(known, key), rel=1e-9, abs=1e-11)


def test_a_robot_that_is_in_no_file_has_no_command() -> None:
    fish = ht.load("hypertuna")
    other = fish.model_copy(update={"body": fish.body.model_copy(update={"mass": 3.5})})
    assert command_at(other, ht.named_gait(fish, "turning")) == ""


def test_the_log_of_a_mission_is_served_with_its_robot(tmp_path: Path) -> None:
    log = tmp_path / "a <mission>.mcap"
    write_log(voyage(20), log)
    with serving(str(log), "--gait", "turning", "--no-open") as process:
        host, port = address_of(process)
        page = get(host, port).read().decode()
    ((name, content),) = LOG.findall(page)
    assert html.unescape(name) == log.name
    assert base64.b64decode(content) == log.read_bytes()
    assert robots_of(page)["robots"][0]["name"] == "hypertuna"
    assert ht.Gait(**robots_of(page)["start"]["gait"]) == ht.named_gait(ht.load("hypertuna"), "turning")


def test_a_page_without_a_log_has_no_place_for_one(run: Run, tmp_path: Path) -> None:
    assert run("studio", "rexeel", "-o", str(tmp_path / "fish.html"))[0] == 0
    assert not LOG.findall((tmp_path / "fish.html").read_text(encoding="utf-8"))


def test_what_is_no_log_of_a_mission_is_one_sentence(run: Run, tmp_path: Path) -> None:
    def refused(content: bytes | None) -> str:
        file = tmp_path / "x.mcap"
        if content is not None:
            file.write_bytes(content)
        code, out, told = run("studio", str(file), "-o", str(tmp_path / "x.html"))
        assert (code, out) == (2, "")
        assert not (tmp_path / "x.html").exists()
        return told.replace(f"{tmp_path}/", "")

    assert refused(None) == ("error: x.mcap must be a file, but is missing: give the path of a .mcap file.\n")
    assert refused(b"<title>no log</title>") == (
        "error: x.mcap must be an MCAP file, but is something else: give a .mcap file.\n"
    )
    write_log(voyage(20), tmp_path / "whole.mcap")
    whole = (tmp_path / "whole.mcap").read_bytes()
    assert refused(whole[:20]).startswith("error: x.mcap must be a hypertuna log: it lacks the header")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("studio hypertunna", "robots/hypertunna.toml does not exist: did you mean hypertuna?"),
        ("studio --robot rexeel", "--robot is not an option of `hypertuna studio`: write the robot alone, such as "
         "`hypertuna studio hypertuna`."),
        ("studio rexeel --gait wave-1", "robots/rexeel.toml: gait must be a gait of the robot, but is 'wave-1': did "
         "you mean wave-10?"),
        ("studio -o fish.htm", "--output must end in .html, but is 'fish.htm': write fish.html."),
        ("studio -o nowhere/fish.html", "--output must be in a folder that exists, but is 'nowhere/fish.html': make "
         "the folder first."),
        ("studio --port 80000", "--port must be from 1 to 65535, but is 80000: leave it out for a free one."),
        ("studio --port 8000 -o fish.html", "--port applies to a page that is served: leave it out with --output, or "
         "leave --output out."),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(run: Run, arguments: str, sentence: str) -> None:
    assert run(*arguments.split()) == (2, "", f"error: {sentence}\n")
    assert not Path("fish.html").exists()
