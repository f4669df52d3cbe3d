"""Mission files: TOML with waypoints, water and limits."""

import hashlib
import json
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from hypertuna.arguments import checked
from hypertuna.control.mission import Mission, Waypoint, cross, fence_distance, sides
from hypertuna.description.mistakes import translate
from hypertuna.display import Plotted, Tabular
from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.frames import pose_from
from hypertuna.io.door import read_toml
from hypertuna.io.files import shipped
from hypertuna.mission.geodesy import MAX_DISTANCE, to_local
from hypertuna.mission.schema import Document, Place, Scatter
from hypertuna.ranges import NOT_NEGATIVE

TURN = 2 * math.pi  # rad: full circle
# Fields added after version 0.2.0, which enter the hash only if set.
LATER = {"silence_below", "declination", "air_pressure", "dip", "field_declination", "tide", "tide_period", "gust"}
LATER |= {"gust_depth", "gust_time", "cold", "jump", "jump_every", "jump_told"}
PLANS = (".plan", ".waypoints", ".gpx", ".kml")  # suffixes of other programs' plans, which must be imported
GAP_SPAN = 3600.0  # s from the start, within which drawn gaps begin in a mission without a time limit


@dataclass(frozen=True)
class MissionFile(Plotted, Tabular):
    """A mission file, read and checked."""

    name: str
    description: str
    robot: str | None  # name or path; None if the file names none
    mission: Mission  # in SI units and the frames of docs/conventions.md
    origin: tuple[float, float] | None  # latitude and longitude of x = y = 0 [rad]
    scatter: Scatter  # randomized by the seed
    file: str  # empty if not read from a file
    hash: str  # sha256 of everything in the file that can change a result
    declination: float | None = None  # magnetic declination at the origin [rad]; None if not in the file


def missions() -> tuple[str, ...]:
    """List the missions that come with hypertuna."""
    return tuple(sorted(path.stem for path in shipped("missions").glob("*.toml")))


@checked
def read_mission(path: str | Path) -> MissionFile:
    """Read a mission file, or a mission that comes with hypertuna, and check it.

    Parameters
    ----------
    path : str or Path
        Of a TOML file, or the name of a mission that comes with hypertuna.

    Returns
    -------
    MissionFile

    Raises
    ------
    InputError
        If there is no such mission, or it cannot be used: file, key, rule, value and fix.
    """
    name = file = str(path)
    if Path(name).suffix.lower() in PLANS:
        command = f"hypertuna mission import {shlex.quote(name)} -o {shlex.quote(Path(name).stem)}.toml"
        raise InputError(f"is a plan, not a mission: `{command}` makes one of it", file=name)
    if not name.lower().endswith(".toml"):
        if name not in missions():
            rule, fix = "must be a .toml file or a mission that comes with hypertuna", did_you_mean(name, missions())
            raise InputError(rule, key="mission", value=shown(name), fix=fix)
        path, file = shipped("missions") / f"{name}.toml", f"missions/{name}.toml"
    return parse_mission(read_toml(path, file=file), file=file)


def parse_mission(document: Mapping[str, Any], *, file: str = "") -> MissionFile:
    """Check a mission file's document, and return its mission."""
    try:
        checked = Document.model_validate(document)
        mission = _mission(checked)
        _check_mission(mission)
    except ValidationError as error:
        raise translate(error, document, Document, file or None) from None
    except InputError as error:
        raise InputError(error.rule, file=file or None, key=error.key, value=error.value, fix=error.fix) from None
    origin = None if checked.origin is None else (checked.origin.latitude, checked.origin.longitude)
    facts = json.dumps([_facts(mission), origin, checked.scatter.model_dump()], sort_keys=True)
    digest = hashlib.sha256(facts.encode()).hexdigest()
    return MissionFile(
        checked.name,
        checked.description,
        checked.robot,
        mission,
        origin,
        checked.scatter,
        file,
        digest,
        None if checked.origin is None else checked.origin.declination,
    )


def randomized(given: MissionFile, seed: int) -> Mission:
    """Add a current and GPS gaps to the mission, drawn by the seed from its scatter; seed 0 changes nothing."""
    NOT_NEGATIVE.check(seed, "seed", "give 0 or more")
    mission, scatter = given.mission, given.scatter
    if seed == 0:
        return mission
    random = np.random.default_rng([seed, scatter_seed(given)])  # hosts/scatter.hpp draws the same numbers
    east, north = toward(scatter.current * random.uniform(), TURN * random.uniform())
    starts, lengths = (
        scatter_span(mission) * random.uniform(size=scatter.gaps),
        scatter.gap * random.uniform(size=scatter.gaps),
    )
    pairs = sorted([*mission.gaps, *zip(starts.tolist(), (starts + lengths).tolist(), strict=True)])
    return replace(
        mission,
        current=(mission.current[0] + east, mission.current[1] + north),
        current_bottom=(mission.current_bottom[0] + east, mission.current_bottom[1] + north),
        gaps=_joined(pairs),
    )


def toward(speed: float, direction: float) -> tuple[float, float]:
    """Return the velocity toward east and north [m/s] from a speed [m/s] and a compass direction [rad]."""
    return speed * math.sin(direction), speed * math.cos(direction)


def scatter_seed(file: MissionFile) -> int:
    """Return a number from a mission's hash, which seeds its random draws together with the flight's seed."""
    return int(file.hash[:8], 16)


def scatter_span(mission: Mission) -> float:
    """Return the time [s] after the start within which drawn GPS gaps begin."""
    return mission.duration or GAP_SPAN


def _facts(mission: Mission) -> dict[str, Any]:
    """Return a mission's values for its hash; keys of `LATER` only if set, so that old files keep their hash."""
    facts = asdict(mission)
    facts["waypoints"] = [point if point.hold else point[:-1] for point in mission.waypoints]
    defaults = {field.name: field.default for field in fields(mission)}
    return {name: value for name, value in facts.items() if name not in LATER or value != defaults[name]}


# --- checks


def _check_mission(mission: Mission) -> None:
    """Check that places are near the origin, and start, home, waypoints and legs between them inside the fence."""
    places = {"start": mission.start, "home": mission.home}
    places |= {f"waypoints[{i}]": (point.x, point.y) for i, point in enumerate(mission.waypoints)}
    corners = {f"limits.fence_m[{i}]": corner for i, corner in enumerate(mission.fence)}
    for key, (x, y) in (corners | places).items():
        if max(abs(x), abs(y)) > MAX_DISTANCE:
            rule, fix = f"must be within {MAX_DISTANCE / 1e3:g} km of the origin", "give it in m, or move the origin"
            raise InputError(rule, key=key, value=f"at {x:.6g}, {y:.6g} m", fix=fix)
    for key, (x, y) in places.items():
        if fence_distance(mission, np.array([[x, y]]))[0] <= 0:
            fix = "move the point inside, or enlarge the fence"
            raise InputError("must be inside limits.fence_m", key=key, value=f"at {x:.6g}, {y:.6g} m", fix=fix)
    for k, leg in enumerate(pairwise(mission.course)):
        if any(cross(leg, side) for side in sides(mission.fence)):
            key = f"waypoints[{k}]" if k < len(mission.waypoints) else "home"
            rule = "must be reachable on a straight course inside limits.fence_m"
            raise InputError(rule, key=key, fix="add a waypoint on the way, or widen the fence")


# --- conversion to SI units and to the frames of docs/conventions.md


def _mission(document: Document) -> Mission:
    """Convert a checked document to a mission: places to m from the origin, directions to velocities."""
    start, home, water, limits = document.start, document.home, document.water, document.limits
    begin = _place(document, "start", start)
    nowhere = {home.x, home.y, home.latitude, home.longitude} == {None}
    ground_current = water.current if water.current_bottom is None else water.current_bottom
    direction = water.toward if water.toward_bottom is None else water.toward_bottom
    weather, gps = document.weather, document.gps
    declination = (document.origin and document.origin.declination) or 0.0
    return Mission(
        waypoints=tuple(
            Waypoint(*_place(document, f"waypoints[{k}]", point), point.depth, point.speed, point.radius, point.hold)
            for k, point in enumerate(document.waypoints)
        ),
        start=begin,
        home=begin if nowhere else _place(document, "home", home),
        heading=float(pose_from("ned", [0.0, 0.0, start.heading])[2]),
        depth=start.depth,
        battery=start.battery,
        home_radius=home.radius,
        home_speed=home.speed,
        fence=limits.fence,
        depth_max=limits.depth,
        reserve=limits.battery,
        duration=limits.duration or 0.0,
        surface_every=gps.surface_every or 0.0,
        stay=document.stay,
        silence_below=limits.silence_below,
        declination=declination,
        bottom=water.bottom,
        current=toward(water.current, water.toward),
        current_bottom=toward(ground_current, direction),
        gaps=gps.gaps,
        air_pressure=weather.air_pressure,
        dip=weather.dip,
        field_declination=declination if weather.declination is None else weather.declination,
        tide=toward(weather.tide, weather.tide_toward),
        tide_period=weather.tide_period,
        gust=toward(weather.gust, weather.gust_toward),
        gust_depth=weather.gust_depth,
        gust_time=weather.gust_time,
        cold=gps.cold,
        jump=gps.jump,
        jump_every=gps.jump_every or 0.0,
        jump_told=gps.jump_told,
    )


def _place(document: Document, key: str, place: Place) -> tuple[float, float]:
    """Return a place, given in m or in degrees but not both, as east and north of the origin [m]."""
    local = [value for value in (place.x, place.y) if value is not None]
    degrees = [value for value in (place.latitude, place.longitude) if value is not None]
    if local and degrees:
        fix = "remove one of the two pairs"
        raise InputError("must be x_m and y_m, or latitude_deg and longitude_deg, not both", key=key, fix=fix)
    if len(local or degrees) != 2:
        fix = "give both in m, or latitude_deg and longitude_deg with the table [origin]"
        raise InputError("must have x_m and y_m", key=key, fix=fix)
    if degrees:
        if document.origin is None:
            fix = "add the table [origin] with latitude_deg and longitude_deg, or give x_m and y_m"
            raise InputError("needs the table [origin]", key=f"{key}.latitude_deg", fix=fix)
        local = to_local((document.origin.latitude, document.origin.longitude), *degrees).tolist()
    return local[0], local[1]


def _joined(pairs: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Join gaps (start, end) [s], sorted by start, that touch or overlap."""
    joined: list[tuple[float, float]] = []
    for begin, end in pairs:
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        elif end > begin:
            joined.append((begin, end))
    return tuple(joined)
