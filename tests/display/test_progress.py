"""Progress on a terminal and in a notebook."""

import re
import sys
import time
from types import SimpleNamespace

import pytest

import hypertuna as ht


def test_a_progress_bar_is_a_line_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    report = ht.progress_bar("gaits")
    report(10, 10)
    assert capsys.readouterr().err == ""  # no terminal
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    report(10, 10)
    assert capsys.readouterr().err == ""  # too fast to be seen
    now = time.monotonic()
    monkeypatch.setattr("time.monotonic", lambda: now + 3)
    report(5, 10)
    report(6, 10)
    report(10, 10)
    assert re.sub(" +", " ", capsys.readouterr().err) == "\r5 of 10 gaits, 3 s left \r10 of 10 gaits, 3 s \n"


class Clock:
    """A clock that is set."""

    now = 100.0

    def __call__(self) -> float:
        """Return the time."""
        return self.now


def test_progress_is_shown_after_half_a_second_and_ten_times_a_second(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = Clock()
    monkeypatch.setattr("time.monotonic", clock)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    report = ht.progress_bar("gaits")
    shown = []
    for now, count in ((100.45, 1), (100.5, 2), (100.59, 3), (100.61, 4), (104.0, 0), (104.05, 10)):
        clock.now = now
        report(count, 10)
        shown.append(capsys.readouterr().err)
    texts = [text.strip("\r\n ") for text in shown]
    assert texts == [
        *("", "2 of 10 gaits, 2 s left", "", "4 of 10 gaits, 1 s left", "0 of 10 gaits, 4 s", "10 of 10 gaits, 4 s"),
    ]
    assert [text[-1:] for text in shown] == ["", " ", "", " ", " ", "\n"]
    assert len(shown[1]) == 61


def test_progress_in_a_notebook_is_one_line_that_vanishes(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, calls = Clock(), []
    monkeypatch.setattr("time.monotonic", clock)

    class Handle:
        def update(self, content: dict[str, str], raw: bool = False) -> None:
            calls.append(("update", raw, content["text/html"]))

    def place(content: dict[str, str], raw: bool = False, display_id: bool = False) -> Handle | None:
        calls.append((f"place {display_id}", raw, content["text/html"]))
        return Handle() if display_id else None

    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=1)))
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=place))
    report = ht.progress_bar("gaits")
    for count in (1, 2, 4):
        clock.now += 1
        report(count, 4)
    bar = '<progress value="{0}" max="4"></progress> {0} of 4 gaits, {1} s left'
    assert calls == [("place True", True, bar.format(1, 3)), ("update", True, bar.format(2, 2)), ("update", True, "")]
    calls.clear()
    report = ht.progress_bar("gaits")
    report(4, 4)  # at once: nothing to take away
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace()))
    clock.now += 1
    ht.progress_bar("gaits")(1, 4)  # a shell without notebook
    assert not calls
