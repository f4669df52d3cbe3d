"""CSV files of runs: recognize the kind of runs by the columns, and read them."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.tables import Table, read_table
from hypertuna.trials.decay import Decay, Glide, YawDecay, read_decays
from hypertuna.trials.numbers import HeldThrust, NumberRun, PowerRun, Tow, TurnRun, read_numbers
from hypertuna.trials.steady import SteadyRun, read_steady

Run = SteadyRun | NumberRun | Decay  # a trial read from a CSV file
Reader = Callable[[str | Path | Table, Robot], Sequence[Run]]

# By key of a manifest: prefixes of columns that identify the kind, and its reader. A file without the columns of any
# kind is read as steady runs, and so is one that has a gait's frequency with a time or a speed.
TABLES: dict[str, tuple[tuple[str, ...], Reader]] = {
    "steady": ((), read_steady),
    "tows": (("drag_",), partial(read_numbers, made=Tow)),
    "thrusts": (("thrust_",), partial(read_numbers, made=HeldThrust)),
    "powers": (("power_",), partial(read_numbers, made=PowerRun)),
    "turns": (("turn_rate_",), partial(read_numbers, made=TurnRun)),
    "glides": (("time_s", "speed_"), partial(read_decays, made=Glide)),
    "yaw_decays": (("time_s", "yaw_rate_"), partial(read_decays, made=YawDecay)),
}


def read_runs(path: str | Path, robot: Robot) -> tuple[Run, ...]:
    """Read a CSV file of runs, whose kind follows from its columns."""
    table = read_table(path)
    head = set(table.head)
    steady = "frequency_hz" in head and ("time_s" in head or any(name.startswith("speed_") for name in head))
    logged = next((name for name in table.head if name.startswith(("drag_", "thrust_", "power_"))), None)
    if logged is not None and not steady and head & {"time_s", "time", "t"}:
        rule, fix = "is a log over time", f"write a row for each run, with the mean of {logged} over whole beats"
        raise InputError(rule, file=table.file, key=f"line {table.line}, {logged}", fix=fix)
    for prefixes, read in TABLES.values():
        if prefixes and not steady and all(any(name.startswith(prefix) for name in head) for prefix in prefixes):
            return tuple(read(table, robot))
    return read_steady(table, robot)
