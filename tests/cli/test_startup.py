"""What a command imports: nothing that it does not use. A list of modules is the same on a busy machine."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from hypertuna.cli.environment import check_environment
from hypertuna.cli.main import COMMANDS, app

HEAVY = ("h5netcdf", "jinja2", "matplotlib", "numpy", "pandas", "pydantic", "rich", "scipy", "tomlkit", "xarray")
SWIM = ("swim", "--robot", "hypertuna", "--gait", "unoptimised-max")


def imported(*arguments: str) -> set[str]:
    """Return the modules that are loaded when `hypertuna` has run with arguments."""
    script = (
        "import atexit, json, sys\n"
        "atexit.register(lambda: print(json.dumps(sorted(sys.modules)), file=sys.stderr))\n"
        "from hypertuna.cli.main import main\n"
        f"sys.argv = ['hypertuna', *{arguments!r}]\n"
        "main()\n"
    )
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(json.loads(result.stderr.splitlines()[-1]))


def test_importing_hypertuna_imports_nothing_heavy() -> None:
    script = "import hypertuna, json, sys; print(json.dumps(sorted(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    modules = set(json.loads(result.stdout))
    assert not modules & {*HEAVY, "typer"}
    assert {name for name in modules if name.startswith("hypertuna")} <= {"hypertuna", "hypertuna.errors"}


@pytest.mark.parametrize("arguments", [("--help",), ("--version",), ("version",), ("version", "--json")])
def test_version_and_help_import_nothing_heavy(arguments: tuple[str, ...]) -> None:
    modules = imported(*arguments)
    assert not modules & set(HEAVY)
    rooms = {name.split(".")[1] for name in modules if name.startswith("hypertuna.")}
    assert rooms <= {"_core", "cli", "errors", "io", "ranges"}


@pytest.mark.parametrize("arguments", [SWIM, (*SWIM, "--json")])
def test_swim_imports_what_it_uses(arguments: tuple[str, ...]) -> None:
    modules = imported(*arguments)
    assert modules & set(HEAVY) <= {"numpy", "pydantic", "tomlkit", *(["rich"] if "--json" not in arguments else [])}
    assert "rich.progress" not in modules
    rooms = {name.split(".")[1] for name in modules if name.startswith("hypertuna.")}
    assert rooms <= {
        "_core",
        "arguments",
        "arrays",
        "cli",
        "description",
        "display",
        "errors",
        "io",
        "metrics",
        "pictures",
        "ranges",
        "swimming",
    }


def test_the_list_of_commands_says_what_each_command_is() -> None:
    """The lines of --help stand apart from the commands, which are imported when called."""
    checked = [(COMMANDS, get_command(app))]
    for table, group in checked:
        commands = group.commands  # type: ignore[attr-defined]  # of a group, which get_command may not return
        assert list(commands) == list(table)
        for name, (place, line) in table.items():
            help = " ".join((commands[name].help or "").split())
            assert help.startswith(line.rstrip(".")), name
            if isinstance(place, dict):
                checked.append((place, commands[name]))
    assert len(checked) > 1


@pytest.mark.parametrize("style", [b"\xff\xfe", b"foo: \x1b[31m bar\n", None], ids=["bytes", "signs", "device"])
def test_figures_take_no_style_from_the_folder_or_the_shell(tmp_path: Path, style: bytes | None) -> None:
    """Matplotlib reads a file of the present folder, which may never end, or hold signs for the terminal."""
    file = tmp_path / "matplotlibrc"
    file.write_bytes(style) if style is not None else file.symlink_to("/dev/zero")
    shell = os.environ | {"MPLBACKEND": "none", "MATPLOTLIBRC": "/dev/zero"}
    command = [sys.executable, "-m", "hypertuna", *SWIM, "--plot", "out.svg"]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=shell, timeout=300)
    assert (result.returncode, result.stderr) == (0, "")
    assert (tmp_path / "out.svg").read_bytes().endswith(b"</svg>\n")


@pytest.mark.parametrize(
    ("name", "value", "largest"),
    [
        ("SOURCE_DATE_EPOCH", "x", 253402300799),
        ("SOURCE_DATE_EPOCH", "1e9", 253402300799),
        ("SOURCE_DATE_EPOCH", "253402300800", 253402300799),
        ("SOURCE_DATE_EPOCH", "9" * 20, 253402300799),
        ("NUMPY_MADVISE_HUGEPAGE", "x", 1),
    ],
)
def test_a_number_of_the_shell_that_libraries_cannot_read_is_one_sentence(
    tmp_path: Path, name: str, value: str, largest: int
) -> None:
    """NumPy and Matplotlib would end with a traceback; 253402300800 s after 1970 the year 10000 begins."""
    command = [sys.executable, "-m", "hypertuna", *SWIM, "--plot", "out.svg"]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=os.environ | {name: value})
    rule = f"must be a whole number from 0 to {largest}, but is '{value}'"
    assert result.stderr == f"error: {name} {rule}: correct the variable, or unset {name}.\n"
    assert (result.returncode, result.stdout, list(tmp_path.iterdir())) == (2, "", [])


def test_variables_of_the_shell_without_a_value_are_as_if_unset(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {
        "SOURCE_DATE_EPOCH": "",
        "NUMPY_MADVISE_HUGEPAGE": "0",
        "NPY_PROMOTION_STATE": "legacy",
    }.items():
        monkeypatch.setenv(name, value)
    check_environment()
    present = [name for name in ("SOURCE_DATE_EPOCH", "NPY_PROMOTION_STATE") if name in os.environ]
    assert (present, os.environ["NUMPY_MADVISE_HUGEPAGE"]) == ([], "0")
