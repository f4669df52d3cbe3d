"""The tables of a mission file, and rules between them; keys of the file carry units, attributes are in SI."""

import itertools
import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from hypertuna.control.mission import TIDE, cross, sides
from hypertuna.control.sensors import STANDARD_AIR
from hypertuna.description.schema.base import (
    Check,
    Degrees,
    Flag,
    NotNegative,
    Part,
    Positive,
    PositiveFraction,
    Real,
    Text,
    entry,
    number,
)
from hypertuna.ranges import Range
from hypertuna.simulation.sea import AIR, DIP

MAX_SPEED = 5.0  # m/s of robot or water
MAX_DEPTH = 1000.0  # m
MAX_WAYPOINTS, MAX_CORNERS, MAX_GAPS = 1000, 64, 1000  # waypoints; corners of the fence; losses of the satellites
MAX_DURATION = 7 * 86400.0  # s

Latitude = Annotated[float, number(Range(min=-89, max=89)), AfterValidator(math.radians)]
Longitude = Annotated[float, number(Range(min=-180, max=180)), AfterValidator(math.radians)]
Speed = Annotated[float, number(Range(above=0, max=MAX_SPEED))]
Current = Annotated[float, number(Range(min=0, max=MAX_SPEED))]
Depth = Annotated[float, number(Range(min=0, max=MAX_DEPTH))]
DepthBelow = Annotated[float, number(Range(above=0, max=MAX_DEPTH))]
Seconds = Annotated[float, number(Range(above=0, max=MAX_DURATION))]
Moment = Annotated[float, number(Range(min=0, max=MAX_DURATION))]
Reserve = Annotated[float, number(Range(min=0, below=1))]
AirPressure = Annotated[float, number(AIR)]
Pair = tuple[Real, Real]


class Origin(Part):
    """The place on the Earth where x = y = 0. GPX and places in degrees need it."""

    latitude: Latitude = entry("latitude of the origin, north positive", "deg")
    longitude: Longitude = entry("longitude of the origin, east positive", "deg")
    declination: Degrees | None = entry(
        "declination of the magnetic field: direction of magnetic north, clockwise from north (default: 0 on the twin; "
        "by the World Magnetic Model of the day when it is sent to a robot)",
        "deg",
        default=None,
    )


class Place(Part):
    """A place: x and y, or latitude and longitude."""

    x: Real | None = entry("east of the origin", "m", default=None)
    y: Real | None = entry("north of the origin", "m", default=None)
    latitude: Latitude | None = entry("latitude, instead of x_m and y_m", "deg", default=None)
    longitude: Longitude | None = entry("longitude, instead of x_m and y_m", "deg", default=None)


class Start(Place):
    """Where the mission begins."""

    heading: Degrees = entry("direction that the head faces, clockwise from north", "deg")
    depth: Depth = entry("depth of the nose at the start (default: 0)", "m", default=0.0)
    battery: PositiveFraction = entry("part of the charge at the start (default: 1)", default=1.0)


class WaypointTable(Place):
    """A place to go to."""

    depth: Depth = entry("depth on the way there (default: 0)", "m", default=0.0)
    speed: Speed = entry("speed through the water on the way there", "m/s")
    radius: Positive = entry("distance within which the waypoint counts as reached (default: 3)", "m", default=3.0)
    hold: Moment = entry("time to stay at the waypoint (default: 0)", "s", default=0.0)


class Home(Place):
    """The place to which the robot returns (default: the start)."""

    radius: Positive = entry("distance within which the robot is at home (default: 3)", "m", default=3.0)
    speed: Speed = entry("speed through the water on the way home (default: 0.3)", "m/s", default=0.3)


class Water(Part):
    """The water: its ground, and a current that is uniform or changes evenly from surface to ground."""

    bottom: DepthBelow = entry("depth of the ground (default: 20)", "m", default=20.0)
    current: Current = entry("speed of the current at the surface (default: 0)", "m/s", default=0.0)
    toward: Degrees = entry(
        "direction that the current flows toward, clockwise from north (default: 0)",
        "deg",
        key="current_deg",
        default=0.0,
    )
    current_bottom: Current | None = entry(
        "speed of the current at the ground (default: as at the surface)", "m/s", default=None
    )
    toward_bottom: Degrees | None = entry(
        "direction of the current at the ground (default: as at the surface)",
        "deg",
        key="current_bottom_deg",
        default=None,
    )


class Weather(Part):
    """The weather: the air's pressure, the magnetic field, and currents that change with time."""

    air_pressure: AirPressure = entry(
        "pressure of the air at the surface, which a depth sensor measures too (default: 101325)",
        "Pa",
        default=STANDARD_AIR,
    )
    dip: Degrees = entry("angle of the magnetic field below the horizon (default: 60)", "deg", default=DIP)
    declination: Degrees | None = entry(
        "true angle of the magnetic field east of north (default: origin.declination_deg, as the robot believes)",
        "deg",
        default=None,
    )
    tide: Current = entry(
        "largest speed of an added tidal current, a sine from 0 at the start (default: 0)", "m/s", default=0.0
    )
    tide_toward: Degrees = entry(
        "direction that the tide first flows toward (default: 0)", "deg", key="tide_deg", default=0.0
    )
    tide_period: Seconds = entry("period of the tide (default: 44712, which is 12.42 h)", "s", default=TIDE)
    gust: Current = entry("largest speed that gusts add to the current at the surface (default: 0)", "m/s", default=0.0)
    gust_toward: Degrees = entry("direction that gusts push toward (default: 0)", "deg", key="gust_deg", default=0.0)
    gust_depth: DepthBelow = entry("depth at which the effect of gusts ends (default: 1)", "m", default=1.0)
    gust_time: Seconds = entry("time from one strength of the wind to the next (default: 10)", "s", default=10.0)


class Limits(Part, table="limits"):
    """The bounds of the mission."""

    fence: tuple[Pair, ...] = entry(
        "corners [x, y] of the area in which the robot must stay (default: no fence)", "m", default=()
    )
    depth: DepthBelow = entry("depth that the robot must not exceed (default: 5)", "m", default=5.0)
    battery: Reserve = entry("fraction of the usable charge that must remain at home (default: 0.1)", default=0.1)
    duration: Seconds | None = entry("time by which the robot should be home (default: no end)", "s", default=None)
    silence_below: Flag = entry(
        "whether a silent ground station recalls the robot under water, too (default: false)", default=False
    )

    def _checks(self) -> Iterator[Check]:
        """Yield checks that the fence is a polygon whose sides do not cross."""
        if not self.fence:
            return
        fix = "give [[x, y], [x, y], [x, y], ...] in m, or leave it out"
        count = len(self.fence)
        yield Check(3 <= count <= MAX_CORNERS, "fence", f"must have 3 to {MAX_CORNERS} corners", fix, f"{count}")
        fence_sides = sides(self.fence)
        fix = "remove one of the two; the fence closes itself from the last corner to the first"
        for i, (begin, end) in enumerate(fence_sides):
            yield Check(begin != end, f"fence[{i}]", "must not repeat the corner before it", fix)
        for i, k in itertools.combinations(range(count), 2):
            separate = k == i + 1 or k - i == count - 1 or not cross(fence_sides[i], fence_sides[k])
            rule = f"must not have sides that cross, as those after corners {i} and {k} do"
            yield Check(separate, "fence", rule, "reorder the corners")
        directions = {math.atan2(b[1] - a[1], b[0] - a[0]) % math.pi for a, b in fence_sides}
        yield Check(len(directions) > 1, "fence", "must enclose an area", "move a corner off the line")


class Gps(Part, table="gps"):
    """Fixes of the position, which only come at the surface."""

    surface_every: Seconds | None = entry(
        "time since the last fix after which the robot surfaces (default: only when needed)", "s",
        default=None)  # fmt: skip
    gaps: tuple[tuple[Moment, Moment], ...] = entry(
        "periods [from, to] without satellites, in order (default: none)", "s", default=(), max_length=MAX_GAPS
    )
    cold: Flag = entry(
        "whether the receiver starts without an almanac: its first fix takes 30 to 60 s (default: false)", default=False
    )
    jump: NotNegative = entry(
        "largest jump of the fixes by reflected signals; it lasts 3 to 12 s (default: 0)", "m", default=0.0
    )
    jump_every: Seconds | None = entry("mean time between two jumps (default: no jumps)", "s", default=None)
    jump_told: Flag = entry("whether the receiver's accuracy includes the jumps (default: true)", default=True)

    def _checks(self) -> Iterator[Check]:
        """Yield checks that gaps follow each other."""
        last = 0.0
        for i, (begin, end) in enumerate(self.gaps):
            yield Check(
                begin < end, f"gaps[{i}]", "must be [from, to], the first time before the second", "exchange the two"
            )
            rule = f"must begin after the previous gap ends at {last:g} s"
            yield Check(begin >= last, f"gaps[{i}]", rule, "sort the gaps, and merge those that overlap")
            last = end


class Scatter(Part, table="scatter"):
    """Conditions that differ from seed to seed, in addition to the sensors' noise; seed 0 leaves them out."""

    current: Current = entry("maximum speed of an added current in a random direction (default: 0)", "m/s", default=0.0)
    gaps: Annotated[int, Field(strict=True, ge=0, le=MAX_GAPS)] = entry(
        "number of added periods without satellites (default: 0)", default=0
    )
    gap: NotNegative = entry("maximum duration of each of these periods (default: 0)", "s", default=0.0)

    def _checks(self) -> Iterator[Check]:
        fix = "give the largest length of a gap in s, or remove scatter.gaps"
        yield Check(not self.gaps or self.gap > 0, "gap", "must be greater than 0 if scatter.gaps is", fix)


def _printable(text: str) -> str:
    """Check that a text is a line of printable characters, since the name is written to files and pictures."""
    if not text.isprintable():
        raise ValueError("must be one line without control characters")
    return text


class Document(Part):
    """A mission. x is east and y is north of the origin in m, depth is down, directions are compass degrees."""

    format: Literal[1] = entry("version of this format, 1")
    name: Annotated[Text, AfterValidator(_printable)] = entry("name of the mission")
    description: str = entry("sentence that states the purpose of the mission (default: none)", default="")
    robot: Text | None = entry("robot that swims the mission (default: that of --robot)", default=None)
    stay: Flag = entry(
        "whether the robot surfaces at the last waypoint instead of going home (default: false)", default=False
    )
    origin: Origin | None = entry("table of the origin of x and y", default=None)
    start: Start = entry("table of the start")
    waypoints: tuple[WaypointTable, ...] = entry(
        "list of waypoints in their order", min_length=1, max_length=MAX_WAYPOINTS
    )
    home: Home = entry("table of the home", default_factory=Home)
    water: Water = entry("table of the water", default_factory=Water)
    weather: Weather = entry("table of the weather", default_factory=Weather)
    limits: Limits = entry("table of the bounds", default_factory=Limits)
    gps: Gps = entry("table of the fixes", default_factory=Gps)
    scatter: Scatter = entry("table of the randomized conditions", default_factory=Scatter)

    def _checks(self) -> Iterator[Check]:
        """Yield checks that depths are above the ground and above the depth limit."""
        bottom, limit = self.water.bottom, self.limits.depth
        ground = f"must be less than water.bottom_m = {bottom:g}, the depth of the ground"
        fix = "reduce it, or correct water.bottom_m"
        places = {"start": self.start} | {f"waypoints[{i}]": point for i, point in enumerate(self.waypoints)}
        for name, place in places.items():
            key, depth, value = f"{name}.depth_m", place.depth, f"{place.depth:g}"
            yield Check(depth < bottom, key, ground, fix, value)
            rule, raised = f"must be at most limits.depth_m = {limit:g}", "reduce it, or raise limits.depth_m"
            yield Check(depth <= limit, key, rule, raised, value)
        yield Check(limit < bottom, "limits.depth_m", ground, fix, f"{limit:g}")
