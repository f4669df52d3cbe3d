"""A first robot file: the fish of description/new.py, with what drives its joints."""

from collections.abc import Sequence

from hypertuna.description.commented import commented
from hypertuna.description.new import new_robot
from hypertuna.description.robot import Robot, parse

HEADER = """\
# {name}, written by `{command}`.
# Every value is an estimate from length and mass; [sources] has its rule. Replace values as you measure them, write
# "measured" and how into [sources], and run `hypertuna robot check`.
"""


def first_robot(
    name: str,
    *,
    links: int = 3,
    length: float = 0.3,
    mass: float | None = None,
    joints: Sequence[str] = (),
    actuation: str = "none",
) -> str:
    """Return the text of a robot file that swims at once; `length` [m], `mass` [kg], names of the `joints`."""
    document = new_robot(name, links=links, length=length, mass=mass, joints=joints)
    parse(document, file=f"{name}.toml")
    return HEADER.format(name=name, command="hypertuna robot new") + commented(document, Robot)
