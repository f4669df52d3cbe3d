"""What finite elements need beyond hypertuna itself: the extra `fe`, asked for where it is used."""

from __future__ import annotations

import ctypes
import os
from importlib.util import find_spec

from hypertuna.errors import InputError

__all__ = ["HOW", "need_fe", "need_pictures", "need_screenless"]

HOW = "pip install 'hypertuna[fe]'"


def need_fe() -> None:
    """Check that NGSolve and its mesher are there, and keep them on one thread and quiet."""
    _need("ngsolve", "netgen")
    import ngsolve

    ngsolve.SetNumThreads(1)  # a thread more would change the order of sums, so the last digits
    ngsolve.ngsglobals.msg_level = 0


def need_pictures() -> None:
    """Check that PyVista is there, which draws deformed shapes."""
    _need("pyvista")


def need_screenless() -> None:
    """Check that pictures can be drawn here: PyVista, and a library that draws without a screen."""
    need_pictures()
    libraries = ["libEGL.so.1", "libOSMesa.so.8", *(["libGL.so.1"] if os.environ.get("DISPLAY") else [])]
    if not any(map(_loadable, libraries)):
        rule = "need a library that draws without a screen, and there is neither EGL nor OSMesa"
        fix = "apt-get install libosmesa6, or leave the pictures out with --no-pictures"
        raise InputError(rule, key="pictures", fix=fix)


def _need(*modules: str) -> None:
    """Check that modules can be imported."""
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise InputError("is needed by finite elements and is not installed", key=missing[0], fix=HOW)


def _loadable(library: str) -> bool:
    """Tell whether a shared library can be loaded; without one, VTK would end the whole process."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
