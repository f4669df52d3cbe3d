"""The build backend of pyproject.toml: scikit-build-core's, which first looks for what pip cannot bring."""

import os
import shutil
import sysconfig

from scikit_build_core import build
from scikit_build_core.build import *  # noqa: F403

COMPILERS = ("c++", "g++", "clang++")  # of which make/environment.sh takes the first, too

# scikit-build-core takes the compiler that built Python, which need not be on this machine.
if "CXX" not in os.environ and os.name == "posix":
    os.environ["CXX"] = next(filter(shutil.which, COMPILERS), "")


def check_machine():
    """End with one sentence for each missing thing, before pip fetches what the package needs."""
    missing, packages = [], []
    if not os.environ.get("CXX", "anything"):
        missing.append(f"A C++ compiler is missing: none of {', '.join(COMPILERS)} is on PATH, and CXX names no other.")
        packages.append("g++")
    if not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")):
        missing.append("The headers of Python, Python.h, are missing.")
        packages.append("python3-dev")
    if missing:
        text = ["hypertuna cannot be built here yet.", *missing]
        text.append(f"On Debian and Ubuntu: sudo apt-get install {' '.join(packages)}")
        text += ["Or run `make demo` in a clone, which brings a compiler from PyPI."] * (packages == ["g++"])
        raise SystemExit("\n".join(text))


def get_requires_for_build_wheel(config_settings=None):
    """Return what a wheel is built with."""
    check_machine()
    return build.get_requires_for_build_wheel(config_settings)


def get_requires_for_build_editable(config_settings=None):
    """Return what an editable installation is built with."""
    check_machine()
    return build.get_requires_for_build_editable(config_settings)
