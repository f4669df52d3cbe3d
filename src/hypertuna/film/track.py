"""Fit the silhouette to every frame of a film, starting from the frames before or, if that fails, without a start."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.film.noise import memory_of, student
from hypertuna.film.sections import Body, SilhouetteFit
from hypertuna.film.source import Gray
from hypertuna.film.states import BORDER, FIXES, LOST, MISFIT, OK, STATES, UNSEEN
from hypertuna.film.view import View
from hypertuna.film.widths import learned, shape_off
from hypertuna.io.checkpoint import Journal

EDGES = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0)  # px: blurs of the silhouette's edge that are tried
COARSE = ((4.0, 14.0), (1.8, 8.0))  # px: blur and band of the first stages, without a known pose
NEAR = ((1.8, 8.0),)  # px: blur and band of the first stage, if earlier frames predict the pose to a few pixels
BAND = 6.0  # px: width of the band around the edge whose pixels are fitted in the last stage
ANGLE_SD = 1.0  # rad: prior standard deviation of the joint angles
SIZE_SD, GIRTH_SD, ESTIMATED_GIRTH_SD = 0.15, 0.05, 0.2  # prior standard deviations of log size and log girth
LOSS_SCALE = 0.3  # fraction of the contrast: larger residuals weigh little in the robust loss
MAX_OFFSET = 1.5  # px: largest distance between drawn and seen edges of a good fit
MAX_BEND = 1.6  # rad: larger angles between two links are a misfit of the hind one
MIN_SEEN = 0.5  # smallest fraction of a link that must be seen
MIN_PATH = 1.5  # body lengths that the fish must swim, so that the film shows the tank behind it
FIXED_PRECISION = 1e12  # prior precision that holds an unknown at its mean
TINY = 1e-6  # least information on an unknown, in case no pixel depends on it
ANOTHER_SHAPE = 0.08  # fraction of the area: a sections file that differs by more is of another fish (right ones: 0.04)
BLOCK_FRAMES = 60  # frames per record of the journal
MAX_GAP = 0.25  # s: older frames do not predict the pose
WIDTH_ROUNDS, END_ERROR = 2, 1.0  # rounds of learning the widths; px: error of the length learned with them
# Fit of a frame in which the fish was not found.
NOTHING = SilhouetteFit(np.empty(0), np.empty(0), np.empty(0), np.inf, np.inf)


@dataclass(frozen=True)
class Tuning:
    """Properties of the fish and the film that all frames share."""

    size: float  # log of the size
    girth: float  # log of the girth
    edge: float  # px: blur of the silhouette's edge
    size_sd: float  # standard deviation of `size`


@dataclass(frozen=True)
class Outcome:
    """The fit of the silhouette to one frame, and its state."""

    state: int
    offset: float = np.inf  # px between drawn and seen edges
    fit: SilhouetteFit = NOTHING

    @property
    def rank(self) -> tuple[bool, float]:
        """Key to sort outcomes by, the best fit first."""
        return self.state in (LOST, MISFIT), self.offset


@dataclass(frozen=True)
class Tracked:
    """Pose, joint angles and their errors in every frame of a film."""

    time: Array  # (frames,) [s]
    state: Array  # (frames,): OK or another state of `states`
    unknowns: Array  # (frames, 3 + groups): nose x, y [m], heading [rad], joint angles [rad]
    covariance: Array  # (frames, 3 + groups, 3 + groups) due to the noise of pixels
    seen: Array  # (frames, links): fraction of each link that is seen
    offset: Array  # (frames,) [px] between drawn and seen edges


class Tracker:
    """Fits the silhouette of a body to the frames of a film."""

    def __init__(self, view: View, body: Body, tuning: Tuning | None = None) -> None:
        self.view, self.body, self.tuning = view, body, tuning

    def _prior(self) -> tuple[Array, Array]:
        """Return prior mean and precision (unknowns,) of a fit's unknowns, the precision times the squared noise."""
        groups, noise = len(self.body.groups), self.view.noise
        mean, sd = np.zeros(self.body.unknowns), np.full(self.body.unknowns, np.inf)
        sd[3 : 3 + groups] = ANGLE_SD
        sd[3 + groups : 5 + groups] = (
            SIZE_SD,
            GIRTH_SD if self.body.measured or self.body.learned else ESTIMATED_GIRTH_SD,
        )
        precision = (noise / sd) ** 2
        if self.tuning is not None:
            mean[3 + groups : 5 + groups] = self.tuning.size, self.tuning.girth
            precision[3 + groups : 5 + groups] = FIXED_PRECISION
        return mean, precision

    def fit(self, frame: Gray, start: Array, stages: tuple[tuple[float, float], ...], edge: float) -> Outcome:
        """Fit the silhouette to a frame from the unknowns `start`, in stages of an ever sharper edge [px]."""
        view, body = self.view, self.body
        start = start.copy()
        if self.tuning is not None:
            start[-3:-1] = self.tuning.size, self.tuning.girth
        box, _ = view.box(body, start)
        pixels = view.pixels(frame, box)
        if len(pixels) < 50:
            return Outcome(LOST)
        scaled = view.pixel * np.array([*stages, (edge, BAND)])
        found = body.fit(pixels, start, self._prior(), scaled, LOSS_SCALE * view.contrast)
        if not np.isfinite(found.unknowns).all():
            return Outcome(LOST)
        bend = np.diff(body.share, axis=0) @ found.unknowns[3 : 3 + len(body.groups)]
        found.seen[1:] *= np.abs(bend) < MAX_BEND  # a link folded over the body fits the body's pixels
        offset = found.offset / view.pixel
        _, inside = view.box(body, found.unknowns)
        if not inside:
            state = BORDER
        elif not (offset < MAX_OFFSET and found.unknowns[-1] > 0.4 * view.contrast):
            state = MISFIT
        else:
            state = UNSEEN if (found.seen < MIN_SEEN).any() else OK
        return Outcome(state, offset, found)

    def anew(self, frame: Gray, edge: float, near: Array | None = None) -> Outcome:
        """Fit the silhouette to a frame's largest parts; near: unknowns of a close frame, whose heading is kept."""
        best = Outcome(LOST)
        expected = self.body.area / self.view.pixel**2
        for fish_pixels in self.view.parts(frame)[:3]:
            if len(fish_pixels) < 0.25 * expected:
                continue
            places = self.view.grid[fish_pixels[:, 0], fish_pixels[:, 1], :2].astype(float)
            for start in guesses(self.body, places, self.view.contrast):
                if near is not None and np.cos(start[2] - near[2]) < 0:
                    continue
                best = min(best, self.fit(frame, start, COARSE, edge), key=lambda one: one.rank)
        return best

    def follow(
        self, frames: Iterator[tuple[int, Gray]], before: list[tuple[int, Array]], turn: bool
    ) -> Iterator[tuple[int, Outcome]]:
        """Yield the number and outcome of each frame; before: unknowns of up to two earlier ones; turn: tail first."""
        edge = self.tuning.edge if self.tuning is not None else EDGES[2]
        lapse = max(int(MAX_GAP * self.view.film.rate), 2)
        for number, frame in frames:
            before = [past for past in before if number - past[0] <= lapse][-2:]
            found = self.fit(frame, _ahead(before, number), NEAR, edge) if before else Outcome(LOST)
            if found.state in (LOST, MISFIT):
                fresh_fit = self.anew(frame, edge, before[-1][1] if before else None)
                if turn and not before and fresh_fit.state == OK:
                    fresh_fit = self._fit_swapped(frame, fresh_fit, edge)
                found = min(found, fresh_fit, key=lambda outcome: outcome.rank)
            if found.state in (OK, UNSEEN):
                before.append((number, found.fit.unknowns))
            yield number, found

    def _fit_swapped(self, frame: Gray, found: Outcome, edge: float) -> Outcome:
        """Fit the silhouette to a frame again, with nose and tail swapped."""
        unknowns = found.fit.unknowns
        joints, _ = self.body.joints(unknowns)
        start = np.concatenate([joints[-1], [unknowns[2] + np.pi], np.zeros(len(self.body.groups)), unknowns[-3:]])
        return self.fit(frame, start, COARSE, edge)


def _ahead(before: list[tuple[int, Array]], number: int) -> Array:
    """Return the unknowns of frame `number`, extrapolated from one or two earlier frames at constant rates."""
    last, unknowns = before[-1]
    if len(before) == 1:
        return unknowns
    rate = (unknowns - before[0][1]) / (last - before[0][0])
    rate[-3:] = 0.0
    return np.asarray(unknowns + rate * min(number - last, 3))


def tune(view: View, body: Body, estimate: Body, samples: Gray) -> tuple[Body, Tuning]:
    """Find size, girth and edge blur from samples of a film, and the widths if the body's sections are not measured.

    estimate: body with estimated sections; it replaces sections from a file that do not fit the fish in the film.
    """
    tracker, first = Tracker(view, body), 3 + len(body.groups)
    fits = _whole(tracker, samples)
    if body.measured and (shape_error := shape_off(body, learned(view, body, fits))) > ANOTHER_SHAPE:
        tracker.body = body = replace(estimate, file_off=shape_error)
        fits = _whole(tracker, samples)
    if not body.measured:
        for _ in range(WIDTH_ROUNDS):
            tracker.body = body = learned(view, body, fits)
            fits = [(frame, tracker.fit(frame, start, NEAR, EDGES[2]).fit.unknowns) for frame, start in fits]
    blur, least_noise = EDGES[0], np.inf
    for trial in EDGES:
        noise = np.median([tracker.fit(*one, (), trial).fit.noise for one in fits[:8]])
        if noise > least_noise:
            break
        blur, least_noise = trial, noise
    logs = [tracker.fit(frame, start, (), blur).fit.unknowns[first : first + 2] for frame, start in fits]
    (size, girth), (sd, _) = mean_of(np.array(logs))
    ends_sd = 0.0 if body.measured else END_ERROR * view.pixel / float(body.length.sum())
    return body, Tuning(float(size), float(girth), blur, float(np.hypot(sd, ends_sd)))


def mean_of(values: Array) -> tuple[Array, Array]:
    """Return means and standard errors (n,) of values (samples, n) in order of time, without outliers."""
    middle = np.median(values, axis=0)
    spread = 1.4826 * np.median(np.abs(values - middle), axis=0)
    inliers = np.where(np.abs(values - middle) <= 3 * spread, values, np.nan)
    means = np.nanmean(inliers, axis=0)
    memory = memory_of(np.where(np.isfinite(inliers), inliers, means), np.arange(len(values), dtype=float))
    degrees = max(len(values) / memory - 1, 1.0)
    return means, np.nanstd(inliers, axis=0) / np.sqrt(degrees) * student(degrees)


def _whole(tracker: Tracker, samples: Gray) -> list[tuple[Gray, Array]]:
    """Return the samples that show the whole fish, each with its unknowns; raise an error if they are too few."""
    view, body = tracker.view, tracker.body
    dense = view.film.time[-1] < MAX_GAP * len(samples)  # then a sample's heading predicts the next one's
    outcomes, near = [], None
    for frame in samples:
        one = tracker.anew(frame, EDGES[2], near)
        one = tracker.anew(frame, EDGES[2]) if near is not None and one.state != OK else one
        near = one.fit.unknowns if dense and one.state == OK else None
        outcomes.append((frame, one))
    fitted = [(frame, one.fit.unknowns) for frame, one in outcomes if one.state == OK]
    if len(fitted) < 3:
        states = [one.state for _, one in outcomes]
        common = max(FIXES, key=states.count)
        if common == UNSEEN:
            check_seen(body, np.array([one.fit.seen for _, one in outcomes if one.state != LOST]), view.film.file)
        rule = f"must show one fish, whole, in 3 of {len(samples)} frames all over the film at least"
        value = f"so in {len(fitted)}; in {states.count(common)} it is {STATES[common]}"
        raise InputError(rule, file=view.film.file, value=value, fix=FIXES[common])
    places = np.array([unknowns[:2] for _, unknowns in fitted])
    path, length = float(np.linalg.norm(np.ptp(places, axis=0))), float(body.length.sum())
    if path < MIN_PATH * length:
        rule = (
            f"must swim through {MIN_PATH:g} of its lengths at least, for the tank behind it is seen where it is gone"
        )
        fix = "film a longer way, or go on filming the empty tank for longer than the fish was in it"
        raise InputError(rule, file=view.film.file, key="the fish", value=f"in {path / length:.2g} of them", fix=fix)
    return fitted


def links_of(body: Body) -> list[int]:
    """Return for each joint group the index of the first link that it turns."""
    return [int(np.flatnonzero(column)[0]) for column in body.share.T]


def check_seen(body: Body, seen: Array, file: str) -> None:
    """Check that the part behind every joint is seen in half of the frames; seen: fraction (frames, links) of links."""
    for group, k in zip(body.groups, links_of(body), strict=True):
        part = float((seen[:, k] >= MIN_SEEN).mean()) if len(seen) else 1.0
        if part < 0.5:
            rule = f"must show the part behind joint {group} in half of the frames"
            raise InputError(rule, file=file, value=f"seen in {100 * part:.0f} %", fix=FIXES[UNSEEN])


def track(tracker: Tracker, journal: Journal, progress: Callable[[int, int], None], *, turn: bool = False) -> Tracked:
    """Track the fish through the film, block by block; the journal gives blocks that it already holds."""
    film, groups = tracker.view.film, len(tracker.body.groups)
    count, n = len(film.time), 3 + groups
    state, offset = np.full(count, LOST), np.full(count, np.nan)
    unknowns, seen = np.full((count, n), np.nan), np.full((count, len(tracker.body.length)), np.nan)
    covariance = np.full((count, n, n), np.nan)
    upper = np.triu_indices(n)
    fits: Iterator[tuple[int, Outcome]] | None = None
    before: list[tuple[int, Array]] = []

    def work(first: int) -> list[list[float]]:
        nonlocal fits
        if fits is None:
            fits = tracker.follow(film.frames(first), before, turn)
        rows: list[list[float]] = []
        for number, outcome in fits:
            if outcome.state == LOST:
                rows.append([number, LOST])
            else:
                matrix = _covariance(outcome.fit, n)
                rounded = (float(f"{x:.6g}") for x in (*outcome.fit.seen, *matrix[upper]))
                rows.append([number, outcome.state, outcome.offset, *outcome.fit.unknowns.tolist(), *rounded])
            if number % BLOCK_FRAMES == BLOCK_FRAMES - 1:
                break
        return rows

    for first in range(0, count, BLOCK_FRAMES):
        for row in journal.answer([first, turn], partial(work, first)):
            number = int(row[0])
            state[number] = int(row[1])
            if len(row) > 2:
                values = np.array(row[3:])
                offset[number], fitted = row[2], values[: n + 3]
                unknowns[number], seen[number] = fitted[:n], values[n + 3 : n + 3 + seen.shape[1]]
                covariance[number][upper] = values[n + 3 + seen.shape[1] :]
                covariance[number].T[upper] = values[n + 3 + seen.shape[1] :]
                if state[number] in (OK, UNSEEN):
                    before = [*before[-1:], (number, fitted)]
        progress(min(first + BLOCK_FRAMES, count), count)
    return Tracked(film.time, state, unknowns, covariance, seen, offset)


def _covariance(found: SilhouetteFit, n: int) -> Array:
    """Return the covariance (n, n) of pose and joint angles due to the noise of pixels, for known size and girth."""
    matrix = found.information
    unknown_places = [*range(n), matrix.shape[0] - 1]
    submatrix = matrix[np.ix_(unknown_places, unknown_places)]
    unit = 1 / np.sqrt(np.maximum(np.diag(submatrix), TINY))
    value, vector = np.linalg.eigh(submatrix * unit[:, np.newaxis] * unit)
    inverse = (vector / np.maximum(value, 1e-9)) @ vector.T * unit[:, np.newaxis] * unit
    return np.asarray(found.noise**2 * inverse[:n, :n])


def forward(tracked: Tracked) -> float:
    """Return the distance [m] that the fish swam head first over all frames; negative if it swam tail first."""
    frames = np.flatnonzero(tracked.state == OK)
    poses = tracked.unknowns[frames]
    step = np.diff(poses[:, :2], axis=0)
    facing = -np.stack([np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])], axis=1)
    return float((step * facing).sum())


def guesses(body: Body, places: Array, contrast: float) -> list[Array]:
    """Return two guesses of a body's unknowns from the places (n, 2) [m] of its pixels, with the nose at either end."""
    center = places.mean(axis=0)
    centered = places - center
    _, vectors = np.linalg.eigh(centered.T @ centered)
    half = np.sqrt(body.section[:, 0])
    from_nose = float((half * body.stations).sum() / half.sum())  # distance of the area's center from the nose
    return [_guess(body, centered, center, sign * vectors[:, 1], from_nose, contrast) for sign in (1.0, -1.0)]


def _guess(body: Body, centered: Array, center: Array, axis: Array, middle: float, contrast: float) -> Array:
    """Guess a body's unknowns from its pixels (n, 2) [m] about their center: its links follow a fitted parabola.

    axis: unit vector from nose to tail; middle: distance from the nose to the center [m].
    """
    normal = np.array([-axis[1], axis[0]])
    along, across = centered @ axis + middle, centered @ normal
    parabola = np.polynomial.Polynomial.fit(along, across, 2)
    ends = np.append(0.0, np.cumsum(body.length))
    heading = np.arctan2(axis[1], axis[0]) + np.arctan(parabola.deriv()((ends[1:] + ends[:-1]) / 2))
    matrix = np.column_stack([np.ones(len(body.length)), body.share])
    turn = np.linalg.lstsq(matrix, heading, rcond=None)[0]
    nose = center - middle * axis + parabola(0.0) * normal
    return np.concatenate([nose, turn, [0.0, 0.0, contrast]])
