"""The command `hypertuna swim`."""

import math
from collections.abc import Sequence
from functools import partial
from typing import Annotated, Any

from hypertuna.cli import options as opt
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.gait import GaitOptions
from hypertuna.display import Part, card_of
from hypertuna.io.quantity import values_of
from hypertuna.swimming.beat import DEFAULT_STEPS
from hypertuna.swimming.gait import gait_degrees
from hypertuna.swimming.swim import Swim, swim


@opt.grouped
def swim_command(
    robot: opt.ModelOptions,
    gait: GaitOptions,
    from_rest: Annotated[
        float | None,
        opt.number("--from-rest", "seconds", "Integrate from rest for this many seconds instead of the settled beat."),
    ] = None,
    steps: opt.Steps = DEFAULT_STEPS,
    current: Annotated[
        Sequence[float], opt.numbers("--current", "m/s", "Velocity of the water, X,Y in m/s.", count=2)
    ] = (0.0, 0.0),
    plot: Annotated[str | None, opt.file("--plot", "the plot", *opt.FIGURES, ".gif")] = None,
    output: Annotated[str | None, opt.file("--output", "the motion", ".nc")] = None,
    as_json: opt.AsJson = False,
) -> None:
    """Swim one gait: its settled beat, or from rest.

    The exit code is 0 for a settled gait, 1 for one that is not (its results are still printed), 2 for bad input.
    """
    subject = robot.load()
    result = swim(subject, gait.make(subject), from_rest=from_rest, steps=steps, current=(current[0], current[1]))
    emit(
        result,
        record=_record,
        lines=_lines,
        dataset=lambda result: result.trajectory,
        facts=_facts,
        output=output,
        plot=plot,
        figure=partial(_animate, plot) if plot is not None and plot.lower().endswith(".gif") else None,
        as_json=as_json,
        failed=not result.settled,
    )


def _record(result: Swim) -> dict[str, Any]:
    """Return the JSON record of a swim."""
    return (
        values_of(result.summary())
        | {"band": _band(result)}
        | {"status": result.status, "status_text": result.status_text, "settled": result.settled}
        | {"beats": result.beats, "spectral_radius": result.spectral_radius, "change_per_beat": result.change_per_beat}
        | {"distance_to_settled": result.distance_to_settled, "steps": result.steps}
        | {"reached_from_rest": result.reached_from_rest, "settled_from_rest": _elsewhere(result)}
        | gait_degrees(result.gait)
        | {"from_rest_s": result.from_rest, "current_m_s": result.current, "warnings": _outside(result)}
        | made_by(result.robot)
    )


def _band(result: Swim) -> dict[str, float] | None:
    """Return the JSON record of the band of speeds [m/s] over the robot's uncertain values; None without any."""
    if (band := result.band) is None:
        return None
    return {"low_m_s": float(band.low[0]), "high_m_s": float(band.high[0]), "settled": float(band.settled[0])}


def _outside(result: Swim) -> list[str]:
    """Return sentences on where the swim lies outside the runs that the coefficients were fitted to."""
    if result.robot.fit is None:
        return []
    from hypertuna.trials.reach import outside  # imported here, because the import takes longer than a swim

    speed = result.speed if result.settled and math.isfinite(result.speed) else None
    return outside(result.robot, frequency=result.gait.frequency, amplitude=result.gait.amplitude, speed=speed)


def _elsewhere(result: Swim) -> dict[str, Any] | None:
    """Return the summary of the settled beat reached from rest, if it is another one, else None."""
    other = result.settled_from_rest
    return None if other is None else values_of(other.summary())


def _facts(result: Swim) -> dict[str, Any]:
    """Return the JSON record of a swim as attributes of a file, its nested tables flattened."""
    record = _record(result)
    tables = {name: record.pop(name) or {} for name in ("band", "settled_from_rest")}
    return record | {f"{name}_{key}": value for name, table in tables.items() for key, value in table.items()}


def _lines(result: Swim) -> list[Part]:
    """Return the lines that the terminal prints for a swim, with warnings before its status."""
    *lines, status = card_of(result).lines()
    return [*lines, *((warning, "yellow") for warning in _outside(result)), status]


def _animate(path: str, result: Swim) -> None:
    """Write the swimming body as an animated GIF."""
    from hypertuna.swimming.plots import animate_swim  # slow to import

    animate_swim(result, path)
