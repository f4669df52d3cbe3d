"""What made a result: version, instruction set, robot, model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.io.files import version

if TYPE_CHECKING:
    pass

__all__ = ["journal_header", "provenance"]


def provenance(robot: Robot, *, water: bool = True) -> dict[str, str]:
    """Say what made a result: attributes for every dataset and file.

    Parameters
    ----------
    robot : Robot
    water : bool
        Whether the robot's model of body and water had a part in it.

    Returns
    -------
    dict of str
        Version, instruction set, robot and its hash, choice of model.
    """
    made = {
        "hypertuna_version": version(),
        "isa": _core.isa(),
        "robot": robot.name,
        "robot_file": robot.file,
        "robot_hash": robot.hash,
    }
    model = robot.model
    return made | ({"water": model.water, "joints": model.joints, "areas": model.areas} if water else {})


def journal_header(kind: str, robot: Robot, options: Mapping[str, Any]) -> dict[str, Any]:
    """Say what a journal is of; one that says something else is not taken up again.

    Parameters
    ----------
    kind : str
        The work: "optimize", "pareto", "identify" ...
    robot : Robot
    options : mapping
        Everything that the course of the work depends on, seed included; numbers, texts, lists and mappings of them.

    Returns
    -------
    dict
    """
    robot_facts = {"robot": robot.name, "robot_hash": robot.hash}
    return {"kind": kind, "version": version(), "isa": _core.isa()} | robot_facts | {"options": dict(options)}
