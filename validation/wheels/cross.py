"""Compile and link the extension of the stable ABI for other systems by Zig's Clang, and check the symbols it imports.

It needs a Python from 3.12 on, with the build tools of pyproject.toml and the extra `wheels`:

    python validation/wheels/cross.py [TARGET...]

The build is that of CMakeLists.txt without optimization. Nothing is run: a target that passes is not a tested one.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import abi3info
import nanobind

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/cross"  # folder of the builds
ABI = (3, 12)  # wheel.py-api of pyproject.toml
TARGETS = {  # name: (triple of Zig, system and processor of CMake, suffix of the extension)
    "windows-x86_64": ("x86_64-windows-gnu", "Windows", "AMD64", ".pyd"),
    "macos-arm64": ("aarch64-macos.11.0", "Darwin", "arm64", ".abi3.so"),
    "linux-aarch64": ("aarch64-linux-gnu.2.28", "Linux", "aarch64", ".abi3.so"),
    "musl-x86_64": ("x86_64-linux-musl", "Linux", "x86_64", ".abi3.so"),
}
# Definitions that Python's headers need on Windows; an extension needs no more of its pyconfig.h
WINDOWS = """#define MS_WIN32
#define MS_WIN64
#define MS_WINDOWS
#define SIZEOF_INT 4
#define SIZEOF_LONG 4
#define SIZEOF_LONG_LONG 8
#define SIZEOF_SIZE_T 8
#define SIZEOF_TIME_T 8
#define SIZEOF_VOID_P 8
#define SIZEOF_WCHAR_T 2
#define ALIGNOF_MAX_ALIGN_T 8
#define HAVE_DECLSPEC_DLL
#define Py_ENABLE_SHARED 1
"""


def run(*command, **options):
    """Run a command and return its output; exit with that output where the command fails."""
    ran = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if ran.returncode:
        sys.exit(f"{ran.stdout[-6000:]}\n{' '.join(map(str, command))}: status {ran.returncode}")
    return ran.stdout


def write_tools(folder, triple):
    """Write programs that run compiler and archiver, as CMake wants programs without arguments."""
    zig = f"exec {sys.executable} -m ziglang"
    # Nothing is run: no time is spent on optimizing. Zig's linker takes no list of symbols that are found at run time,
    # but a word that any may be.
    change = "-O[123]) a=-O0 ;; -Wl,@*.sym) a=-Wl,-undefined,dynamic_lookup ;;"
    arguments = f'for a; do shift; case $a in {change} esac; set -- "$@" "$a"; done'
    for name, text in {
        "c++": f'{arguments}\n{zig} c++ -target {triple} "$@"',
        "ar": f'{zig} ar "$@"',
        "ranlib": f'{zig} ranlib "$@"',
    }.items():
        (folder / name).write_text(f"#!/bin/sh\n{text}\n")
        (folder / name).chmod(0o755)


def python_of_windows(folder):
    """Write headers and import library of Python for Windows, with the stable ABI alone."""
    headers = folder / "include"
    shutil.copytree(sysconfig.get_path("include"), headers, dirs_exist_ok=True)
    (headers / "pyconfig.h").write_text(WINDOWS)
    names = [
        f"{symbol.name}{data}"
        for table, data in ((abi3info.FUNCTIONS, ""), (abi3info.DATAS, " DATA"))
        for symbol, entry in table.items()
        if (entry.added.major, entry.added.minor) <= ABI
    ]
    (folder / "python3.def").write_text("\n".join(["LIBRARY python3.dll", "EXPORTS", *sorted(names), ""]))
    library = folder / "libpython3.dll.a"
    run(sys.executable, "-m", "ziglang", "dlltool", "-m", "i386:x86-64", "-d", folder / "python3.def", "-l", library)
    return headers, library


def build(name):
    """Build the extension for a target; return its path."""
    triple, system, processor, suffix = TARGETS[name]
    folder = BUILD / name
    folder.mkdir(parents=True, exist_ok=True)
    write_tools(folder, triple)
    headers, library = Path(sysconfig.get_path("include")), None
    if system == "Windows":
        headers, library = python_of_windows(folder)
    defines = {
        "CMAKE_CXX_COMPILER": folder / "c++",
        "CMAKE_AR": folder / "ar",
        "CMAKE_RANLIB": folder / "ranlib",
        "CMAKE_CXX_COMPILER_AR": folder / "ar",
        "CMAKE_CXX_COMPILER_RANLIB": folder / "ranlib",
        "CMAKE_INSTALL_NAME_TOOL": "true",
        "CMAKE_SYSTEM_NAME": system,
        "CMAKE_SYSTEM_PROCESSOR": processor,
        "CMAKE_OSX_SYSROOT": "",
        "CMAKE_CXX_SCAN_FOR_MODULES": "OFF",
        "SKBUILD": 1,
        "SKBUILD_SABI_COMPONENT": "Development.SABIModule",
        "SKBUILD_SOABI": "cp312-cross",
        "SKBUILD_SOSABI": suffix.split(".")[1] if suffix.count(".") > 1 else "",
        "nanobind_DIR": nanobind.cmake_dir(),
        "Python_EXECUTABLE": sys.executable,
        "Python_INCLUDE_DIR": headers,
        **({"Python_LIBRARY": library, "Python_SABI_LIBRARY": library} if library else {}),
    }
    run("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *(f"-D{key}={value}" for key, value in defines.items()))
    run("cmake", "--build", folder, "--target", "_core")
    return folder / f"_core{suffix}"


def main(names):
    """Build and check each target."""
    if sys.version_info[:2] < ABI:
        sys.exit("Python 3.12 or later is needed, as for the stable ABI")
    for name in names or TARGETS:
        start = time.monotonic()
        extension = build(name)
        units = [path for end in ("o", "obj") for path in (BUILD / name / "CMakeFiles").glob(f"*.dir/**/*.{end}")]
        kernels = sorted(re.findall(r"kernel_(\w+)\.dir", " ".join(map(str, units))))
        run("abi3audit", "--strict", "--assume-minimum-abi3", "3.12", extension)
        print(f"{name}: {len(units)} units, kernels {', '.join(kernels)}; {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    main(sys.argv[1:])
