"""Lines of src/hypertuna that each test executes, here and in processes that it starts; a plugin of pytest.

One line of JSON a test: its name, seconds of the processor, and the lines by module. Lines at import have the name "",
those that collect a file of tests the name of the file.
"""

import atexit
import contextlib
import functools
import importlib
import json
import os
import sys
import threading
from collections import defaultdict
from collections.abc import Generator
from multiprocessing import util
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

FOLDER = Path(os.environ["HYPERTUNA_LINES"])
PACKAGE = str(Path(__file__).resolve().parents[3] / "src" / "hypertuna") + os.sep
SEEN: dict[str, set[int]] = defaultdict(set)  # lines executed since the last test, by module


def _called(frame: FrameType, event: str, argument: object) -> Any:
    """Trace the lines of the package's functions only."""
    return _line(frame, event, argument) if frame.f_code.co_filename.startswith(PACKAGE) else None


def _line(frame: FrameType, event: str, argument: object) -> Any:
    """Record a line."""
    SEEN[frame.f_code.co_filename].add(frame.f_lineno)
    return _line


def write(test: str, seconds: float = 0.0) -> None:
    """Write and forget the lines seen so far."""
    lines = {file.removeprefix(PACKAGE): sorted(lines) for file, lines in SEEN.items()}
    with (FOLDER / f"{os.getpid()}.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"test": test, "seconds": seconds, "lines": lines}) + "\n")
    SEEN.clear()


def follow() -> None:
    """Trace this process and its forks; a process that a test started writes its lines at exit."""
    atexit.register(sys.settrace, None)
    if test := os.environ.get("PYTEST_CURRENT_TEST"):
        atexit.register(write, test.rpartition(" (")[0])
    util.register_after_fork(_line, _forked)
    threading.settrace(_called)
    sys.settrace(_called)


def _forked(_: object) -> None:
    """Trace a process of multiprocessing, which ends without `atexit`."""
    SEEN.clear()
    util.Finalize(None, write, (os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" (")[0],), exitpriority=0)


def pytest_configure() -> None:
    """Import everything, so that no test is the first to import a module."""
    for path in sorted(Path(PACKAGE).rglob("*.py")):
        name = ".".join(path.relative_to(Path(PACKAGE).parent).with_suffix("").parts).removesuffix(".__init__")
        if path.stem != "__main__":
            with contextlib.suppress(ImportError):  # an extra is absent
                importlib.import_module(name)
    write("")


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    """Record the lines that collecting a file executes."""
    result = yield
    write(collector.nodeid.partition("::")[0])
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, Any, Any]:
    """Record the lines that a test and its fixtures execute, with caches of earlier tests cleared."""
    for name, module in list(sys.modules.items()):
        for value in list(vars(module).values()) if name.startswith("hypertuna") else ():
            if isinstance(value, functools._lru_cache_wrapper):
                value.cache_clear()
    start = sum(os.times()[:4])
    result = yield
    write(item.nodeid, sum(os.times()[:4]) - start)
    return result


follow()
