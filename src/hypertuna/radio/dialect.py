"""The robot's MAVLink dialect: generate pymavlink's classes from hypertuna.xml, and cache them (extra `radio`)."""

import functools
import hashlib
import importlib.util
import os
import subprocess
import sys
import warnings
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

from hypertuna.errors import InputError
from hypertuna.io.extras import need
from hypertuna.io.files import scratch, shipped, write_atomically

SILENT = 32767  # value of a field whose sensor does not answer
NAME = "pymavlink.dialects.v20.hypertuna"  # module name under which mavutil looks for the dialect


def need_radio() -> None:
    """Check that the packages of the extra `radio` are installed."""
    need("radio", "pymavlink", "serial", by="the radio")


def dialect_file() -> Path:
    """Return the path of hypertuna.xml."""
    return shipped("mavlink") / "hypertuna.xml"


@functools.cache
def dialect() -> Any:
    """Load the dialect's module; generate it first if the cache lacks this definition."""
    need_radio()
    os.environ["MAVLINK20"] = "1"  # protocol version of mavutil
    source = dialect_file()
    ingredients = source.read_bytes() + (source.parent / "generate.py").read_bytes() + version("pymavlink").encode()
    key = hashlib.sha256(ingredients).hexdigest()[:16]
    path = _cache() / f"mavlink_{key}.py"
    if not path.exists():
        _generate(source, path)
    spec = importlib.util.spec_from_file_location(NAME, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with warnings.catch_warnings(action="ignore"):  # of another package at import
        spec.loader.exec_module(module)
        import pymavlink.dialects.v20

    sys.modules[NAME] = module
    pymavlink.dialects.v20.hypertuna = module
    return module


@functools.cache
def mavutil() -> Any:
    """Load pymavlink.mavutil with the dialect."""
    dialect()
    with warnings.catch_warnings(action="ignore"):  # of another package at import
        from pymavlink import mavutil as module

        module.set_dialect("hypertuna")
    loaded: ModuleType = module
    return loaded


def _cache() -> Path:
    """Return the user's cache folder for generated dialects."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "hypertuna"


def _generate(source: Path, path: Path) -> None:
    """Generate the dialect's module from hypertuna.xml, and write it completely or not at all."""
    with scratch() as folder:
        module = folder / "dialect.py"
        command = [sys.executable, str(source.parent / "generate.py"), str(source), "Python3", str(module)]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode:
            lines = (result.stderr or result.stdout).strip().splitlines()
            value = f"not ({lines[-1] if lines else 'mavgen failed'})"
            raise InputError("must generate a module", file=str(source), value=value, fix="reinstall pymavlink")
        try:
            write_atomically(path, module.read_bytes())
        except InputError as error:
            fix = "set XDG_CACHE_HOME to a writable folder"
            raise InputError(error.rule, file=error.file, value=error.value, fix=fix) from None
