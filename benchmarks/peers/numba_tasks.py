"""Gait search and identification as one writes them with numba: swim every gait from rest until it has settled, search
by a particle swarm's textbook loop, fit by SciPy's least squares with finite differences.

One compiled function swims one gait, shape table and all, with the coefficients as arguments.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from peers.fish import STEPS, Array, Fish, Gaits

compiled = numba.njit(fastmath=True, error_model="numpy")  # decorator that compiles a function
SETTLED = 1e-9  # relative change of speed per beat, small enough for finite differences
MAX_BEATS = 600  # after which a swim counts as not settled


@compiled
def _tabulate(length, com, mass, inertia, share, amplitude, phase, omega, table):  # type: ignore[no-untyped-def]
    """Fill table [2 STEPS, 6 n + 6] with the moving shape, as `peers.fish.shape` does."""
    n, groups, total = len(length), len(amplitude), mass.sum()
    for q in range(len(table)):
        row, clock = table[q], np.pi * q / STEPS
        theta = turn = fx = fy = wx = wy = gx = gy = bx = by = spin = moment = 0.0
        for i in range(n):
            for g in range(groups):
                theta += share[i, g] * amplitude[g] * np.sin(clock - phase[g])
                turn += share[i, g] * amplitude[g] * omega * np.cos(clock - phase[g])
            c, s = np.cos(theta), np.sin(theta)
            x, y = fx + com[i] * c, fy + com[i] * s
            vx, vy = wx - com[i] * s * turn, wy + com[i] * c * turn
            row[6 * i], row[6 * i + 1] = c, s
            row[6 * i + 2], row[6 * i + 3] = s * x - c * y, c * x + s * y
            row[6 * i + 4], row[6 * i + 5] = c * vx + s * vy, c * vy - s * vx
            gx, gy = gx + mass[i] * x / total, gy + mass[i] * y / total
            bx, by = bx + mass[i] * vx, by + mass[i] * vy
            spin += mass[i] * (x * vy - y * vx) + inertia[i] * turn
            moment += mass[i] * (x * x + y * y) + inertia[i]
            fx, fy = fx + length[i] * c, fy + length[i] * s
            wx, wy = wx - length[i] * s * turn, wy + length[i] * c * turn
        body = 6 * n
        row[body], row[body + 1], row[body + 2] = gx, gy, 1 / (moment - total * (gx * gx + gy * gy))
        row[body + 3], row[body + 4], row[body + 5] = bx, by, spin


@compiled
def _rate(state, t, k_t, k_n, total, out):  # type: ignore[no-untyped-def]
    """Write the rate of momentum and pose to `out`; state [6]: p_x, p_y, h, x, y, heading."""
    n = len(k_t)
    body = 6 * n
    x, y, h = state[0], state[1], state[2]
    px, py = x - t[body + 3], y - t[body + 4]
    r = t[body + 2] * (h - t[body + 5] - t[body] * py + t[body + 1] * px)
    u, v = px / total + t[body + 1] * r, py / total - t[body] * r
    fx, fy, torque = r * y, -r * x, v * x - u * y
    for i in range(n):
        c, s, ht, hn = t[6 * i], t[6 * i + 1], t[6 * i + 2], t[6 * i + 3]
        vt = c * u + s * v + ht * r + t[6 * i + 4]
        vn = c * v - s * u + hn * r + t[6 * i + 5]
        ft, fn = k_t[i] * vt * abs(vt), k_n[i] * vn * abs(vn)
        fx -= c * ft - s * fn
        fy -= s * ft + c * fn
        torque -= ht * ft + hn * fn
    out[0], out[1], out[2] = fx, fy, torque
    c, s = np.cos(state[5]), np.sin(state[5])
    out[3], out[4], out[5] = c * u - s * v, s * u + c * v, r


@compiled
def _swim(length, com, mass, inertia, k_t, k_n, share, frequency, amplitude, phase):  # type: ignore[no-untyped-def]
    """Return the settled speed [K] of K gaits, from rest."""
    total, n = mass.sum(), len(length)
    speed = np.empty(len(frequency))
    table = np.empty((2 * STEPS, 6 * n + 6))
    state, y = np.zeros(6), np.empty(6)
    k1, k2, k3, k4 = np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    for gait in range(len(frequency)):
        _tabulate(length, com, mass, inertia, share, amplitude[gait], phase[gait], 2 * np.pi * frequency[gait], table)
        dt, last = 1 / (STEPS * frequency[gait]), 0.0
        state[:3] = 0
        for _ in range(MAX_BEATS):
            state[3:] = 0
            for step in range(STEPS):
                _rate(state, table[2 * step], k_t, k_n, total, k1)
                for j in range(6):
                    y[j] = state[j] + dt / 2 * k1[j]
                _rate(y, table[2 * step + 1], k_t, k_n, total, k2)
                for j in range(6):
                    y[j] = state[j] + dt / 2 * k2[j]
                _rate(y, table[2 * step + 1], k_t, k_n, total, k3)
                for j in range(6):
                    y[j] = state[j] + dt * k3[j]
                _rate(y, table[(2 * step + 2) % (2 * STEPS)], k_t, k_n, total, k4)
                for j in range(6):
                    state[j] += dt / 6 * (k1[j] + 2 * (k2[j] + k3[j]) + k4[j])
            now = np.hypot(state[3], state[4]) * frequency[gait]
            if abs(now - last) < SETTLED * now:
                break
            last = now
        speed[gait] = now
    return speed


def swim(fish: Fish, gaits: Gaits) -> Array:
    """Return the settled speed [K], m/s."""
    constants = (fish.length, fish.com, fish.moving_mass, fish.inertia, fish.k_t, fish.k_n, fish.share)
    return np.asarray(_swim(*constants, gaits.frequency, gaits.amplitude, gaits.phase))


def particle_swarm(fish: Fish, lower: Array, upper: Array, *, particles: int, iterations: int, seed: int) -> float:
    """Return the largest speed that a swarm finds over frequency, two amplitudes and the phase of the second group."""

    def fitness(x: Array) -> Array:
        return swim(fish, Gaits(x[:, 0].copy(), x[:, 1:3].copy(), np.column_stack([np.zeros(len(x)), x[:, 3]])))

    rng, w, c1, c2 = np.random.default_rng(seed), 0.9, 2.0, 2.0
    x = rng.uniform(lower, upper, size=(particles, len(lower)))
    v = rng.uniform(-1, 1, size=x.shape) * 0.2 * (upper - lower)
    best_x, best = x.copy(), fitness(x)
    for step in range(1, iterations):
        leader = best_x[np.argmax(best)]
        r1, r2 = rng.uniform(size=(2, *x.shape))
        v = (w - 0.5 * step / iterations) * v + c1 * r1 * (best_x - x) + c2 * r2 * (leader - x)
        x = np.clip(x + v, lower, upper)
        found = fitness(x)
        better = found > best
        best_x[better], best[better] = x[better], found[better]
    return float(best.max())


def fit(refit: Callable[[Array], Fish], gaits: Gaits, measured: Array, start: Array, upper: Array) -> OptimizeResult:
    """Fit by least squares of relative speed errors, with SciPy's forward differences as the Jacobian."""

    def residuals(values: Array) -> Array:
        return swim(refit(values), gaits) / measured - 1

    return least_squares(residuals, start, bounds=(0, upper), x_scale=upper, max_nfev=25)
