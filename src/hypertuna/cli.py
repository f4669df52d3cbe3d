"""The program `hypertuna`: commands, and what becomes of bad input."""

from __future__ import annotations

import platform
import sys
from typing import Annotated, Any

import typer

from hypertuna import _core
from hypertuna.cli_replay import replay_command
from hypertuna.cli_reproduce import reproduce_command
from hypertuna.cli_robot import robot_app
from hypertuna.cli_swim import sweep_command, swim_command
from hypertuna.console import print_json
from hypertuna.errors import InputError
from hypertuna.results import version

__all__ = ["app", "main"]

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Open digital twin of hydraulic soft robotic fish. Exit code 2 means bad input.",
)
app.command("swim")(swim_command)
app.command("sweep")(sweep_command)
app.command("replay")(replay_command)
app.command("reproduce")(reproduce_command)
app.add_typer(robot_app, name="robot")

UsageError: Any = typer.BadParameter.__mro__[1]  # of the parser that typer brings along: unknown options and the like


@app.command("version")
def version_command(as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False) -> None:
    """Print the version and the instruction set in use; HYPERTUNA_ISA chooses another."""
    facts = {"version": version(), "isa": _core.isa(), "isas": _core.isas(), "gaits_at_once": _core.lanes()}
    facts |= {"python": platform.python_version(), "machine": platform.machine()}
    if as_json:
        print_json(facts)
        return
    print(f"hypertuna {facts['version']}, Python {facts['python']} on {facts['machine']}")
    print(f"instruction set {_core.isa()} ({_core.lanes()} gaits at once); available: {', '.join(_core.isas())}")


def main() -> None:
    """Run the program: bad input becomes one sentence on the error output, and exit code 2."""
    try:
        code = app(standalone_mode=False)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        code = 2
    except UsageError as error:
        if sentence := error.format_message():  # without one, the help was printed
            print(f"error: {sentence} See `hypertuna --help`.", file=sys.stderr)
        code = 2
    except BrokenPipeError:  # whoever read the output has stopped
        sys.stderr.close()
        code = 1
    sys.exit(code)
