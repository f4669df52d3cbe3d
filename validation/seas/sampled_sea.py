"""Random seas: place, weather, current, mission, and what fails there. Everything follows from the seed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from hypertuna.control.guidance import gait_table
from hypertuna.description.robot import load
from hypertuna.errors import InputError

ROBOT = "hypertuna"
SWIMS = gait_table(load(ROBOT)).speed[-1]  # m/s
TOO_FAST = 0.06  # part of the seas whose current is faster than the robot, so that it must refuse the mission
TOLD_FROM = math.radians(30)  # error of a compass from which the robot must report it
ORDERED = 5.0  # s in which someone holds the robot while it receives its mission

# Failures, and for each the words of which the robot must report one: parts of names of reasons, faults, refusals and
# states. Without words it is no failure of the robot's own, and the mission may end as if nothing had failed.
FAULTS: dict[str, tuple[str, ...]] = {
    "none": (),
    "depth:nan": ("depth",),
    "depth:stuck": ("depth", "no_answer"),
    "imu:nan": ("imu",),
    "imu:gaps": ("imu",),
    "field:nan": ("compass",),
    "field:stuck": ("compass",),
    "position:nan": ("fix", "uncertain"),
    "battery:nan": ("battery",),
    "bend-I:nan": ("bend",),
    "pressure-II:nan": ("pressure",),
    "current-I:nan": ("current_sensor",),
    "bus:stuck": ("depth", "overrun", "late"),
    "board:brownout": ("watchdog", "reset", "power", "surface"),
    "board:watchdog": ("watchdog", "reset"),
    "hull:leak": ("leak",),
    "battery low": ("battery",),
    "battery empty": ("battery",),
    "fin-port:stuck": ("fin", "no_answer", "stranded"),
    "fin-starboard:down": ("fin", "no_answer", "stranded"),
    "fins:level": ("fin", "no_answer", "stranded"),
    "link:lost": (),
    "station:second": (),
    "stick:noise": (),
    "receiver cold": (),
    "receiver lying": (),
    "oil-I-left:lost": ("no_stroke",),
    "servo-II-right:stuck": ("no_stroke", "no_progress", "bend"),
    "body:tethered": ("no_progress", "stranded", "no_answer", "swept"),
    "body:held": ("no_progress", "stranded", "no_answer", "swept"),
    "compass turned": ("compass",),
    "compass iron": ("compass", "not_ready"),  # a field too weak or strong: it does not arm
    "receiver elsewhere": ("fixes_refused",),
}
KINDS = tuple(FAULTS)  # of failures
# Groups of failures of which the command line may ask for a number of seas.
GROUPS = {"entangled": ("body:tethered", "body:held"), "compass": ("compass turned", "compass iron")}


def kinds_of(seeds: range, asked: Mapping[str, int]) -> list[str]:
    """Return each seed's kind of failure: the asked number of each group, spread over all seeds; the others in turn."""
    special = [GROUPS[group][k % len(GROUPS[group])] for group, number in asked.items() for k in range(number)]
    if len(special) > len(seeds):
        raise InputError("must fit into the seeds", key="--group", value=f"{len(special)}", fix="ask for more seeds")
    places = {len(seeds) * k // len(special): kind for k, kind in enumerate(special)} if special else {}
    others = count(seeds.start)
    return [places.get(k) or KINDS[next(others) % len(KINDS)] for k in range(len(seeds))]


@dataclass(frozen=True)
class Sea:
    """A sea with a mission and a failure."""

    seed: int
    kind: str  # of FAULTS
    fault: tuple[str, ...]  # as `firmware_in_the_loop` takes it
    start: float  # s: when it begins; 0 for from the start
    document: dict[str, Any]  # of the mission file
    too_fast: bool  # whether the current is above what the robot swims
    off: float = 0.0  # rad, largest error of the compass over all headings
    iron: tuple[float, float] = (0.0, 0.0)  # field that iron adds toward tail and starboard, over the field's strength

    @property
    def words(self) -> tuple[str, ...]:
        """Return the words of which the robot must report one; none where its failure is too small."""
        small = self.kind.startswith("compass") and self.off < TOLD_FROM
        return () if small else FAULTS[self.kind]


def sampled(seed: int, kind: str | None = None) -> Sea:
    """Return the sea of a seed with a kind of failure; by default consecutive seeds go through all kinds."""
    random = np.random.default_rng([seed, 26])
    kind = KINDS[seed % len(KINDS)] if kind is None else kind
    document = _mission(random)
    too_fast = bool(random.uniform() < TOO_FAST)
    _water(random, document, too_fast)
    _weather(random, document)
    begin = round(ORDERED + float(random.uniform(10, 120)), 2)
    document["start"]["battery"] = round(float(random.uniform(0.6, 1)), 3)
    match kind:
        case "battery low":
            document["start"]["battery"] = round(document["limits"]["battery"] + float(random.uniform(0.01, 0.03)), 3)
        case "battery empty":
            document["start"]["battery"] = round(float(random.uniform(0.01, 0.04)), 3)
        case "receiver cold":
            document["gps"]["cold"] = True
        case "receiver lying":
            document["gps"] |= {"jump_m": 30.0, "jump_every_s": 40.0, "jump_told": bool(random.uniform() < 0.5)}
        case "receiver elsewhere":
            document["gps"] |= {"jump_m": 2000.0, "jump_every_s": 40.0, "jump_told": False}
    off, iron = _compass(random, document, kind) if kind.startswith("compass") else (0.0, (0.0, 0.0))
    at_start = kind == "none" or " " in kind
    start = 0.0 if at_start else begin
    return Sea(seed, kind, _spelled(kind, begin, random), start, document, too_fast, off, iron)


def _spelled(kind: str, begin: float, random: np.random.Generator) -> tuple[str, ...]:
    """Return a failure as the loop takes it; what other stations send is in `stations.py`."""
    if kind == "imu:gaps":  # half a second in each second, for a minute
        return tuple(f"imu:nan@{begin + k:.2f}-{begin + k + 0.5:.2f}" for k in range(60))
    if kind in ("link:lost", "bus:stuck"):
        return (f"{kind}@{begin}-{begin + float(random.uniform(30, 120)):.2f}",)
    if kind == "none" or " " in kind or kind.startswith(("station", "stick")):
        return ()
    return (f"{kind}@{begin}",)


def _compass(random: np.random.Generator, document: dict[str, Any], kind: str) -> tuple[float, tuple[float, float]]:
    """Sample a compass's largest error [rad], and the field of iron on board that causes it.

    A compass that is turned is off by the same angle on every heading, as by a wrong declination. One beside iron is
    off by up to an angle whose sine is the ratio of iron and horizontal field; from a right angle on by more and more
    headings.
    """
    off, toward = float(random.uniform(0, math.pi)), float(random.uniform(0, 2 * math.pi))
    if kind == "compass turned":
        told = document["origin"]["declination_deg"] + math.degrees(math.copysign(off, math.pi - toward))
        document["origin"]["declination_deg"] = round((told + 180) % 360 - 180, 2)
        return off, (0.0, 0.0)
    flat = math.cos(math.radians(document["weather"]["dip_deg"]))
    size = flat * (math.sin(off) if off < math.pi / 2 else 2 * off / math.pi)
    return off, (size * math.cos(toward), size * math.sin(toward))


def _mission(random: np.random.Generator) -> dict[str, Any]:
    """Sample a mission: a start off the origin, one to four waypoints, depths, fence, home."""
    bottom = float(random.uniform(3, 12))
    place = random.uniform(-40, 40, 2)
    start, points = place.copy(), []
    for _ in range(int(random.integers(1, 5))):
        way, turn = random.uniform(10, 25), random.uniform(0, 2 * math.pi)
        place = place + way * np.array([math.sin(turn), math.cos(turn)])
        depth = 0.0 if random.uniform() < 0.2 else random.uniform(0.4, min(3.0, bottom - 1))
        speed = SWIMS * float(random.uniform(0.58, 0.98))
        points.append({
            **_at(place), "depth_m": round(float(depth), 2), "speed_m_s": round(speed, 3),
            "radius_m": round(float(random.uniform(2, 4)), 2), "hold_s": float(random.choice([0, 0, 0, 5])),
        })  # fmt: skip
    home = start + random.uniform(-4, 4, 2)
    around = np.array([start, home, *((point["x_m"], point["y_m"]) for point in points)])
    low, high = around.min(0) - random.uniform(10, 25, 2), around.max(0) + random.uniform(10, 25, 2)
    limits: dict[str, Any] = {"depth_m": round(max(point["depth_m"] for point in points) + 0.8, 2), "battery": 0.2}
    limits["duration_s"] = 900.0
    if random.uniform() < 0.8:
        corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
        limits["fence_m"] = [[round(float(x), 2), round(float(y), 2)] for x, y in corners]
    latitude = float(random.uniform(-65, 65))
    return {
        "format": 1,
        "name": "sea",
        "stay": bool(random.uniform() < 0.2),
        "origin": {"latitude_deg": round(latitude, 5), "longitude_deg": round(float(random.uniform(-180, 180)), 5)},
        "start": {**_at(start), "heading_deg": round(float(random.uniform(0, 360)), 1)},
        "waypoints": points,
        "home": {**_at(home), "radius_m": 3.0, "speed_m_s": 0.3},
        "water": {"bottom_m": round(bottom, 2)},
        "limits": limits,
        "gps": {"surface_every_s": round(float(random.uniform(120, 400)), 1)},
    }


def _water(random: np.random.Generator, document: dict[str, Any], too_fast: bool) -> None:
    """Sample a current with shear."""
    speed = random.uniform(1.1, 2) * SWIMS if too_fast else random.uniform(0, 0.45) * SWIMS
    toward = random.uniform(0, 360)
    document["water"] |= {
        "current_m_s": round(float(speed), 3),
        "current_deg": round(float(toward), 1),
        "current_bottom_m_s": round(float(speed * random.uniform(0.2, 1)), 3),
        "current_bottom_deg": round(float((toward + random.normal(0, 25)) % 360), 1),
    }


def _weather(random: np.random.Generator, document: dict[str, Any]) -> None:
    """Sample air, field, tide and gusts. The declination that the robot is given is right to half a degree."""
    mountain = random.uniform() < 0.1
    air = random.uniform(80e3, 95e3) if mountain else 101325 + np.clip(random.normal(0, 1200), -4000, 3500)
    declination = float(random.uniform(-20, 20))
    dip = math.degrees(math.atan(2 * math.tan(math.radians(document["origin"]["latitude_deg"]))))  # of a dipole
    document["origin"]["declination_deg"] = round(declination + float(random.normal(0, 0.5)), 2)
    document["weather"] = {
        "air_pressure_pa": round(float(air), 0),
        "declination_deg": round(declination, 2),
        "dip_deg": round(float(np.clip(dip, -75, 75)), 1),
        "tide_m_s": round(float(random.uniform(0, 0.05)), 3),
        "tide_deg": round(float(random.uniform(0, 360)), 1),
        "tide_period_s": round(float(random.uniform(600, 3600)), 0),
        "gust_m_s": round(float(random.uniform(0, 0.1)), 3),
        "gust_deg": round(float(random.uniform(0, 360)), 1),
    }


def _at(place: Any) -> dict[str, float]:
    return {"x_m": round(float(place[0]), 2), "y_m": round(float(place[1]), 2)}
