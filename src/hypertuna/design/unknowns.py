"""Unknown coefficients of a design: fitted ones with their covariance, and others with the uncertainty of handbooks."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.identification.coefficients import LOG_DECADES, Free, free, to_scale
from hypertuna.identification.fixed import fixed_coefficients
from hypertuna.identification.names import NUISANCES, Names, prior_factor


@dataclass(frozen=True)
class Unknowns:
    """Unknown coefficients of a robot with their normal prior, each on a logarithmic or natural scale."""

    robot: Robot
    free: tuple[Free, ...]
    mean: Array  # (n,) prior mean of the scaled coefficients
    covariance: Array  # (n, n) prior covariance of the scaled coefficients

    @property
    def sd(self) -> Array:
        """Standard deviations (n,) of the prior: of logarithms, or [SI] for coefficients on a natural scale."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(one.name for one in self.free)


def unknowns_of(robot: Robot, prior: Mapping[str, float] | None = None) -> Unknowns:
    """Return the unknowns of a robot: the coefficients of its [fit], and all others that handbooks leave uncertain.

    prior: names of the unknowns to take instead, each with the factor by which the robot's value may be off.
    """
    if prior is not None:
        frees = free(robot, list(prior), prior=prior)
        mean, sd = np.log([c.prior for c in frees if c.prior is not None]).T
        return Unknowns(robot, frees, mean, np.diag(sd**2))
    fitted, fit_covariance = _fitted(robot)
    by_factor = [(c, prior_factor(robot, c.column)) for c in fixed_coefficients(robot, fitted) if c.common]
    others = {replace(c, scale="log", lower=c.upper * 10.0**-LOG_DECADES): factor for c, factor in by_factor if factor}
    frees = (*fitted, *others)
    if not frees:
        rule, fix = "must have coefficients that are not known", "give --prior NAME=FACTOR"
        raise InputError(rule, file=robot.file, key="unknowns", fix=fix)
    covariance = np.zeros((len(frees), len(frees)))
    covariance[: len(fitted), : len(fitted)] = fit_covariance
    covariance[range(len(fitted), len(frees)), range(len(fitted), len(frees))] = [
        math.log(factor) ** 2 for factor in others.values()
    ]
    return Unknowns(robot, frees, to_scale(frees, [c.start for c in frees]), covariance)


def _fitted(robot: Robot) -> tuple[Sequence[Free], Array]:
    """Return the coefficients of the robot's table [fit], with the fitted values as start, and their covariance."""
    fit = robot.fit
    if fit is None:
        return (), np.zeros((0, 0))
    indices = [k for k, name in enumerate(fit.names) if name.partition("[")[0] not in NUISANCES]
    for k in indices:
        Names(robot).resolve(fit.names[k], "fit.names")
    frees = [Free(fit.names[k], fit.lower[k], fit.upper[k], fit.value[k], fit.scale[k]) for k in indices]
    return tuple(frees), np.array(fit.covariance)[np.ix_(indices, indices)]
