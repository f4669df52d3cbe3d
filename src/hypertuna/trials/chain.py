"""Fit a robot's chain of links to tracked markers: pose and joint angles of every frame by robust least squares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.description.pose import coordinate_names, coordinate_shares
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError

Flags = NDArray[np.bool_]  # truth values

ITERATIONS = 60  # of Levenberg-Marquardt per round
MIN_STEP = 1e-9  # body lengths or rad: a smaller step ends the iteration
RIDGE, MAX_DAMPING = 1e-9, 1e6  # least and largest damping of Levenberg-Marquardt, over the diagonal
HUBER, TUKEY = 1.5, 6.0  # standard deviations beyond which a marker weighs less (Huber), or nothing (Tukey)
ROUNDS = 6  # largest number of rounds that fit the chain and then estimate the noise
NOISE_TOLERANCE = 1e-3  # relative change of the noise that ends these rounds
MEDIAN_NORM = 1.1774  # median distance of a marker whose coordinates have a standard deviation of 1: sqrt(2 ln 2)
REJECTED = 0.1  # robust weight below which a marker counts as rejected
MAX_SD = 0.2  # rad: largest standard deviation of an angle that counts as determined
MIN_NOISE = 1e-9  # m
MIN_RANK = 1e-6  # smallest over largest singular value of the scaled marker Jacobian that has full rank


@dataclass(frozen=True)
class Chain:
    """A robot's links with markers on them. Unknowns of a frame: the nose's pose, all angles."""

    length: Array  # (links,) [m]
    share: Array  # (links, groups): heading of a link = that of the head + share @ joint angles
    along: Array  # (markers, links) [m]: distance to go along each link's axis from the nose to a marker
    across: Array  # (markers, links) [m]: distance to go along each link's normal, to starboard
    groups: tuple[str, ...]

    def __call__(self, z: Array) -> tuple[Array, Array]:
        """Return places (frames, markers, 2) [m] and their Jacobian (frames, markers, 2, n) at unknowns (frames, n)."""
        angle = z[:, 2:3] + z[:, 3:] @ self.share.T
        axis = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        normal = np.stack([-axis[..., 1], axis[..., 0]], axis=-1)
        place = z[:, np.newaxis, :2] + self.along @ axis + self.across @ normal
        # the heading of link i moves marker m along that link's normal
        by_link = self.along[..., np.newaxis] * normal[:, np.newaxis]
        by_link = by_link - self.across[..., np.newaxis] * axis[:, np.newaxis]
        jacobian = np.zeros((*place.shape, z.shape[1]))
        jacobian[..., 0, 0] = jacobian[..., 1, 1] = 1.0
        jacobian[..., 2] = by_link.sum(axis=2)
        jacobian[..., 3:] = np.einsum("fmia,ig->fmag", by_link, self.share)
        return place, jacobian


@dataclass(frozen=True)
class ChainFit:
    """Result of fitting the chain to the markers of every frame."""

    pose: Array  # (frames, 3): x, y [m] and heading [rad] of the nose, without jumps by whole turns
    angle: Array  # (frames, groups) [rad]
    covariance: Array  # (frames, n, n) of pose and angles: linearized, noise^2 (J' W J)^-1
    residual: Array  # (frames, markers, 2) [m]: place on the chain minus marker; NaN where a marker is missing
    rejected: Flags  # (frames, markers): whether a marker was seen, but is too far from the chain to count
    determined: Flags  # (frames,): whether the markers determine all angles
    noise: float  # m: standard deviation of a coordinate of a marker of weight 1

    @property
    def sd(self) -> Array:
        """Standard deviations (frames, n) of pose and angles [m, m, rad, ...]."""
        return np.asarray(np.sqrt(np.einsum("fii->fi", self.covariance)))


def chain_of(robot: Robot, link: Sequence[int], along: Sequence[float], across: Sequence[float]) -> Chain:
    """Return a robot's chain with markers on its links [m]: `along` from a link's front end, `across` to starboard."""
    length = np.array(robot.links.length)
    turn = coordinate_shares(robot)
    each = np.arange(len(length))
    own = np.asarray(link)[:, np.newaxis]
    ahead = np.where(each < own, length, np.where(each == own, np.asarray(along, dtype=float)[:, np.newaxis], 0.0))
    side = np.where(each == own, np.asarray(across, dtype=float)[:, np.newaxis], 0.0)
    return Chain(length, np.cumsum(turn, axis=0), ahead, side, coordinate_names(robot))


def merge(chain: Chain, joints: Sequence[Sequence[str]], sizes: Sequence[int]) -> tuple[Chain, Array]:
    """Return a chain in which the groups of each tuple in `joints` share one bend, and the shares (groups, bends).

    A group's share of the bend is proportional to its number of joints (`sizes`).
    """
    first_names = {name: members[0] for members in joints for name in members}
    bends = list(dict.fromkeys(first_names.get(name, name) for name in chain.groups))
    share = np.zeros((len(chain.groups), len(bends)))
    for g, name in enumerate(chain.groups):
        share[g, bends.index(first_names.get(name, name))] = sizes[g]
    share /= share.sum(axis=0)
    names = ["+".join(next((members for members in joints if members[0] == bend), [bend])) for bend in bends]
    return replace(chain, share=chain.share @ share, groups=tuple(names)), share


def unmerged(fit: ChainFit, share: Array) -> ChainFit:
    """Convert a fit of merged bends to the angles of joint groups, with the shares (groups, bends) from `merge`."""
    jacobian = np.zeros((3 + len(share), fit.covariance.shape[1]))
    jacobian[:3, :3], jacobian[3:, 3:] = np.eye(3), share
    return replace(fit, angle=fit.angle @ share.T, covariance=jacobian @ fit.covariance @ jacobian.T)


def check_rank(chain: Chain, names: Sequence[str], file: str) -> None:
    """Check that markers, if all are seen, determine pose and joint angles and have more coordinates than unknowns."""
    unknowns, size = 3 + chain.share.shape[1], float(chain.length.sum())
    _, slope = chain(np.zeros((1, unknowns)))
    jacobian = slope[0].reshape(-1, unknowns) / np.append([1.0, 1.0], np.full(unknowns - 2, size))
    _, singular, vectors = np.linalg.svd(jacobian)
    singular = np.append(singular, np.zeros(unknowns - len(singular)))
    if singular[-1] < MIN_RANK * singular[0]:
        worst = int(np.argmax(np.abs(vectors[-1][3:])))
        fix = "add markers on the links behind that joint, or describe a robot with fewer joint groups"
        rule = f"must determine every joint angle, but leave that of joint group {chain.groups[worst]} open"
        raise InputError(rule, file=file, key=f"{len(names)} markers", fix=fix)
    if jacobian.shape[0] <= unknowns:
        rule = f"must have more coordinates than the {unknowns} unknowns of a frame, to estimate errors"
        value, fix = f"{jacobian.shape[0]}", "add a marker, or describe a robot with fewer joint groups"
        raise InputError(rule, file=file, key=f"{len(names)} markers", value=value, fix=fix)


def fit_chain(chain: Chain, place: Array, weight: Array) -> ChainFit:
    """Fit the chain to markers (frames, markers, 2) [m] with weights (frames, markers), 0 where a marker is missing.

    Each frame is fitted by itself, with Huber's and then Tukey's loss of each marker's distance. The noise is that of
    all frames together. A frame that ends far from its markers starts again from its neighbors.
    """
    unknowns = 3 + chain.share.shape[1]
    seen = weight > 0
    target = np.where(seen[..., np.newaxis], place, 0.0)
    z = _first_guess(chain, place, seen)
    noise = math.inf
    z, _ = _minimize(chain, target, weight, z, _estimated_noise(chain, z, target, seen), tukey=False)
    for _ in range(ROUNDS):
        estimate = _estimated_noise(chain, z, target, seen)
        if abs(estimate / noise - 1) < NOISE_TOLERANCE:
            break
        noise = estimate
        z, cost = _minimize(chain, target, weight, z, noise, tukey=True)
        z = _start_again(chain, target, weight, z, cost, noise)
    computed, slope = chain(z)
    residual = np.where(seen[..., np.newaxis], computed - target, np.nan)
    distance = np.sqrt(weight * np.nansum(residual**2, axis=2))
    robust = np.where(seen, _tukey(distance / noise), 0.0)
    inliers = robust >= REJECTED
    # variance of the inliers: their squared distances over the degrees of freedom
    overdetermined = 2 * inliers.sum(axis=1) > unknowns
    freedom = float((2 * inliers.sum(axis=1) - unknowns)[overdetermined].sum())
    if freedom > 0:
        noise = max(math.sqrt(float((distance**2 * inliers)[overdetermined].sum()) / freedom), MIN_NOISE)
    scaled = slope * np.sqrt(weight * inliers)[..., np.newaxis, np.newaxis]
    information = np.einsum("fmai,fmaj->fij", scaled, scaled)
    covariance = noise**2 * _inverse(information, float(chain.length.sum()))
    sd = np.sqrt(np.einsum("fii->fi", covariance))
    determined = (sd[:, 2:] < MAX_SD).all(axis=1) & (2 * inliers.sum(axis=1) >= unknowns)
    pose, angle = z[:, :3].copy(), _wrapped(z[:, 3:])
    frames = np.flatnonzero(determined)
    pose[frames, 2] = np.unwrap(pose[frames, 2])
    return ChainFit(pose, angle, covariance, residual, seen & ~inliers, determined, noise)


def _wrapped(angle: Array) -> Array:
    """Return angles [rad] wrapped to -pi to pi."""
    return np.asarray((angle + math.pi) % (2 * math.pi) - math.pi)


def _first_guess(chain: Chain, place: Array, seen: Flags) -> Array:
    """Guess the unknowns (frames, n) from a line through the markers, after filling gaps and removing single jumps."""
    frames = np.arange(len(place))
    filtered = np.zeros_like(place)
    for m in range(place.shape[1]):
        own = seen[:, m]
        for axis in range(2):
            filled = np.interp(frames, frames[own], place[own, m, axis]) if own.any() else np.full(len(frames), np.nan)
            window = np.lib.stride_tricks.sliding_window_view(np.pad(filled, 2, mode="edge"), 5)
            filtered[:, m, axis] = np.median(window, axis=1)
    distance = chain.along.sum(axis=1)  # from the nose
    order = [m for m in np.argsort(distance, kind="stable") if seen[:, m].any()]
    order = [m for k, m in enumerate(order) if k == 0 or distance[m] > distance[order[k - 1]] + 1e-12]
    ends = np.concatenate([[0.0], np.cumsum(chain.length)])
    joints = np.stack([_interpolated(ends, distance[order], filtered[:, order, axis]) for axis in range(2)], axis=-1)
    step = np.diff(joints, axis=1)
    heading = np.unwrap(np.arctan2(step[..., 1], step[..., 0]), axis=1)
    matrix = np.column_stack([np.ones(len(chain.length)), chain.share])
    angles = np.linalg.lstsq(matrix, heading.T, rcond=None)[0].T
    return np.column_stack([joints[:, 0], angles])


def _interpolated(at: Array, known: Array, values: Array) -> Array:
    """Return values (frames, known) interpolated linearly at positions `at`, and extrapolated beyond the ends."""
    index = np.clip(np.searchsorted(known, at) - 1, 0, len(known) - 2)
    fraction = (at - known[index]) / (known[index + 1] - known[index])
    return np.asarray(values[:, index] * (1 - fraction) + values[:, index + 1] * fraction)


def _estimated_noise(chain: Chain, z: Array, target: Array, seen: Flags) -> float:
    """Estimate the markers' noise [m] from their median distance from the chain, corrected for the fitted unknowns.

    Frames with no more coordinates than unknowns are left out, since the chain then passes through the markers.
    """
    redundant = 2 * seen.sum(axis=1) > z.shape[1]
    used = redundant if redundant.any() else np.ones(len(z), dtype=bool)
    distance = np.linalg.norm(chain(z[used])[0] - target[used], axis=2)[seen[used]]
    share = 1 - z.shape[1] * used.sum() / max(2 * len(distance), 1)
    return max(float(np.median(distance)) / MEDIAN_NORM / math.sqrt(max(share, 0.1)), MIN_NOISE)


def _tukey(t: Array) -> Array:
    """Return Tukey's biweight of distances `t`, in units of the noise."""
    return np.asarray(np.where(t < TUKEY, (1 - np.minimum(t / TUKEY, 1.0) ** 2) ** 2, 0.0))


def _losses(t: Array, tukey: bool) -> tuple[Array, Array]:
    """Return the robust loss of distances `t`, in units of the noise, and its weight in least squares."""
    if tukey:
        return TUKEY**2 / 6 * (1 - (1 - np.minimum(t / TUKEY, 1.0) ** 2) ** 3), _tukey(t)
    return np.where(t < HUBER, t**2 / 2, HUBER * (t - HUBER / 2)), np.minimum(1.0, HUBER / np.maximum(t, 1e-12))


def _minimize(
    chain: Chain, target: Array, weight: Array, z: Array, noise: float, *, tukey: bool
) -> tuple[Array, Array]:
    """Minimize the robust loss of every frame from z (frames, n); return unknowns and losses (frames,)."""
    size, n = float(chain.length.sum()), z.shape[1]
    unit = np.append([size, size], np.ones(n - 2))

    def terms(z: Array, frames: Flags) -> tuple[Array, Array, Array]:
        """Return the gradient, the Gauss-Newton matrix and the loss of frames."""
        place, slope = chain(z)
        residual = place - target[frames]
        loss, robust = _losses(np.sqrt(weight[frames]) * np.linalg.norm(residual, axis=2) / noise, tukey)
        root = np.repeat(np.sqrt(weight[frames] * robust), 2, axis=1)
        rows = root[..., np.newaxis] * (slope * unit).reshape(len(z), -1, n)
        gradient = (rows.transpose(0, 2, 1) @ (root * residual.reshape(len(z), -1))[..., np.newaxis])[..., 0]
        return gradient, rows.transpose(0, 2, 1) @ rows, (loss * (weight[frames] > 0)).sum(axis=1)

    z, damping, active = z.copy(), np.full(len(z), 1e-3), np.ones(len(z), dtype=bool)
    gradient, matrix, cost = terms(z, active)
    for _ in range(ITERATIONS):
        diagonal = np.einsum("fii->fi", matrix[active])
        floor = RIDGE * np.maximum(diagonal.max(axis=1, keepdims=True), 1e-300)
        ridge = damping[active, np.newaxis] * diagonal + floor
        system = matrix[active] + ridge[..., np.newaxis] * np.eye(n)
        step = -np.linalg.solve(system, gradient[active, :, np.newaxis])[..., 0]
        trial = z[active] + unit * step
        new = terms(trial, active)
        better = new[2] <= cost[active]
        frames = np.flatnonzero(active)[better]
        z[frames] = trial[better]
        gradient[frames], matrix[frames], cost[frames] = (part[better] for part in new)
        damping[active] = np.clip(np.where(better, damping[active] / 5, damping[active] * 10), 1e-9, MAX_DAMPING)
        settled = np.abs(step).max(axis=1) < MIN_STEP
        active[active] = ~settled & (damping[active] < MAX_DAMPING)
        if not active.any():
            break
    return z, cost


def _start_again(chain: Chain, target: Array, weight: Array, z: Array, cost: Array, noise: float) -> Array:
    """Fit frames with a large loss again, starting from neighbors with a small loss; keep the better fit."""
    limit = 3 * float(np.median(cost)) + 1.0
    good, bad = np.flatnonzero(cost <= limit), np.flatnonzero(cost > limit)
    if not len(good) or not len(bad):
        return z
    filtered = z[good].copy()
    filtered[:, 2] = np.unwrap(filtered[:, 2])
    start = np.stack([np.interp(bad, good, filtered[:, k]) for k in range(z.shape[1])], axis=1)
    retried, new_cost = _minimize(chain, target[bad], weight[bad], start, noise, tukey=True)
    z = z.copy()
    z[bad] = np.where((new_cost < cost[bad])[:, np.newaxis], retried, z[bad])
    return z


def _inverse(matrix: Array, size: float) -> Array:
    """Invert symmetric matrices (frames, n, n); directions without information get a very large variance."""
    unit = np.append([1.0, 1.0], np.full(matrix.shape[1] - 2, 1 / size))
    scaled = matrix * unit[:, np.newaxis] * unit
    value, vector = np.linalg.eigh(scaled)
    floor = np.maximum(1e-12 * value[:, -1:], 1e-300)
    inverse = np.einsum("fik,fk,fjk->fij", vector, 1 / np.maximum(value, floor), vector)
    return np.asarray(inverse * unit[:, np.newaxis] * unit)
