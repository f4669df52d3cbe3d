"""Provenance of a result: version, instruction set, robot, model."""

from collections.abc import Mapping
from typing import Any

from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.io.files import version


def provenance(robot: Robot, *, water: bool = True) -> dict[str, str]:
    """Return the attributes of every dataset and file: version, instruction set, robot and, with `water`, its model."""
    facts = {
        "hypertuna_version": version(),
        "isa": _core.isa(),
        "robot": robot.name,
        "robot_file": robot.file,
        "robot_hash": robot.hash,
    }
    model = robot.model
    return facts | ({"water": model.water, "joints": model.joints, "areas": model.areas} if water else {})


def journal_header(kind: str, robot: Robot, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the header of a journal, which resumes only work of the same header.

    `kind` is the work ("optimize", "identify"); `options` has everything that its course depends on, seed included.
    """
    robot_facts = {"robot": robot.name, "robot_hash": robot.hash}
    return {"kind": kind, "version": version(), "isa": _core.isa()} | robot_facts | {"options": dict(options)}
