"""The program `hypertuna`: its commands, imported when called, and its exit codes."""

import errno
import gc
import sys
from typing import Annotated, Any

import typer

from hypertuna.cli.command import TableGroup, UsageError
from hypertuna.cli.environment import check_environment
from hypertuna.cli.streams import (
    INTERRUPTED,
    drop_unwritable_output,
    end_on_signals,
    open_streams,
    state,
    was_interrupted,
    write_error,
)
from hypertuna.errors import InputError, escaped

# Panel of --help -> command -> (function or group in hypertuna.cli, or the table of its subcommands; line in --help).
# Panels and commands stand in the order in which a user needs them.
PANELS: dict[str, dict[str, tuple[Any, str]]] = {
    "Describe a robot": {
        "robot": ("robot:robot_app", "Robot descriptions: begin one, check a file, show a robot, print the format."),
    },
    "Swim": {
        "swim": ("swim:swim_command", "Swim one gait: its settled beat, or from rest."),
        "studio": (
            "studio:studio_command",
            "Turn the knobs of a swimming robot in the browser: a page of this machine alone, until Ctrl-C.",
        ),
        "sweep": ("sweep:sweep_command", "Swim every combination of frequencies, amplitudes, phases and biases."),
        "shards": (
            {
                "merge": (
                    "shards:merge_command",
                    "Check that all shards are there, whole, and of the same work, and merge them into one file.",
                )
            },
            "Results in shards, of --shard or --cluster: check and merge; needs the extra cluster.",
        ),
        "turn": ("turn:turn_command", "Turn by a one-sided beat: radius against phase, bias and frequency."),
        "replay": (
            "replay:replay_command",
            "Swim measured joint angles, and compare the head's track with tracked poses.",
        ),
    },
    "Measure and fit": {
        "trials": ("trials:trials_app", "Tank trials: check them, import published ones, track films."),
        "identify": (
            "identify:identify_command",
            "Fit coefficients of a robot to measured runs, with their uncertainty.",
        ),
        "design": (
            {
                "ask": (
                    "design:ask_command",
                    "Print the next runs for the tank, what each narrows.",
                ),
                "tell": ("design:tell_command", "Enter what the runs measured."),
            },
            "Experimental design: which run the tank makes next.",
        ),
        "scoreboard": (
            "scoreboard:scoreboard_command",
            "Predict published swimmers as `hypertuna robot new` describes them, and compare with what they did.",
        ),
    },
    "Optimize": {
        "optimize": (
            "optimize:optimize_app",
            "Find the best gait for an objective: the highest speed, or a target speed at low cost.",
        ),
        "pareto": ("pareto:pareto_command", "Find the Pareto front of gaits: NSGA-II, polished by exact gradients."),
    },
    "Size pump and joints": {
        "joint": (
            {
                "bend": ("bend:bend_command", "Bend a soft joint in air: angle over pressure, up and down."),
                "fit": ("joint:fit_command", "Identify the unknowns of an actuator from bench pressures and bends."),
                "family": (
                    "joint_family:family_command",
                    "Sample the actuator designs that agree with measured bends, forces, shortenings and oil volumes.",
                ),
                "silicone": ("joint:silicone_command", "Fit the elastic constants of a silicone to a tensile test."),
                "spring": (
                    "joint_spring:spring_command",
                    "Fit the stiffness of a hinge to weights and angles, with its 95 % interval.",
                ),
            },
            "A joint: its bend in air, its actuator, silicone or spring from tests on a bench.",
        ),
        "fe": ("fe:fe_app", "The soft joints by finite elements; needs the extra fe."),
        "pump": (
            "pump:pump_command",
            "Size the pump: torque, speed and stroke of its servos, drop and bandwidth of the lines.",
        ),
        "range": ("range:range_command", "Compute range and endurance on one battery charge."),
    },
    "Simulate the whole robot": {
        "twin": (
            "twin:twin_command",
            "Simulate the whole robot: controller, servos, pumps, oil, muscles, tail, water, sensors.",
        ),
        "posture-test": ("posture:posture_command", "Test the posture control from rest to a set peak bend."),
        "dive": ("dive:dive_command", "Dive with the pectoral fins down for half of the time, then rise with them up."),
        "mission": ("mission:mission_command", "Fly a mission on the twin at sea, under its pilot."),
        "mission new": ("mission_files:new_command", "Write a mission that a robot can swim."),
        "mission import": (
            "mission_files:import_command",
            "Write the mission of a .plan, .waypoints, GPX or KML file.",
        ),
        "log": ("log:log_app", "Logs of missions and black boxes: summary, plot, table, track; needs the extra log."),
    },
    "Take elsewhere": {
        "export": (
            {
                "mjcf": ("export:mjcf_command", "Write a robot as a MuJoCo model."),
                "sdf": ("export:sdf_command", "Write a robot as an SDF model for Gazebo."),
                "fmu": ("export:fmu_command", "Write a robot as an FMU for co-simulation."),
            },
            "Robots for other simulators: MuJoCo, Gazebo, and all that import FMUs.",
        ),
    },
    "Build and drive": {
        "rl": (
            {"export": ("rl:export_command", "Write a trained policy as a header of the firmware.")},
            "Reinforcement learning: a trained policy for the board.",
        ),
        "firmware": (
            "firmware:firmware_app",
            "Firmware: parameters and wiring from a robot's description, list of faults.",
        ),
        "hil": (
            "hil:hil_command",
            "Run the firmware in the loop: the twin at sea and the firmware on a board, in lock-step.",
        ),
        "radio": (
            {
                "params": ("radio:params_command", "Read the parameters of a robot, or set some."),
                "log": ("radio:log_command", "Record all that a robot and its tank's camera send."),
                "mission": ("radio:mission_command", "Send a mission to a robot."),
                "calibrate": (
                    "calibrate:calibrate_command",
                    "Calibrate sensors and servos' zeros, from a file or live.",
                ),
                "check": ("radio:check_command", "Check whether a disarmed robot may be armed."),
                "sign": ("radio:sign_command", "Give a disarmed robot the key that signs messages."),
                "drive": (
                    "drive:drive_command",
                    "Drive a robot by keyboard or gamepad, with a live view of its messages.",
                ),
            },
            "A robot over the radio; needs the extra radio, and log for logs.",
        ),
    },
    "About": {
        "paper": ("paper:paper_command", "Compute the paper's numbers beside the published ones."),
        "version": ("version:version_command", "Print the version and the instruction set in use."),
    },
}
COMMANDS = {name: row for table in PANELS.values() for name, row in table.items()}  # every command's row of `PANELS`


class Program(TableGroup):
    """The program: all commands."""

    def __init__(self, **options: Any) -> None:
        super().__init__(panels=PANELS, **options)

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options, all flags, with the default False: for None, typer would import pydantic."""
        flags: list[Any] = super().get_params(ctx)
        for flag in flags:
            flag.default = False
        return flags


app = typer.Typer(
    cls=Program,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
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
    """Open digital twin for robotic fish, rigid or soft. Exit code 2 means bad input."""


def main() -> None:
    """Run the program: bad input is one sentence on the error output, and exit code 2."""
    gc.set_threshold(50_000)  # most objects made at the start stay: collect garbage less often
    open_streams()
    end_on_signals()
    if sys.argv[1:2] == ["help"]:
        sys.argv[1:] = [*sys.argv[2:], "--help"]
    code = _run()
    if was_interrupted() or code == INTERRUPTED:
        code = INTERRUPTED
        write_error(f"interrupted: {state['done']}\n" if state["done"] else "interrupted\n")
    drop_unwritable_output()
    sys.exit(code)


def _run() -> Any:
    """Run the command; return the exit code."""
    try:
        check_environment()
        code = app(standalone_mode=False)
        sys.stdout.flush()
        return code
    except InputError as error:
        sentence = str(error)
    except UsageError as error:
        sentence = error.format_message()
    except BaseException as error:
        if was_interrupted() or isinstance(error, KeyboardInterrupt | typer.Abort):
            return INTERRUPTED
        if isinstance(error, BrokenPipeError) or isinstance(error.__context__, BrokenPipeError):
            return 0  # the reader closed the pipe; the parser and rich turn the error into a SystemExit
        sentence = _sentence(error)
        if not sentence:
            raise
    if sentence:
        write_error(escaped(f"error: {sentence}\n", "\n"))
    return 2


def _sentence(error: BaseException) -> str:
    """Return the sentence for an error that the user or the system caused; "" for a fault of the program."""
    if isinstance(error, OSError):
        file = error.filename or ("standard output" if error.errno == errno.ENOSPC else "")
        return f"{file}: {error.strerror or error}.".removeprefix(": ")
    if isinstance(error, MemoryError):
        needed = f" ({error})" if str(error) else ""  # NumPy's message: the size and the array
        return f"there is not enough memory{needed}: give the process more, or this command less to do at once."
    is_isa = isinstance(error, ValueError) and str(error).startswith("HYPERTUNA_ISA")
    return f"{error}." if is_isa else ""
