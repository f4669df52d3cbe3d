"""Reasons why a robot has no twin, and the command that writes a robot of its size that has one."""

import math
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from hypertuna import _core
from hypertuna.description.new import SEGMENTS, SHORTEST, new_robot
from hypertuna.description.robot import Robot
from hypertuna.description.schema.actuator import Hinge
from hypertuna.description.schema.body import AXLE, DRIVES
from hypertuna.description.schema.control import Controller
from hypertuna.errors import InputError


def why_no_twin(robot: Robot) -> str:
    """Return the reason why a robot has no twin, as the end of a sentence; empty if it has one."""
    return _unfit(robot) or ("" if robot.controller is not None else "its file has no controller")


def _unfit(robot: Robot) -> str:
    """Return the reason why a twin cannot have a robot's joints, as the end of a sentence; empty if it can."""
    if len(robot.joints) > _core.MAX_JOINTS:
        return f"it has {len(robot.joints)} joint groups, and the twin takes at most {_core.MAX_JOINTS}"
    if len(robot.joints) + len(robot.hinges) > _core.MAX_COORDINATES:
        both = f"{len(robot.joints)} joint groups and {len(robot.hinges)} hinges"
        return f"it has {both}, and the twin takes at most {_core.MAX_COORDINATES} of both"
    if hinges := _hinges_on_oil(robot):
        links = f"link{'s' * (len(hinges) > 1)} {', '.join(str(hinge.link) for hinge in hinges)}"
        return f"oil bends its {links} alone, and a hinge there has no mass to turn against"
    if hinge := _driven_hinge(robot):
        return f"a moment drives its hinge at link {hinge.link}, and the twin has no motor there"
    return ""


def twin_note(robot: Robot) -> str:
    """Return a sentence on a robot whose joints a twin cannot have; empty for all other robots."""
    reason = _unfit(robot)
    return f"{robot.name} swims, sweeps, turns and optimizes, but has no twin: {reason}." if reason else ""


def require_groups(robot: Robot, *, sea: bool = False, board: bool = False) -> None:
    """Refuse a robot with more joint groups than the twin or the firmware allows; the fix names `new_command`."""
    count, most = len(robot.joints), _core.BOARD_JOINTS if board else _core.MAX_JOINTS
    if count > most:
        rule, file = f"must be at most {most} groups for the {'firmware' if board else 'twin'}", robot.file or None
        fix = f"let joints share a group, as in the file that `{new_command(robot, sea=sea, board=board)}` writes"
        raise InputError(rule, file=file, key="joints", value=f"{count}", fix=fix)
    if count + len(robot.hinges) > _core.MAX_COORDINATES:
        rule = f"must be at most {_core.MAX_COORDINATES - count} in the twin, beside {count} joint groups"
        fix = "leave the others out; `swim` and `sweep` bend them all"
        raise InputError(rule, file=robot.file or None, key="hinges", value=f"{len(robot.hinges)}", fix=fix)
    require_passive_hinges(robot)


def require_passive_hinges(robot: Robot) -> None:
    """Refuse a hinge that a moment drives, for which twin and firmware have no motor."""
    if hinge := _driven_hinge(robot):
        rule, fix = "must be 0 in twin and firmware, which have no motor there", "leave it out; `swim` has it"
        key = f"{robot.hinge_keys[robot.hinges.index(hinge)]}.moment_n_m"
        raise InputError(rule, file=robot.file or None, key=key, value=f"{hinge.moment:g}", fix=fix)


def require_mass_at_hinge(robot: Robot) -> None:
    """Refuse hinges that only a joint without inertia carries: the two would swing without end."""
    if hinges := _hinges_on_oil(robot):
        rule = "must leave the joint group that oil bends there a link without a hinge, in the twin"
        fix = "put the hinge on another link"
        key = f"{robot.hinge_keys[robot.hinges.index(hinges[0])]}.link"
        raise InputError(rule, file=robot.file or None, key=key, value=f"{hinges[0].link}", fix=fix)


def require_controller(robot: Robot) -> Controller:
    """Return the controller of a robot that has a twin, or refuse the robot."""
    require_groups(robot)
    if robot.controller is None:
        drives = "" if all(group.driven for group in robot.joints) else " and the drives of [[joints]]"
        fix = f"copy it{drives} from a robot of this size; `{new_command(robot)}` writes one"
        raise InputError("is missing", file=robot.file or None, key="controller", fix=fix)
    return robot.controller


def _hinges_on_oil(robot: Robot) -> list[Hinge]:
    """Return the hinges on all links of a joint group that oil bends, which has no inertia; empty without one."""
    hinges = {hinge.link: hinge for hinge in robot.hinges}
    on_oil = (group.links for group in robot.joints if group.driven and group.drive.oil)
    return next(([hinges[link] for link in links] for links in on_oil if {*links} <= {*hinges}), [])


def _driven_hinge(robot: Robot) -> Hinge | None:
    """Return a hinge that a moment drives; None without one."""
    return next((hinge for hinge in robot.hinges if hinge.moment), None)


def new_command(robot: Robot, *, sea: bool = False, board: bool = False) -> str:
    """Return the command that writes a robot of about the same size with a twin.

    With `sea` it writes one for missions, and with `board` one that also has firmware.
    """
    kinds = [group.drive for group in robot.joints if group.driven]
    drive = next((one for one in reversed(DRIVES.values()) if one in kinds), AXLE)
    most = drive.on_board if board else _core.MAX_JOINTS
    tail, lengths = _tail(robot)
    count = min(most, len(robot.joints))
    names, others = [group.name for group in robot.joints], [f"J{j}" for j in range(1, count + 1)]
    size: dict[str, Any] = {"lengths": lengths, "mass": robot.body.mass}
    with_names = [{**size, "joints": names}] if len(robot.joints) <= most else []
    candidates = [*with_names, {**size, "joints": others}, {"lengths": lengths, "joints": others}, {}]
    options = next(one for one in candidates if _accepted(one, tail))
    command = ["hypertuna", "robot", "new", f"{robot.name}-{'sea' if sea else 'twin'}.toml"]
    for name, value in options.items():
        values = value if isinstance(value, Sequence) else [value]
        command += [f"--{name}", ",".join(one if isinstance(one, str) else f"{one:g}" for one in values)]
    command += ["--tail", tail] * (tail != "driven")
    return shlex.join([*command, "--actuation", drive.actuation, *["--sea"] * sea])


def _tail(robot: Robot) -> tuple[str, list[float]]:
    """Return the tail that is most like a robot's for `robot new`, and the lengths of the links with it [m]."""
    lengths = list(robot.links.length)
    last = len(lengths) - 1
    undriven = last - max((link for group in robot.joints for link in group.links), default=last)
    fin = math.fsum(lengths[-SEGMENTS:])
    if undriven >= SEGMENTS and fin >= SEGMENTS * SHORTEST * math.fsum(lengths):
        return "flexible", [*lengths[:-SEGMENTS], fin]
    return "passive" if undriven else "driven", lengths


def _accepted(options: Mapping[str, Any], tail: str) -> bool:
    """Return whether `robot new` accepts sizes and joints with a tail."""
    try:
        new_robot("fish", **options, last_alone=tail != "driven")
    except InputError:
        return False
    return True
