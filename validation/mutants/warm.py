"""Run pytest many times without its start: this process has imported the libraries, and forks for each run.

It reads a line of JSON a run: what `run` takes. It prints a line with the exit code, null if the run took too long.
The package and its tests are imported by the forks alone.
"""

import contextlib
import gc
import importlib
import json
import math
import os
import signal
import sys
import time
import traceback

import pytest

# Modules that are imported before the forks
LIBRARIES = "numpy scipy.integrate scipy.interpolate scipy.linalg scipy.ndimage scipy.optimize scipy.signal scipy.stats"
# More of them, which tests import
OTHERS = "_pytest.pytester hypothesis.extra.numpy matplotlib.pyplot pandas pydantic xarray zarr.testing gymnasium typer"


def run(arguments: list[str], environment: dict[str, str], log: str, limit: float | None) -> int | None:
    """Run pytest in a fork, in at most `limit` seconds, and end whatever it started; return its exit code."""
    child = os.fork()
    if not child:
        os.setsid()
        for descriptor, file, mode in ((0, os.devnull, os.O_RDONLY), (1, log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)):
            os.dup2(os.open(file, mode, 0o644), descriptor)
        os.dup2(1, 2)
        os.environ.update(environment)
        sys.modules["sitecustomize"].MUTANT = json.loads(environment.get("HYPERTUNA_MUTANT", "null"))  # type: ignore[attr-defined]
        sys.argv, sys.path[0] = ["pytest", *arguments], os.getcwd()  # as of python -m pytest
        code = 3
        try:
            code = pytest.main(arguments)
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    try:
        end, parent = math.inf if limit is None else time.monotonic() + limit, os.getppid()
        while time.monotonic() < end and os.getppid() == parent:  # which may be killed
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                return os.waitstatus_to_exitcode(status)
            time.sleep(0.01)
        return None
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        with contextlib.suppress(ChildProcessError):
            os.waitpid(child, 0)


if __name__ == "__main__":
    for name in [*LIBRARIES.split(), *OTHERS.split()]:
        with contextlib.suppress(ImportError):  # an extra is absent
            importlib.import_module(name)
    gc.freeze()  # else each fork looks through all that it did not make
    for line in sys.stdin:
        print(json.dumps(run(**json.loads(line))), flush=True)
