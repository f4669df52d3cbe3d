"""Verdict of a flight, from the truth of the twin: never from what the robot says, but for whether it says why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sampled_sea import FAULTS, GROUPS, SWIMS, Sea

from hypertuna.control.mission import Mission, fence_distance

SURFACE = 0.3  # m, depth of the nose above which the robot counts as surfaced, and its radio may pass
DEEPER = 0.3  # m that may be exceeded beyond limits.depth_m, for overshoot and the depth sensor
SIGMAS = 3.0  # the true position must lie within so many reported standard deviations
SWING = 0.5  # m that the nose's swing and the body may add to a distance
STATE = "state "  # prefix of a state among the words that the robot reported
DETECTION = 20.0  # s before the end: a failure that begins later need not be reported
ENTANGLED = 200.0  # s that an entangled robot has to report it: fixes or depth must first show it
# Failures with which a robot may be unable to rise: it must then report where it is.
SUNK = ("fins:level", "oil-I-left:lost", "servo-II-right:stuck", *GROUPS["entangled"])
SWEPT = ("current", "swept", "adrift", "drift", "carried", "stranded")  # words for too fast a current


@dataclass(frozen=True)
class Truth:
    """What happened in a flight, at equal time steps, and the words that the robot reported."""

    mission: Mission
    time: NDArray[np.float64]  # (T,) [s]
    position: NDArray[np.float64]  # (T, 3) of the nose: east, north, up [m]
    sigma: NDArray[np.float64]  # (T,) standard deviation of the position, as the robot reports it [m]
    active: NDArray[np.bool_]  # (T,) whether it was guided: on its mission, on its way home or up
    place: NDArray[np.float64]  # (T, 3) where the robot reports to be: east, north, up [m]
    done: bool  # whether it reports its mission as complete, and was not called home
    told: frozenset[str]  # reasons, faults, refusals and states that it reported
    pressure: float = 0.0  # Pa, largest of all circuits in each tenth tick
    warned: bool = False  # whether the mission file with this current was refused; it is flown nevertheless


@dataclass(frozen=True)
class Verdict:
    """How a flight ended, and the rules that it broke."""

    ending: str  # home, up, where told, refused or lost
    broken: tuple[str, ...]
    excursion: float  # m outside the fence, negative inside; -inf without a fence
    allowed: float  # m outside that the reported error allows, where it was farthest outside
    depth: float  # m, the deepest
    goal_distance: float  # m at the end
    sigma: float  # m at the end
    end: float  # s
    within_two: float  # part of its reported places that are true within two standard deviations
    within_three: float  # the same within three; each coordinate of a report, ten a second, counts by itself


def judge(truth: Truth, sea: Sea) -> Verdict:
    """Judge a flight by its truth."""
    mission, depth = truth.mission, -truth.position[:, 2]
    last = int(np.flatnonzero(truth.active)[-1]) if truth.active.any() else -1
    during = slice(0, last + 1)
    goal = mission.course[-1] if truth.done else mission.home
    away = float(np.hypot(*(truth.position[last, :2] - goal)))
    sigma = float(truth.sigma[last])
    margin = fence_distance(mission, truth.position[during, :2]) if last >= 0 else np.array([np.inf])
    beyond = -margin - SIGMAS * truth.sigma[during] - SWING if last >= 0 else -margin
    worst = int(np.argmax(beyond))
    deepest = float(depth[during].max()) if last >= 0 else 0.0
    radius = mission.waypoints[-1].radius if truth.done and mission.stay else mission.home_radius
    at_goal = away <= radius + SIGMAS * sigma + SWING
    up = float(depth[max(0, last - 10) : last + 10].min()) <= SURFACE
    ending = "refused" if last < 0 else "home" if at_goal and up else "up" if up else "lost"
    if ending == "lost" and sea.kind in SUNK and truth.told & {"stranded", "no_progress"}:
        off = truth.place[last] - truth.position[last]
        if np.hypot(*off[:2]) <= SIGMAS * sigma + SWING and abs(off[2]) <= SURFACE:
            ending = "where told"
    off = np.abs(truth.place[during, :2] - truth.position[during, :2])[truth.active[during]]
    deviations = off / truth.sigma[during][truth.active[during], None]
    within = [float((deviations <= limit).mean()) if last >= 0 else 1.0 for limit in (2.0, 3.0)]
    broken = []
    if ending == "lost":
        broken.append("not up")
    if truth.done and not at_goal:
        broken.append("done elsewhere")
    if beyond[worst] > 0 and not _swept(truth, sea):
        broken.append("outside the fence")
    if deepest > mission.depth_max + DEEPER:
        broken.append("too deep")
    if not _tells(truth, sea, ending, float(truth.time[last])):
        broken.append("does not tell why")
    if sea.too_fast and not truth.warned:
        broken.append("current not refused")
    if ending == "refused" and not sea.too_fast and not FAULTS[sea.kind]:
        broken.append("refused without a reason")
    return Verdict(
        ending, tuple(broken), float(-margin[worst]), float(SIGMAS * truth.sigma[worst] + SWING), deepest, away, sigma,
        float(truth.time[last]), *within,
    )  # fmt: skip


def _swept(truth: Truth, sea: Sea) -> bool:
    """Return whether the robot reported a current that is too fast for it, and there is one."""
    water: dict[str, Any] = sea.document["water"] | sea.document["weather"]
    strongest = water["current_m_s"] + water["tide_m_s"] + water["gust_m_s"]
    return strongest > 0.8 * SWIMS and any(word in name for name in truth.told for word in SWEPT)


def _tells(truth: Truth, sea: Sea, ending: str, end: float) -> bool:
    """Return whether the robot reported its failure, or why it did not do its mission."""
    words = sea.words
    detection = ENTANGLED if sea.kind in GROUPS["entangled"] else DETECTION
    if words and sea.start + detection < end:
        return any(word in name for name in truth.told for word in words)
    complete = truth.done and ending == "home"
    return complete or any(not name.startswith(STATE) for name in truth.told)
