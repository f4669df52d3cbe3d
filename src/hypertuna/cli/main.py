"""The program `hypertuna`: commands, and what becomes of bad input."""

from __future__ import annotations

import contextlib
import platform
import signal
import sys
import threading
from typing import Annotated, Any

import typer

from hypertuna import _core
from hypertuna.cli.actuator import actuator_app
from hypertuna.cli.bend import bend_command
from hypertuna.cli.console import print_json
from hypertuna.cli.dive import dive_command
from hypertuna.cli.drive import drive_command
from hypertuna.cli.experiment import ask_command, tell_command
from hypertuna.cli.fe.app import fe_app
from hypertuna.cli.fil import fil_command
from hypertuna.cli.firmware import firmware_app
from hypertuna.cli.identify import identify_command
from hypertuna.cli.link import link_app
from hypertuna.cli.log import log_app
from hypertuna.cli.mission import mission_command
from hypertuna.cli.optimize import optimize_app
from hypertuna.cli.pareto import pareto_command
from hypertuna.cli.posture import posture_command
from hypertuna.cli.pump import pump_command
from hypertuna.cli.range import range_command
from hypertuna.cli.replay import replay_command
from hypertuna.cli.reproduce import reproduce_command
from hypertuna.cli.robot import robot_app
from hypertuna.cli.swim import sweep_command, swim_command
from hypertuna.cli.trials import trials_app
from hypertuna.cli.turn import turn_command
from hypertuna.cli.twin import twin_command
from hypertuna.errors import InputError
from hypertuna.io.files import version

__all__ = ["app", "main"]

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("swim")(swim_command)
app.command("sweep")(sweep_command)
app.command("replay")(replay_command)
app.command("turn")(turn_command)
app.command("twin")(twin_command)
app.command("dive")(dive_command)
app.command("mission")(mission_command)
app.command("drive")(drive_command)
app.command("posture-test")(posture_command)
app.command("identify")(identify_command)
app.command("reproduce")(reproduce_command)
optimize_app.command("ask")(ask_command)
optimize_app.command("tell")(tell_command)
app.add_typer(optimize_app, name="optimize")
app.command("pareto")(pareto_command)
app.command("bend")(bend_command)
app.command("fil")(fil_command)
app.add_typer(actuator_app, name="actuator")
app.add_typer(fe_app, name="fe")
app.add_typer(firmware_app, name="firmware")
app.command("pump")(pump_command)
app.command("range")(range_command)
app.add_typer(log_app, name="log")
app.add_typer(link_app, name="link")
app.add_typer(robot_app, name="robot")
app.add_typer(trials_app, name="trials")

INTERRUPTED = 130  # exit code after Ctrl-C, which the parser may catch itself
UsageError: Any = typer.BadParameter.__mro__[1]  # of the parser that typer brings along: unknown options and the like


def _print_version(wished: bool) -> None:
    """Print the version and stop, if it is asked for."""
    if wished:
        print(f"hypertuna {version()}")
        raise typer.Exit


@app.callback()
def program(
    wish_version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Open digital twin of hydraulic soft robotic fish. Exit code 2 means bad input."""


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
    """Run the program: what goes wrong becomes one sentence on the error output, and exit code 2."""
    _end_as_interrupted()
    try:
        code = app(standalone_mode=False)
        sys.stdout.flush()
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        code = 2
    except UsageError as error:
        if sentence := error.format_message():  # without one, the help was printed
            print(f"error: {sentence} See `{_command(error.ctx)} --help`.", file=sys.stderr)
        code = 2
    except ValueError as error:
        if not str(error).startswith("HYPERTUNA_ISA"):
            raise
        print(f"error: {error}.", file=sys.stderr)
        code = 2
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except BrokenPipeError:  # whoever read the output has stopped
        code = 1
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        print(f"error: {place}{error.strerror or error}.", file=sys.stderr)
        code = 2
    except MemoryError:
        print("error: there is not enough memory: ask for fewer gaits, steps or seconds.", file=sys.stderr)
        code = 2
    if code == INTERRUPTED:
        print("interrupted", file=sys.stderr)
    _drop_unwritable_output()
    sys.exit(code)


def _end_as_interrupted() -> None:
    """Let a terminal that is closed, and SIGTERM, end the program as Ctrl-C does; not what nohup holds back."""
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def _command(context: Any) -> str:
    """Spell the command that a parser's context is of."""
    names: list[str] = []
    while context is not None and context.parent is not None:
        names, context = [context.info_name, *names], context.parent
    return " ".join(["hypertuna", *names])


def _drop_unwritable_output() -> None:
    """Close an output that takes no more, lest Python complain of it at exit."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError):
            sys.stdout.close()
