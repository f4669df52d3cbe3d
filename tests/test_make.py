"""The front door of a clone: the check of the machine, the environment, the progress (folder make/)."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.skipif(os.name != "posix", reason="make and sh")

OLD = "import sys\nsys.version_info = (3, 10, 12, 'final', 0)\n"
NO_VENV = "import sys\nsys.modules['ensurepip'] = None\n"
# as `python -m venv`, with an empty pip in place of the slow real one
QUICK = """import pathlib, sysconfig, venv
def pip(self, context):
    site = sysconfig.get_path("purelib", vars={"base": context.env_dir})
    (pathlib.Path(site) / "pip.py").touch()
venv.EnvBuilder._setup_pip = pip
"""
NO_HEADERS = "import sysconfig\nsysconfig.get_path = lambda *_: '/nonexistent'\n"


def write_program(path, text):
    path.unlink(missing_ok=True)  # a link is not followed
    path.write_text(f"#!{shutil.which('sh')}\n{text}\n")
    path.chmod(0o755)


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """Return a function that makes a PATH of Pythons, each this one with a fault, and of C++ compilers."""
    tools = tmp_path / "bin"
    for name in ("sh", "cat", "chmod", "uname"):
        tools.mkdir(exist_ok=True)
        (tools / name).symlink_to(shutil.which(name))

    def make(python=None, compiler="cat >/dev/null", *, quick=False):
        for name, fault in (python or {}).items():
            site = tmp_path / name
            site.mkdir()
            if fault:
                (site / "sitecustomize.py").write_text(fault)
            write_program(tools / name, f'export PYTHONPATH={site}:$PYTHONPATH\nexec {sys.executable} "$@"')
        if compiler is not None:
            write_program(tools / "c++", compiler)
        if quick:
            (tmp_path / "sitecustomize.py").write_text(QUICK)
            monkeypatch.setenv("PYTHONPATH", str(tmp_path))
        return tools

    return make


def environment(tools, folder, *python):
    """Run the check in a PATH; return its status and what it told."""
    ran = subprocess.run(
        ["sh", ROOT / "make/environment.sh", folder, *python],
        env={"PATH": str(tools), "PYTHONPATH": os.environ.get("PYTHONPATH", "")},
        capture_output=True,
        text=True,
    )
    return ran.returncode, ran.stderr


@pytest.mark.parametrize(
    ("python", "compiler", "told", "packages"),
    [
        ({}, "cat >/dev/null", "Python 3.11 or later is missing.", "python3 python3-venv python3-dev"),
        (
            {"python3": OLD},
            "cat >/dev/null",
            "Python 3.11 or later is missing: python3 is Python 3.10.12.",
            "python3.11 python3.11-venv python3.11-dev",
        ),
        ({"python3": NO_VENV}, "cat >/dev/null", "The module venv of python3 ", "python3-venv"),
        (
            {"python3": OLD, "python3.12": NO_VENV},
            "cat >/dev/null",
            "The module venv of python3.12 ",
            "python3.12-venv",
        ),
        ({"python3": NO_HEADERS}, "cat >/dev/null", "The headers of python3 ", "python3-dev"),
        ({"python3": ""}, "exit 1", "The C++ compiler {tools}/c++ does not run or does not know C++20;", "g++"),
        ({}, "exit 1", "Python 3.11 or later is missing.", "python3 python3-venv python3-dev g++"),
    ],
)
def test_each_missing_thing_is_a_sentence_with_its_package(machine, tmp_path, python, compiler, told, packages):
    tools = machine(python, compiler)
    status, errors = environment(tools, tmp_path / "made")
    assert status == 1
    assert told.format(tools=tools) in errors
    assert errors.splitlines()[-1] == f"  On Debian and Ubuntu: sudo apt-get install {packages}"
    assert "Traceback" not in errors
    assert not (tmp_path / "made").exists()


def python_of(folder):
    return subprocess.run([folder / "bin/python", "-c", "import pip"], capture_output=True).returncode


def test_an_environment_is_made_once_and_again_only_where_it_is_not_sound(machine, tmp_path):
    tools, folder = machine({"python3": ""}, quick=True), tmp_path / "made"
    assert environment(tools, folder) == (0, f"make: virtual environment {folder} of Python {sys.version.split()[0]}\n")
    stamp = (folder / ".python").stat().st_mtime_ns
    assert environment(tools, folder) == (0, "")
    assert (folder / ".python").stat().st_mtime_ns == stamp

    (folder / "bin/python").unlink()  # as when its Python was removed from the machine
    status, errors = environment(tools, folder)
    assert (status, python_of(folder)) == (0, 0)
    assert errors.startswith(f"make: {folder} is broken and is made again\n")

    write_program(folder / "bin/python", "echo 3.10 /somewhere")
    status, errors = environment(tools, folder)
    assert (status, python_of(folder)) == (0, 0)
    assert errors.startswith(f"make: {folder} is of Python 3.10 and is made again\n")

    moved = tmp_path / "moved"
    folder.rename(moved)
    status, errors = environment(tools, moved)
    assert status == 0
    assert errors.startswith(f"make: {moved} was made in another folder or by another Python and is made again\n")


def test_without_a_compiler_the_environment_has_that_of_zig(machine, tmp_path):
    tools, folder = machine({"python3": ""}, None, quick=True), tmp_path / "made"
    status, errors = environment(tools, folder)
    assert status == 0
    assert "no C++ compiler is installed: Zig's, from PyPI (ziglang), compiles instead\n" in errors
    (folder / "bin/python").unlink()
    write_program(folder / "bin/python", 'echo "$@"')  # shows what the compiler would be called with
    for tool in ("c++", "ar", "ranlib"):
        called = subprocess.run([folder / "bin" / tool, "-c", "a b.cpp"], capture_output=True, text=True)
        assert called.stdout.startswith(f"-m ziglang {tool} "), called.stderr
        assert called.stdout.endswith(" -c a b.cpp\n")
    assert not (tmp_path / "with").exists()
    environment(machine({}, "cat >/dev/null"), tmp_path / "with")
    assert not (tmp_path / "with/bin/c++").exists()


def test_a_sound_environment_that_somebody_else_made_is_kept(machine, tmp_path):
    tools, folder = machine({"python3": ""}, quick=True), tmp_path / "made"
    subprocess.run([tools / "python3", "-m", "venv", folder], check=True)
    (folder / "mine").touch()
    assert environment(tools, folder) == (0, "")
    assert (folder / "mine").exists()
    assert (folder / ".python").exists()


def progress(*command):
    return subprocess.run(
        [sys.executable, ROOT / "make/progress.py", "fish", *command], capture_output=True, text=True, timeout=60
    )


def test_progress_shows_steps_and_what_failed():
    lines = "print('Collecting numpy>=2'); print('  -- compiled by GNU 12.2.0, /usr/bin/c++'); "
    lines += "print('  [3/27] Building CXX object'); "
    fine = progress(sys.executable, "-c", lines)
    assert (fine.returncode, fine.stdout) == (0, "")
    first, last = fine.stderr.splitlines()
    assert first.startswith("make: fish: package numpy, ")
    assert last.startswith("make: fish: done, compiled by GNU 12.2.0, /usr/bin/c++, ")
    failed = progress(sys.executable, "-c", lines + "print('no such header'); raise SystemExit(3)")
    assert failed.returncode == 3
    assert failed.stderr.endswith("no such header\n")


@pytest.mark.skipif(not shutil.which("make"), reason="needs make")
def test_a_step_that_fails_stops_make_and_leaves_no_stamp(machine, tmp_path):
    tools, clone = machine({"python3": ""}, quick=True), tmp_path / "clone"
    shutil.copytree(ROOT / "make", clone / "make")
    shutil.copy(ROOT / "Makefile", clone)
    (clone / "pyproject.toml").write_text("[build-system]\nrequires = ['ninja']\n")
    environ = os.environ | {"PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", "LOCK": ""}
    command = ["make", ".venv/.tools"]  # pip is an empty file: it installs nothing and does not fail
    ran = subprocess.run(command, cwd=clone, capture_output=True, text=True, env=environ)
    assert ran.returncode == 0, ran.stderr
    (clone / "pyproject.toml").write_text("this is no TOML")
    os.utime(clone / ".venv/.tools", (0, 0))
    ran = subprocess.run(command, cwd=clone, capture_output=True, text=True, env=environ)
    assert ran.returncode != 0
    assert (clone / ".venv/.tools").stat().st_mtime == 0


def build_requirements(**environ):
    """Ask the build backend what it needs, as pip does before it fetches the package's dependencies."""
    text = "import backend; print(backend.get_requires_for_build_wheel()); print(backend.os.environ['CXX'])"
    return subprocess.run(
        [sys.executable, "-c", text], cwd=ROOT, env=environ | {"PYTHONPATH": "make"}, capture_output=True, text=True
    )


def test_pip_is_told_what_is_missing_before_it_fetches_anything_else(tmp_path):
    ran = build_requirements(PATH=str(tmp_path))
    assert (ran.returncode, ran.stdout) == (1, "")
    first, compiler, packages, make = ran.stderr.splitlines()
    assert first == "hypertuna cannot be built here yet."
    assert compiler.startswith("A C++ compiler is missing: none of c++, g++, clang++ is on PATH")
    assert packages == "On Debian and Ubuntu: sudo apt-get install g++"
    assert "`make demo`" in make
    assert build_requirements(PATH=str(tmp_path), CXX="mine").stdout.endswith("mine\n")


@pytest.mark.parametrize("compiler", ["c++", "g++", "clang++"])
def test_the_compiler_of_this_machine_is_taken_not_that_of_python(tmp_path, compiler):
    write_program(tmp_path / compiler, "exit 0")
    assert build_requirements(PATH=str(tmp_path)).stdout.splitlines()[-1] == compiler
