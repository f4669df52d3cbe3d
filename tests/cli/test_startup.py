"""What a command imports: nothing that it does not use. A list of modules is the same on a busy machine."""

import json
import subprocess
import sys

import pytest

HEAVY = ("h5netcdf", "jinja2", "matplotlib", "numpy", "pandas", "pydantic", "rich", "scipy", "tomlkit", "xarray")
SWIM = ("swim", "--robot", "hypertuna", "--gait", "unoptimised-max")
TYPER = "pydantic"  # builds the parser of every command


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
    assert modules & set(HEAVY) <= {TYPER}
    rooms = {name.split(".")[1] for name in modules if name.startswith("hypertuna.")}
    assert rooms <= {"_core", "cli", "errors", "io"}


@pytest.mark.parametrize("arguments", [SWIM, (*SWIM, "--json")])
def test_swim_imports_what_it_uses(arguments: tuple[str, ...]) -> None:
    modules = imported(*arguments)
    assert modules & set(HEAVY) <= {"numpy", "pydantic", "tomlkit", *(["rich"] if "--json" not in arguments else [])}
    assert "rich.progress" not in modules
    rooms = {name.split(".")[1] for name in modules if name.startswith("hypertuna.")}
    assert rooms <= {"_core", "cli", "description", "errors", "io", "metrics", "swimming"}
