"""Plans of other programs: their waypoints, notes on differences, and checks of their numbers."""

import math
from dataclasses import dataclass, field

from hypertuna.errors import InputError, shown
from hypertuna.mission.schema import MAX_WAYPOINTS

Place = tuple[float, float]  # latitude and longitude [deg]


@dataclass(frozen=True)
class Stop:
    """A waypoint of a plan: its name in the file, its place, and speed, radius and hold time if stated."""

    name: str  # such as "item 3"
    place: Place
    depth: float  # m
    speed: float | None = None  # m/s
    radius: float | None = None  # m
    hold: float = 0.0  # s


@dataclass
class Plan:
    """Waypoints, home and fence of a plan, and notes on parts that a mission keeps differently or leaves out."""

    stops: list[Stop] = field(default_factory=list)
    home: Place | None = None
    fence: list[Place] = field(default_factory=list)
    goes_home: bool = False  # whether an item sends the robot home
    changes: dict[str, list[str]] = field(default_factory=dict)  # by text of a difference: items that have it

    def note(self, what: str, where: str = "") -> None:
        """Add a note on a difference between plan and mission, with the name of the item that has it."""
        self.changes.setdefault(what, []).extend([where] * bool(where))

    @property
    def notes(self) -> list[str]:
        """Texts of the differences between plan and mission, each with its items."""
        return [f"{what}: {_listed(where)}" if where else what for what, where in self.changes.items()]


def checked_number(value: object, where: str, what: str, low: float = -math.inf, high: float = math.inf) -> float:
    """Check that a value of a plan is a number in a range, and return it."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high or math.isinf(value):
        rule = f"must have {what} from {low:g} to {high:g}" if math.isfinite(low) else f"must have {what}, a number"
        given = "missing" if value is None else shown(value)
        raise InputError(rule, key=where, value=given, fix="correct it, and export the plan again")
    return float(value)


def checked_place(latitude: object, longitude: object, where: str) -> Place:
    """Check latitude and longitude [deg] of a plan, and return them."""
    checked_latitude = checked_number(latitude, where, "a latitude", -89.0, 89.0)
    return checked_latitude, checked_number(longitude, where, "a longitude", -180.0, 180.0)


def depth_of(altitude: object, where: str, depth: float | None) -> float:
    """Return the depth [m] of an altitude [m] above the water, or `depth` if one is given for all waypoints."""
    if depth is not None:
        return depth
    height = checked_number(altitude, where, "an altitude")
    if height > 0:
        rule = "must not be above the water: a depth is a negative altitude"
        fix = "give negative altitudes, or one depth for all waypoints by --depth"
        raise InputError(rule, key=where, value=f"at {height:g} m", fix=fix)
    return 0.0 - height


def check_count(count: int) -> None:
    """Check that a plan has no more waypoints than a mission takes."""
    if count > MAX_WAYPOINTS:
        rule, fix = f"must have at most {MAX_WAYPOINTS} waypoints", "thin them out in a map program"
        raise InputError(rule, value=f"{count} long", fix=fix)


def _listed(where: list[str]) -> str:
    """Return the names of items as a text; of more than nine, only the first eight and a count of the rest."""
    rest = f" and {len(where) - 8} more" if len(where) > 9 else ""
    return ", ".join(where if not rest else where[:8]) + rest
