"""The command `hypertuna optimize`."""

from typing import Annotated, Any

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli.command import App
from hypertuna.cli.console import command_line, progress_bar
from hypertuna.cli.emit import emit, made_by
from hypertuna.cli.experiment import ask_command, tell_command
from hypertuna.cli.search import BodyLimits, Design, RobustOptions, SearchOptions, SwimLimits, design_of, positive
from hypertuna.cli.shards import connected
from hypertuna.description.robot import Robot, parse
from hypertuna.description.writer import robot_text, write_robot
from hypertuna.errors import InputError
from hypertuna.optimization.cards import margin_record
from hypertuna.optimization.optimize import optimize
from hypertuna.optimization.optimum import Optimum
from hypertuna.swimming.gait import Gait, gait_record

optimize_app = App(invoke_without_command=True)
optimize_app.command("ask")(ask_command)
optimize_app.command("tell")(tell_command)


@optimize_app.callback()
@opt.grouped
def optimize_command(
    context: typer.Context,
    robot: opt.ModelOptions,
    search: SearchOptions,
    robust: RobustOptions,
    limits: SwimLimits,
    body: BodyLimits,
    design: Design = None,
    min_speed: Annotated[float | None, positive("--min-speed", "m/s", "Minimum speed in m/s.")] = None,
    checkpoint: opt.Checkpoint = None,
    cluster: opt.Cluster = None,
    plot: opt.Plot = None,
    output: opt.RobotOutput = None,
    as_json: opt.AsJson = False,
) -> None:
    """Find the best gait for an objective: the highest speed, or a target speed at low cost of transport (Eq. 42).

    With --design, numbers of the robot's file are sought beside it.

    The exit code is 0 for a gait, 1 if none satisfies all limits, 2 for bad input.
    """
    if context.invoked_subcommand is not None:
        _check_alone(context)
        return
    subject = robot.load(output)
    all_limits = limits.make(subject, speed=min_speed, **body.arguments(subject))
    if output is not None:  # tried before the search, whose result must not be lost
        groups = [0.0] * len(subject.joints)
        robot_text(_with_best(subject, Gait.from_degrees(frequency=1.0, amplitude=groups, phase=groups)))
    how = search.arguments() | vars(robust) | {"checkpoint": checkpoint, "design": design_of(design)}
    with progress_bar("optimizing", parts="gait", checkpoint=checkpoint) as progress, connected(cluster) as executor:
        result = optimize(subject, limits=all_limits, executor=executor, progress=progress, **how)
    if output is not None and result.gait is not None:
        write_robot(_with_best(result.robot, result.gait), output)
    emit(
        result,
        record=_record,
        plot=plot,
        written=(output,),
        as_json=as_json,
        failed=result.gait is None,
    )


def _with_best(robot: Robot, gait: Gait) -> Robot:
    """Return a robot with `gait` added under the name "best"."""
    document = robot.document()
    document["gaits"] = document.get("gaits", {}) | {"best": gait_record(gait)}
    document["sources"] = document.get("sources", {}) | {"gaits.best": command_line()}
    return parse(document, file=robot.file)


def _check_alone(context: typer.Context) -> None:
    """Check that options of the subcommands ask and tell come after their names."""
    for key in context.params:
        if str(context.get_parameter_source(key)).endswith("COMMANDLINE"):
            rule = f"must come after {context.invoked_subcommand}"
            raise InputError(rule, key=f"--{key.replace('_', '-')}", fix="see `--help` of that command")


def _record(result: Optimum) -> dict[str, Any]:
    """Return the JSON record of an optimum."""
    target = result.objective
    facts = ("evaluations", "seconds", "stop", "remark", "method", "seed", "value", "robust", "history")
    return {
        "gait": None if result.gait is None else gait_record(result.gait),
        "design": dict(result.design),
        "speed_m_s": result.speed,
        "cost_of_transport_j_per_kg_m": result.cost_of_transport,
        **{name: getattr(result, name) for name in facts},
        "objective": {
            "name": target.name,
            "terms": dict(target.terms),
            "expected_speed_m_s": target.expected,
            "weight_threshold_m_s_per_j_per_kg_m": result.weight_threshold,
        },
        "constraints": [margin_record(margin) for margin in result.margins],
        "on_bounds": dict(result.bounds),
        "near_best": {name: np.round(ends, 10) for name, ends in result.near_best.items()},
    } | made_by(result.robot)
