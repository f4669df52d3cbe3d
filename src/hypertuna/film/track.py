"""The silhouette fitted to every frame of a film, from the frames before, or anew where these do not help."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.film.first import guesses
from hypertuna.film.sections import Body
from hypertuna.film.source import Gray
from hypertuna.film.states import BORDER, FIXES, LOST, MISFIT, OK, STATES, UNSEEN
from hypertuna.film.view import View
from hypertuna.io.checkpoint import Journal

EDGES = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0)  # px: blurs of the edge that are tried
COARSE = ((4.0, 14.0), (1.8, 8.0))  # px: blur and band of the first stages, where nothing is known
NEAR = ((1.8, 8.0),)  # px: where the frames before tell the pose to a few pixels
BAND = 6.0  # px, of the last stage
FREE_ANGLE = 1.0  # rad: standard deviation of angles without pixels
SIZE_SD, GIRTH_SD, ESTIMATED_GIRTH_SD = 0.15, 0.05, 0.2  # logs, before the film is seen
LOSS = 0.3  # of the contrast: larger residuals count little
MAX_OFFSET = 1.5  # px between drawn and seen edges
MAX_BEND = 1.6  # rad between two links
MIN_SEEN = 0.5  # part of a link that must be seen
WAY = 1.5  # lengths of the fish
FIXED = 1e12  # precision of an unknown that is known
TINY = 1e-6  # of the information on an unknown that no pixel tells
BLOCK = 60  # frames of a record of the journal
GAP = 0.25  # s: after longer ones the frames before tell nothing


@dataclass(frozen=True)
class Tuning:
    """What all frames have in common."""

    size: float  # log of the size
    girth: float  # log of the girth
    edge: float  # px
    spread: tuple[float, float]  # standard deviations of the logs over the samples


@dataclass(frozen=True)
class Tracked:
    """The fish in every frame."""

    time: Array  # (frames,) [s]
    state: Array  # (frames,): OK, ...
    unknowns: Array  # (frames, 3 + groups): nose x, y [m], heading [rad], joint angles [rad]
    covariance: Array  # (frames, 3 + groups, 3 + groups) by the noise of pixels
    seen: Array  # (frames, links)
    offset: Array  # (frames,) [px]


class Tracker:
    """Fits a body to frames."""

    def __init__(self, view: View, body: Body, tuning: Tuning | None = None) -> None:
        self.view, self.body, self.tuning = view, body, tuning

    def _prior(self) -> tuple[Array, Array]:
        """Return mean and precision of the unknowns."""
        groups, noise = len(self.body.groups), self.view.noise
        mean, sd = np.zeros(self.body.unknowns), np.full(self.body.unknowns, np.inf)
        sd[3 : 3 + groups] = FREE_ANGLE
        sd[3 + groups : 5 + groups] = SIZE_SD, GIRTH_SD if self.body.measured else ESTIMATED_GIRTH_SD
        precision = (noise / sd) ** 2
        if self.tuning is not None:
            mean[3 + groups : 5 + groups] = self.tuning.size, self.tuning.girth
            precision[3 + groups : 5 + groups] = FIXED
        return mean, precision

    def fit(self, frame: Gray, start: Array, stages: tuple[tuple[float, float], ...], edge: float) -> dict[str, Any]:
        """Fit the silhouette from a start, in stages ever sharper; `state` says what came of it."""
        view, body = self.view, self.body
        mean, precision = self._prior()
        start = start.copy()
        if self.tuning is not None:
            start[-3:-1] = self.tuning.size, self.tuning.girth
        box, _ = view.box(body, start)
        pixels = view.pixels(frame, box)
        if len(pixels) < 50:
            return {"state": LOST, "offset": np.inf}
        scaled = view.pixel * np.array([*stages, (edge, BAND)])
        found = body.fit(pixels, start, (mean, precision), scaled, LOSS * view.contrast)
        found["noise"], found["offset"] = found["noise_offset"] * [1.0, 1 / view.pixel]
        if not np.isfinite(found["unknowns"]).all():
            return {"state": LOST, "offset": np.inf}
        _, inside = view.box(body, found["unknowns"])
        found["state"] = BORDER if not inside else OK
        if found["state"] == OK and not (found["offset"] < MAX_OFFSET and found["unknowns"][-1] > 0.4 * view.contrast):
            found["state"] = MISFIT
        bend = np.diff(body.share, axis=0) @ found["unknowns"][3 : 3 + len(body.groups)]
        found["seen"][1:] *= np.abs(bend) < MAX_BEND  # a part folded over the body is fitted to it, not seen
        if found["state"] == OK and (found["seen"] < MIN_SEEN).any():
            found["state"] = UNSEEN
        return found

    def anew(self, frame: Gray, edge: float, near: Array | None = None) -> dict[str, Any]:
        """Fit the silhouette without a start: to the largest parts, in the direction of `near` or in both."""
        best: dict[str, Any] = {"state": LOST, "offset": np.inf}
        expected = self.body.area / self.view.pixel**2
        for part in self.view.parts(frame)[:3]:
            if len(part) < 0.25 * expected:
                continue
            places = self.view.grid[part[:, 0], part[:, 1], :2].astype(float)
            for start in guesses(self.body, places, self.view.contrast):
                if near is not None and np.cos(start[2] - near[2]) < 0:
                    continue
                found = self.fit(frame, start, COARSE, edge)
                if _rank(found) < _rank(best):
                    best = found
        return best

    def follow(self, frames: Iterator[tuple[int, Gray]], before: list[tuple[int, Array]], turn: bool) -> Iterator[Any]:
        """Yield (number, fit) of frames; before: fits of up to two frames before; turn: tail first at the start."""
        edge = self.tuning.edge if self.tuning is not None else EDGES[2]
        lapse = max(int(GAP * self.view.film.rate), 2)
        for number, frame in frames:
            before = [one for one in before if number - one[0] <= lapse][-2:]
            found: dict[str, Any] = {"state": LOST, "offset": np.inf}
            if before:
                found = self.fit(frame, _ahead(before, number), NEAR, edge)
            if found["state"] in (LOST, MISFIT):
                again = self.anew(frame, edge, before[-1][1] if before else None)
                if turn and not before and again["state"] == OK:
                    again = self._turned(frame, again, edge)
                found = again if _rank(again) < _rank(found) else found
            if found["state"] in (OK, UNSEEN):
                before.append((number, found["unknowns"]))
            yield number, found

    def _turned(self, frame: Gray, found: dict[str, Any], edge: float) -> dict[str, Any]:
        """Fit the silhouette the other way round."""
        joints, _ = self.body.joints(found["unknowns"])
        start = np.concatenate([joints[-1], [found["unknowns"][2] + np.pi], np.zeros(len(self.body.groups))])
        return self.fit(frame, np.append(start, found["unknowns"][-3:]), COARSE, edge)


def _rank(found: dict[str, Any]) -> tuple[bool, float]:
    """Return what is smaller for a better fit."""
    return found["state"] in (LOST, MISFIT), found["offset"]


def _ahead(before: list[tuple[int, Array]], number: int) -> Array:
    """Return the unknowns of a frame by those of one or two before, at constant rates."""
    last, unknowns = before[-1]
    if len(before) == 1:
        return unknowns
    rate = (unknowns - before[0][1]) / (last - before[0][0])
    rate[-3:] = 0.0
    return np.asarray(unknowns + rate * min(number - last, 3))


def tune(view: View, body: Body, samples: Gray) -> Tuning:
    """Find size, girth and blur of the edge from samples of a film."""
    tracker, groups = Tracker(view, body), len(body.groups)
    found = [(frame, tracker.anew(frame, EDGES[2])) for frame in samples]
    whole = [(frame, one) for frame, one in found if one["state"] == OK]
    if len(whole) < 3:
        states = [one["state"] for _, one in found]
        common = max(FIXES, key=states.count)
        if common == UNSEEN:
            check_seen(body, np.array([one["seen"] for _, one in found if "seen" in one]), view.film.file)
        rule = f"must show one fish, whole, in 3 of {len(samples)} frames all over the film at least"
        value = f"so in {len(whole)}; in {states.count(common)} it is {STATES[common]}"
        raise InputError(rule, file=view.film.file, value=value, fix=FIXES[common])
    places = np.array([one["unknowns"][:2] for _, one in whole])
    way, length = float(np.linalg.norm(np.ptp(places, axis=0))), float(body.length.sum())
    if way < WAY * length:
        rule = f"must swim through {WAY:g} of its lengths at least, for the tank behind it is seen where it is gone"
        fix = "film a longer way, or go on filming the empty tank for longer than the fish was in it"
        raise InputError(rule, file=view.film.file, key="the fish", value=f"in {way / length:.2g} of them", fix=fix)
    noises = []
    for edge in EDGES:
        again = [tracker.fit(frame, one["unknowns"], (), edge)["noise"] for frame, one in whole[:8]]
        noises.append(float(np.median(again)))
    edge = EDGES[int(np.argmin(noises))]
    logs = np.array(
        [tracker.fit(frame, one["unknowns"], (), edge)["unknowns"][3 + groups : 5 + groups] for frame, one in whole]
    )
    size, girth = np.median(logs, axis=0)
    spread = 1.4826 * np.median(np.abs(logs - [size, girth]), axis=0)
    return Tuning(float(size), float(girth), edge, (float(spread[0]), float(spread[1])))


def links_of(body: Body) -> list[int]:
    """Return the first link that each joint group turns."""
    return [int(np.flatnonzero(column)[0]) for column in body.share.T]


def check_seen(body: Body, seen: Array, file: str) -> None:
    """Check that the part behind every joint is seen (frames, links) in half of the frames."""
    for group, k in zip(body.groups, links_of(body), strict=True):
        part = float((seen[:, k] >= MIN_SEEN).mean()) if len(seen) else 1.0
        if part < 0.5:
            rule = f"must show the part behind joint {group} in half of the frames"
            raise InputError(rule, file=file, value=f"seen in {100 * part:.0f} %", fix=FIXES[UNSEEN])


def track(tracker: Tracker, journal: Journal, progress: Callable[[int, int], None], *, turn: bool = False) -> Tracked:
    """Track the fish through the film, block by block; what the journal holds is not computed again."""
    film, groups = tracker.view.film, len(tracker.body.groups)
    count, n = len(film.time), 3 + groups
    state, offset = np.full(count, LOST), np.full(count, np.nan)
    unknowns, seen = np.full((count, n), np.nan), np.full((count, len(tracker.body.length)), np.nan)
    covariance = np.full((count, n, n), np.nan)
    upper = np.triu_indices(n)
    fits: Iterator[Any] | None = None
    before: list[tuple[int, Array]] = []

    def work(first: int) -> list[list[float]]:
        nonlocal fits
        if fits is None:
            fits = tracker.follow(film.frames(first), before, turn)
        rows = []
        for number, found in fits:
            if found["state"] == LOST:
                rows.append([number, LOST])
            else:
                matrix = _covariance(found, n)
                short = (float(f"{x:.6g}") for x in (*found["seen"], *matrix[upper]))
                rows.append([number, found["state"], found["offset"], *found["unknowns"].tolist(), *short])
            if number % BLOCK == BLOCK - 1:
                break
        return rows

    for first in range(0, count, BLOCK):
        for row in journal.answer([first, turn], partial(work, first)):
            number = int(row[0])
            state[number] = int(row[1])
            if len(row) > 2:
                values = np.array(row[3:])
                offset[number], whole = row[2], values[: n + 3]
                unknowns[number], seen[number] = whole[:n], values[n + 3 : n + 3 + seen.shape[1]]
                covariance[number][upper] = values[n + 3 + seen.shape[1] :]
                covariance[number].T[upper] = values[n + 3 + seen.shape[1] :]
                if state[number] in (OK, UNSEEN):
                    before = [*before[-1:], (number, whole)]
        progress(min(first + BLOCK, count), count)
    return Tracked(film.time, state, unknowns, covariance, seen, offset)


def _covariance(found: dict[str, Any], n: int) -> Array:
    """Return the covariance (n, n) of pose and angles by the noise of pixels; size and girth are known."""
    matrix = found["information"]
    own = [*range(n), matrix.shape[0] - 1]
    kept = matrix[np.ix_(own, own)]
    unit = 1 / np.sqrt(np.maximum(np.diag(kept), TINY))
    value, vector = np.linalg.eigh(kept * unit[:, np.newaxis] * unit)
    inverse = (vector / np.maximum(value, 1e-9)) @ vector.T * unit[:, np.newaxis] * unit
    return np.asarray(found["noise"] ** 2 * inverse[:n, :n])


def forward(tracked: Tracked) -> float:
    """Return how far the fish went head first [m], over all frames; negative where the tail leads."""
    own = np.flatnonzero(tracked.state == OK)
    z = tracked.unknowns[own]
    step = np.diff(z[:, :2], axis=0)
    facing = -np.stack([np.cos(z[:-1, 2]), np.sin(z[:-1, 2])], axis=1)
    return float((step * facing).sum())
