"""The command `hypertuna pareto`."""

from typing import Annotated, Any

from hypertuna.cli import options as opt
from hypertuna.cli.console import progress_bar
from hypertuna.cli.emit import emit
from hypertuna.cli.gait import column_rows
from hypertuna.cli.search import BodyLimits, Design, RobustOptions, SwimLimits, bounds_of, design_of
from hypertuna.cli.shards import connected
from hypertuna.description.provenance import provenance
from hypertuna.io.files import variable_columns
from hypertuna.io.quantity import key_of
from hypertuna.optimization.objective import OBJECTIVES
from hypertuna.optimization.pareto import SLOW, Front, pareto
from hypertuna.swimming.beat import DEFAULT_STEPS, QUANTITIES
from hypertuna.swimming.gait import KINDS, NEEDED, gait_record

# Objective -> its key in JSON and CSV, which ends with the unit.
NAMES = {name: key_of(name, QUANTITIES[name].unit) for name in OBJECTIVES}


@opt.grouped
def pareto_command(
    robot: opt.ModelOptions,
    limits: SwimLimits,
    body: BodyLimits,
    robust: RobustOptions,
    objectives: Annotated[
        str, opt.text("--objectives", f"Two or three of {', '.join(OBJECTIVES)}.")
    ] = "speed,cost_of_transport",
    population: Annotated[int, opt.whole_number("--population", "Number of gaits per generation of NSGA-II.")] = 40,
    generations: Annotated[int, opt.whole_number("--generations", "Generations of NSGA-II.")] = 60,
    bounds: opt.Bounds = None,
    design: Design = None,
    min_speed: Annotated[
        float | None,
        opt.number("--min-speed", "m/s", f"Minimum speed in m/s. (default: {SLOW:g} body lengths/s)"),
    ] = None,
    seed: opt.Seed = 1,
    no_polish: Annotated[bool, opt.flag("--no-polish", "Do not polish the front of NSGA-II.")] = False,
    steps: opt.Steps = DEFAULT_STEPS,
    checkpoint: opt.Checkpoint = None,
    cluster: opt.Cluster = None,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Find the Pareto front of gaits: NSGA-II, polished by exact gradients.

    With --design, numbers of the robot's file are sought beside them.

    The exit code is 0 for a front, 1 if no gait satisfies all limits, 2 for bad input.
    """
    subject = robot.load()
    with progress_bar("evolving", parts="round", checkpoint=checkpoint) as progress, connected(cluster) as executor:
        front = pareto(
            subject,
            [name.strip() for name in objectives.split(",")],
            population=population,
            generations=generations,
            bounds=bounds_of(bounds),
            design=design_of(design),
            limits=limits.make(subject, **body.arguments(subject)),
            min_speed=min_speed,
            polish=not no_polish,
            seed=seed,
            steps=steps,
            executor=executor,
            checkpoint=checkpoint,
            progress=progress,
            **vars(robust),
        )
    empty = not len(front.x)
    emit(
        front,
        record=_record,
        columns=_gait_names(front) | _names(front),
        digits=None,
        dataset=lambda front: front.points,
        **vars(opt.Files(as_json=files.as_json) if empty else files),
        failed=empty,
    )


def _gait_names(front: Front) -> dict[str, str]:
    """Return the CSV column of each variable of the front's gaits and designs; biases only if there are any."""
    kinds = KINDS if any(any(gait.bias) for gait in front.gaits) else NEEDED
    names = ["frequency", *(f"{kind}_{group.name}" for kind in kinds for group in front.robot.joints)]
    return {name: name for name in (*names, *(variable.label for variable in front.space.variables))}


def _names(front: Front) -> dict[str, str]:
    """Return the name in CSV and JSON of each result of the front."""
    robust = {
        f"{name}_{front.robust}": key_of(f"{name}_{front.robust}", QUANTITIES[name].unit)
        for name in front.objectives
        if front.robust
    }
    return NAMES | robust | {"stationarity": "stationarity"}


def _record(front: Front) -> dict[str, Any]:
    """Return the JSON record of a front."""
    objectives = [
        {"name": name, "better": "large" if OBJECTIVES[name] else "small", "unit": unit}
        for name, unit in zip(front.objectives, front.units, strict=True)
    ]
    reference = {NAMES[name]: value for name, value in zip(front.objectives, front.reference, strict=True)}
    rows = column_rows(variable_columns(front.points, _names(front))) if len(front.x) else []
    volume = {"before_polishing": front.hypervolume_evolved, "front": front.hypervolume, "reference": reference}
    return provenance(front.robot) | {
        "objectives": objectives,
        "robust": front.robust,
        "hypervolume": volume,
        "evaluations": front.evaluations,
        "seconds": front.seconds,
        "stop": front.stop,
        "front": [
            {"gait": gait_record(gait), "design": {name: float(column[k]) for name, column in front.designs.items()}}
            | row
            for k, (gait, row) in enumerate(zip(front.gaits, rows, strict=True))
        ],
    }
