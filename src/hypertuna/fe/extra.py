"""Checks that the optional packages of finite elements, the extra `fe`, are installed."""

import ctypes
import os

from hypertuna.errors import InputError
from hypertuna.io.extras import need

BY = "finite elements"


def need_fe() -> None:
    """Check that NGSolve and Netgen are installed; set them to one thread and no output."""
    need("fe", "ngsolve", "netgen", by=BY)
    import ngsolve

    ngsolve.SetNumThreads(1)  # more threads change the order of sums and hence the last digits
    ngsolve.ngsglobals.msg_level = 0


def need_pictures() -> None:
    """Check that PyVista, which renders deformed shapes, is installed."""
    need("fe", "pyvista", by=BY)


def need_screenless() -> None:
    """Check that PyVista and a library for rendering without a screen are installed."""
    need_pictures()
    libraries = ["libEGL.so.1", "libOSMesa.so.8", *(["libGL.so.1"] if os.environ.get("DISPLAY") else [])]
    if not any(map(_loadable, libraries)):
        rule = "need a library for rendering without a screen, and there is neither EGL nor OSMesa"
        fix = "apt-get install libosmesa6, or leave the pictures out with --no-pictures"
        raise InputError(rule, key="pictures", fix=fix)


def _loadable(library: str) -> bool:
    """Return whether a shared library can be loaded; VTK ends the process without one."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
