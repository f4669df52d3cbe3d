"""Sequential Monte Carlo: points drawn from the prior, then moved until they sample the posterior with equal weights.

The likelihood is raised to powers that grow from 0 to 1 (tempering). At each power, points are resampled by their
weights, and moved by differences of other points (differential evolution, ter Braak 2006).
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hypertuna.arrays import Array
from hypertuna.characterization.designs import Design, Designs
from hypertuna.errors import InputError

KEPT = 0.5  # part of the points that must stay effective when the power rises
SWEEPS, MOVED = 12, 3.0  # at each power: most moves tried for each point, and accepted moves for each that suffice
SPREAD = 1e-3  # standard deviation of the noise added to each move
MAX_DRAWS = 100  # most draws from the prior for each point wanted


@dataclass(frozen=True)
class Population:
    """Points of equal weight from the posterior of designs, and the draws from the prior."""

    points: Array  # (count, n + s), points of the box of `Designs`
    members: tuple[Design, ...]  # the designs at the points
    drawn: tuple[Design, ...]  # the first `count` draws from the prior, including excluded designs
    tried: int  # number of draws from the prior
    evaluations: int  # number of designs computed, for draws and moves
    powers: tuple[float, ...]  # powers of the likelihood, from 0 to 1


def populate(
    space: Designs, count: int, *, seed: int = 0, progress: Callable[[int, int], None] | None = None
) -> Population:
    """Return `count` points of a space of designs, sampled from the posterior given the bench."""
    rng, unknown_count, solved_count = np.random.default_rng(seed), len(space.free), len(space.solved)
    drawn: list[Design] = []
    accepted: list[tuple[Array, Design]] = []
    while len(accepted) < count:
        if len(drawn) >= MAX_DRAWS * count:
            raise _too_few(drawn, len(accepted))
        point = np.append(rng.random(unknown_count), rng.standard_normal(solved_count))
        drawn.append(space.at(point))
        if not drawn[-1].excluded:
            accepted.append((point, drawn[-1]))
        if progress is not None:
            progress(max(len(accepted), len(drawn) // MAX_DRAWS), 2 * count)
    points, members = np.array([point for point, _ in accepted]), [design for _, design in accepted]
    evaluations, power, powers = len(drawn), 0.0, [0.0]
    log_weight = np.array([design.weight for design in members])
    while True:
        fit = np.array([design.fit for design in members])
        step = _step(log_weight, fit, 1 - power)
        power, weights = power + step, np.exp(log_weight + step * fit - (log_weight + step * fit).max())
        chosen = np.searchsorted(np.cumsum(weights) / weights.sum(), (rng.random() + np.arange(count)) / count)
        points, members = points[chosen], [members[k] for k in np.minimum(chosen, count - 1)]
        for part, tried in _moves(space, points, members, power, rng):
            evaluations += tried
            if progress is not None:
                progress(count + int(count * (power - (1 - part) * step)), 2 * count)
        log_weight = np.zeros(count)
        powers.append(power)
        if power >= 1:
            return Population(points, tuple(members), tuple(drawn[:count]), len(drawn), evaluations, tuple(powers))


def _too_few(drawn: list[Design], met: int) -> InputError:
    """Return the error that too few designs meet the bench, with the reasons that exclude designs."""
    reasons = Counter(design.excluded for design in drawn if design.excluded).most_common()
    texts = ", ".join(f"{count} have {reason}" for reason, count in reasons)
    rule, fix = f"must be met by one in {MAX_DRAWS} designs within the bounds", "check the file, or give wider --bounds"
    return InputError(rule, key="bench", value=f"met by {met} of {len(drawn)}: {texts}", fix=fix)


def _step(weight: Array, fit: Array, rest: float) -> float:
    """Return the largest increase of the power, at most `rest`, that keeps enough points effective."""

    def effective_fraction(step: float) -> float:
        weights = np.exp(weight + step * fit - (weight + step * fit).max())
        return float(weights.sum() ** 2 / (weights**2).sum()) / len(weights)

    needed = min(KEPT, 0.9 * effective_fraction(0.0))
    if effective_fraction(rest) >= needed:
        return rest
    low, high = 0.0, rest
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if effective_fraction(middle) >= needed else (low, middle)
    return low


def _moves(
    space: Designs, points: Array, members: list[Design], power: float, rng: np.random.Generator
) -> Iterator[tuple[float, int]]:
    """Move points (count, n + s) and their designs in place by Metropolis steps.

    After each sweep over all points, yields the part of the work that is done, and the number of designs computed.
    """
    (count, size), uniform = points.shape, len(space.free)
    scale, moved_count = 2.38 / np.sqrt(2 * size), 0

    def density(point: Array, proposal: Design) -> float:
        return proposal.weight + power * proposal.fit - 0.5 * float(point[uniform:] @ point[uniform:])

    for sweep in range(1, SWEEPS + 1):
        accepted = 0
        for half in np.array_split(rng.permutation(count), 2):  # each moves by differences of the others
            others = np.setdiff1d(np.arange(count), half)
            for k in half.tolist():
                a, b = points[rng.choice(others, 2, replace=False)]
                new = points[k] + scale * (a - b) + SPREAD * rng.standard_normal(size)
                new[:uniform] = np.abs((new[:uniform] + 1) % 2 - 1)  # reflected at 0 and 1
                proposal = space.at(new)
                if proposal.excluded or np.log(rng.random()) >= density(new, proposal) - density(points[k], members[k]):
                    continue
                points[k], members[k], accepted = new, proposal, accepted + 1
        moved_count += accepted
        yield max(sweep / SWEEPS, min(1.0, moved_count / (MOVED * count))), count
        scale *= float(np.exp(accepted / count - 0.25))
        if moved_count >= MOVED * count:
            return
