"""The program `hypertuna`: its commands, imported when called, and its exit codes."""

import errno
import gc
import pkgutil
import sys
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from hypertuna.cli.streams import (
    INTERRUPTED,
    drop_unwritable_output,
    end_on_signals,
    open_streams,
    tell,
    was_interrupted,
)
from hypertuna.errors import InputError, escaped

UsageError: Any = typer.BadParameter.__mro__[1]  # of the parser inside typer: unknown options and the like

# Each command: its function or group in hypertuna.cli, or the table of its commands; and its line in --help.
COMMANDS: dict[str, tuple[Any, str]] = {
    "swim": ("swim:swim_command", "Swim one gait: its settled beat, or from rest."),
    "sweep": ("sweep:sweep_command", "Swim every combination of frequencies, amplitudes, phases and biases."),
    "replay": ("replay:replay_command", "Swim measured joint angles, and compare the head's track with tracked poses."),
    "turn": ("turn:turn_command", "Turn by a one-sided beat: radius against phase, bias and frequency."),
    "twin": (
        "twin:twin_command",
        "Simulate the whole robot: controller, servos, pumps, oil, muscles, tail, water, sensors.",
    ),
    "dive": ("dive:dive_command", "Dive with the pectoral fins down for half of the time, then rise with them up."),
    "mission": ("mission:mission_command", "Fly a mission on the twin at sea, under its pilot."),
    "posture-test": ("posture:posture_command", "Test the posture control from rest to a set peak bend."),
    "identify": ("identify:identify_command", "Fit coefficients of a robot to measured runs, with their uncertainty."),
    "paper": ("paper:paper_command", "Compute the paper's numbers beside the published ones."),
    "optimize": (
        "optimize:optimize_app",
        "Find the best gait for an objective: speed, or an expected speed at low cost.",
    ),
    "pareto": ("pareto:pareto_command", "Find the Pareto front of gaits: NSGA-II, polished by exact gradients."),
    "hil": (
        "hil:hil_command",
        "Run the firmware in the loop: the twin at sea and the firmware on a board, in lock-step.",
    ),
    "joint": (
        {
            "bend": ("bend:bend_command", "Bend a soft joint in air: angle over pressure, up and down."),
            "fit": ("joint:fit_command", "Identify the unknowns of an actuator from bench pressures and bends."),
            "silicone": ("joint:silicone_command", "Fit the elastic constants of a silicone to a tensile test."),
        },
        "A soft joint: its bend in air, its actuator from a test bench, its silicone from a tensile test.",
    ),
    "fe": ("fe:fe_app", "The soft joints by finite elements; needs the extra fe."),
    "firmware": ("firmware:firmware_app", "Firmware: parameters from a robot's description, list of faults."),
    "pump": (
        "pump:pump_command",
        "Size the pump: torque, speed and stroke of its servos, drop and bandwidth of the lines.",
    ),
    "range": ("range:range_command", "Compute range and endurance on one battery charge."),
    "log": ("log:log_app", "Logs of missions and black boxes: summary, plot, table, track; needs the extra log."),
    "radio": (
        {
            "params": ("radio:params_command", "Read the parameters of a robot, or set some."),
            "log": ("radio:log_command", "Record all that a robot and its tank's camera send."),
            "mission": ("radio:mission_command", "Send a mission to a robot."),
            "calibrate": (
                "radio:calibrate_command",
                "Calibrate bend, pressure and current sensors and servos' zeros, from a CSV file or live.",
            ),
            "drive": ("drive:drive_command", "Drive a robot by keyboard or gamepad, with a live view of its messages."),
        },
        "A robot over the radio; needs the extra radio, and log for logs.",
    ),
    "robot": ("robot:robot_app", "Robot descriptions: print the format, check a file, show a robot."),
    "trials": ("trials:trials_app", "Tank trials: check them, import published ones."),
    "version": ("version:version_command", "Print the version and the instruction set in use."),
}

# Former names of commands, understood for one release.
RENAMED = {
    "fil": "hil",
    "reproduce": "paper",
    "link": "radio",
    "drive": "radio drive",
    "bend": "joint bend",
    "actuator": "joint",
}


class _Help:
    """A help option that is False, not None, when it is absent: typer need not import pydantic to read it."""

    def get_help_option(self, context: Any) -> Any:
        """Return the option --help."""
        option = super().get_help_option(context)  # type: ignore[misc]  # of typer's command, mixed in below
        if option is not None:
            option.default = False
        return option


class Command(_Help, TyperCommand):
    """A command."""


class _Commands(Mapping[str, Any]):
    """The commands of a table by name, each imported when it is asked for."""

    def __init__(self, table: Mapping[str, tuple[Any, str]]) -> None:
        self.table = table

    def __getitem__(self, name: str) -> Any:
        place, line = self.table[name]
        if isinstance(place, Mapping):
            return Group(name=name, help=line, table=place, no_args_is_help=True, rich_markup_mode=None)
        target = pkgutil.resolve_name(f"hypertuna.cli.{place}")
        if not isinstance(target, typer.Typer):
            function, target = target, typer.Typer(add_completion=False, rich_markup_mode=None)
            target.command(name, cls=Command)(function)
        command: Any = get_command(target)
        command.name = name
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(self.table)

    def __len__(self) -> int:
        return len(self.table)


class Group(_Help, TyperGroup):
    """A group of the commands of a table: lists them without importing them."""

    def __init__(self, *, table: Mapping[str, tuple[Any, str]] = COMMANDS, **options: Any) -> None:
        super().__init__(**options)
        self.commands: Any = _Commands(table)

    def list_commands(self, _: Any) -> list[str]:
        """List the names of the commands."""
        return list(self.commands)

    def format_commands(self, _: Any, formatter: Any) -> None:
        """Write the commands into the help."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, line) for name, (_, line) in self.commands.table.items()])


app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(asked: bool) -> None:
    """Print the version and stop."""
    if asked:
        from hypertuna.io.files import version

        print(f"hypertuna {version()}")
        raise typer.Exit


@app.callback()
def program(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Open digital twin of hydraulic soft robotic fish. Exit code 2 means bad input."""


def main() -> None:
    """Run the program: bad input is one sentence on the error output, and exit code 2."""
    gc.set_threshold(50_000)  # most of what the start makes stays: searched for garbage less often
    open_streams()
    end_on_signals()
    _take_former_name()
    code = _run()
    if was_interrupted() or code == INTERRUPTED:
        code = INTERRUPTED
        tell("interrupted\n")
    drop_unwritable_output()
    sys.exit(code)


def _take_former_name() -> None:
    """Put the present name of a command in place of its former one, with a note on the error output."""
    new = RENAMED.get(sys.argv[1]) if len(sys.argv) > 1 else None
    if new is not None:
        note = f"note: `hypertuna {sys.argv[1]}` is now `hypertuna {new}`; the next release drops the old name."
        print(note, file=sys.stderr)
        sys.argv[1:2] = new.split()


def _run() -> Any:
    """Run the command; return the exit code."""
    try:
        code = app(standalone_mode=False)
        sys.stdout.flush()
        return code
    except InputError as error:
        sentence = str(error)
    except UsageError as error:
        sentence = error.format_message()  # empty if the help was printed
        sentence = sentence and f"{sentence} See `{_command(error.ctx)} --help`."
    except BaseException as error:
        if was_interrupted() or isinstance(error, KeyboardInterrupt | typer.Abort):
            return INTERRUPTED
        if isinstance(error, BrokenPipeError) or isinstance(error.__context__, BrokenPipeError):
            return 0  # the reader of the output has seen enough; the parser and rich make a SystemExit of it
        sentence = _sentence(error)
        if not sentence:
            raise
    if sentence:
        tell(escaped(f"error: {sentence}\n", "\n"))
    return 2


def _sentence(error: BaseException) -> str:
    """Describe what stopped the program; empty for a fault of its own."""
    if isinstance(error, OSError):
        file = error.filename or ("standard output" if error.errno == errno.ENOSPC else "")
        return f"{file}: {error.strerror or error}.".removeprefix(": ")
    if isinstance(error, MemoryError):
        return "there is not enough memory: ask for fewer gaits, steps or seconds."
    isa = isinstance(error, ValueError) and str(error).startswith("HYPERTUNA_ISA")
    return f"{error}." if isa else ""


def _command(context: Any) -> str:
    """Return the command that a parser's context belongs to, as typed."""
    names: list[str] = []
    while context is not None and context.parent is not None:
        names, context = [context.info_name, *names], context.parent
    return " ".join(["hypertuna", *names])
