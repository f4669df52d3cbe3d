"""The build backend of pyproject.toml: scikit-build-core's, after a check for what pip cannot install."""

import os
import shutil
import sysconfig

from scikit_build_core import build
from scikit_build_core.build import *  # noqa: F403

COMPILERS = ("c++", "g++", "clang++")  # the first on PATH is taken, as in make/environment.sh

# By default scikit-build-core takes the compiler that built Python, which may be missing on this machine.
if "CXX" not in os.environ and os.name == "posix":
    os.environ["CXX"] = next(filter(shutil.which, COMPILERS), "")


def check_machine():
    """End with a sentence for each missing part, before pip fetches the package's requirements."""
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
    """Return the requirements for building a wheel."""
    check_machine()
    return build.get_requires_for_build_wheel(config_settings)


def get_requires_for_build_editable(config_settings=None):
    """Return the requirements for building an editable installation."""
    check_machine()
    return build.get_requires_for_build_editable(config_settings)
