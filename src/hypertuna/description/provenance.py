"""Provenance of a result: version, instruction set, robot and model; whether a value is an estimate."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hypertuna import _core
from hypertuna.description.robot import Robot, robots
from hypertuna.description.validation import entry_of
from hypertuna.io.files import shipped, version


def provenance(robot: Robot, *, water: bool = True) -> dict[str, str]:
    """Return attributes for every dataset and file: version, instruction set, robot and, with `water`, the model."""
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
    """Return the header of a journal; only work with the same header resumes from it.

    `kind` is the kind of work ("optimize", "identify"); `options` has all inputs that affect the results, such as the
    seed.
    """
    robot_facts = {"robot": robot.name, "robot_hash": robot.hash}
    return {"kind": kind, "version": version(), "isa": _core.isa()} | robot_facts | {"options": dict(options)}


def is_estimate(robot: Robot, key: str) -> bool:
    """Return whether the value of a key is an estimate: its source says so, or it has no source."""
    return (robot.source(key) or "estimate").startswith("estimate")


def factor_of(robot: Robot, key: str) -> float:
    """Return the factor of an estimate in ``[uncertainty]``; 1 without one."""
    return (entry_of(robot.uncertainty or {}, key) or 1.0) if is_estimate(robot, key) else 1.0


def robot_path(file: str) -> Path:
    """Return the path of ``Robot.file``, which may name a robot that comes with hypertuna: robots/NAME.toml."""
    path = Path(file)
    by_name = path.parent == Path("robots") and path.stem in robots()
    return shipped("robots") / path.name if by_name else path
