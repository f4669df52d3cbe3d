"""The model in numba: double, fastmath, the robot's constants frozen into the machine code.

The shape is tabulated once per gait (it depends on the beat's phase alone), as hypertuna does. Two orders of loops:
one gait at a time, links innermost; or gaits in step, the loop over gaits innermost, which LLVM vectorizes from 16
gaits on.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np

from peers.fish import STEPS, Array, Fish, Gaits, beat_speed, clock, shape, twist

Rate = Callable[[Array, Array, Array, Array], None]  # writes the state's rate of change
Beats = Callable[[Array, Array, Array, int], None]  # advances the state by beats
compiled = numba.njit(fastmath=True, error_model="numpy")  # decorator that compiles a function


def compile_rate(fish: Fish) -> Rate:
    """Compile the right-hand side `rate(state, row, out, xi)` of one gait.

    state, out [3, 1]: momentum and its rate; row [6 n + 6, 1]: the shape; xi: not used.
    """
    n, k_t, k_n = fish.links, tuple(fish.k_t.tolist()), tuple(fish.k_n.tolist())
    per_mass = 1 / float(fish.moving_mass.sum())

    @compiled
    def rate(state, row, out, xi):  # type: ignore[no-untyped-def]
        t, body = row[:, 0], 6 * n
        x, y, h = state[0, 0], state[1, 0], state[2, 0]
        px, py = x - t[body + 3], y - t[body + 4]
        r = t[body + 2] * (h - t[body + 5] - t[body] * py + t[body + 1] * px)
        u, v = px * per_mass + t[body + 1] * r, py * per_mass - t[body] * r
        fx, fy, torque = r * y, -r * x, v * x - u * y
        for i in range(n):
            c, s, ht, hn = t[6 * i], t[6 * i + 1], t[6 * i + 2], t[6 * i + 3]
            vt = c * u + s * v + ht * r + t[6 * i + 4]
            vn = c * v - s * u + hn * r + t[6 * i + 5]
            ft, fn = k_t[i] * vt * abs(vt), k_n[i] * vn * abs(vn)
            fx -= c * ft - s * fn
            fy -= s * ft + c * fn
            torque -= ht * ft + hn * fn
        out[0, 0], out[1, 0], out[2, 0] = fx, fy, torque

    return rate


def compile_rate_of_lanes(fish: Fish, lanes: int) -> Rate:
    """Compile the right-hand side `rate(state, row, out, xi)` of `lanes` gaits.

    state, out, xi [3, lanes]: momentum, its rate, scratch for the twist; row [6 n + 6, lanes]: the shape.
    """
    n, k_t, k_n = fish.links, tuple(fish.k_t.tolist()), tuple(fish.k_n.tolist())
    per_mass = 1 / float(fish.moving_mass.sum())

    @compiled
    def rate(state, row, out, xi):  # type: ignore[no-untyped-def]
        body = 6 * n
        for k in range(lanes):
            gx, gy = row[body, k], row[body + 1, k]
            px, py = state[0, k] - row[body + 3, k], state[1, k] - row[body + 4, k]
            r = row[body + 2, k] * (state[2, k] - row[body + 5, k] - gx * py + gy * px)
            u, v = px * per_mass + gy * r, py * per_mass - gx * r
            xi[0, k], xi[1, k], xi[2, k] = u, v, r
            out[0, k] = r * state[1, k]
            out[1, k] = -r * state[0, k]
            out[2, k] = v * state[0, k] - u * state[1, k]
        for i in range(n):
            for k in range(lanes):
                c, s, ht, hn = row[6 * i, k], row[6 * i + 1, k], row[6 * i + 2, k], row[6 * i + 3, k]
                vt = c * xi[0, k] + s * xi[1, k] + ht * xi[2, k] + row[6 * i + 4, k]
                vn = c * xi[1, k] - s * xi[0, k] + hn * xi[2, k] + row[6 * i + 5, k]
                ft, fn = k_t[i] * vt * abs(vt), k_n[i] * vn * abs(vn)
                out[0, k] -= c * ft - s * fn
                out[1, k] -= s * ft + c * fn
                out[2, k] -= ht * ft + hn * fn

    return rate


def compile_beats(fish: Fish, lanes: int) -> Beats:
    """Compile `beats(state, table, dt, steps)`: RK4 steps from phase 0 on, in place.

    state [3, lanes]: momentum; table [2 STEPS, 6 n + 6, lanes]; dt [lanes]: time step, s.
    """
    rate = compile_rate(fish) if lanes == 1 else compile_rate_of_lanes(fish, lanes)

    @compiled
    def beats(state, table, dt, steps):  # type: ignore[no-untyped-def]
        nodes = table.shape[0]
        k1, k2, k3 = np.empty((3, lanes)), np.empty((3, lanes)), np.empty((3, lanes))
        k4, y, xi = np.empty((3, lanes)), np.empty((3, lanes)), np.empty((3, lanes))
        for step in range(steps):
            start, middle, end = 2 * step % nodes, 2 * step % nodes + 1, (2 * step + 2) % nodes
            rate(state, table[start], k1, xi)
            for j in range(3):
                for k in range(lanes):
                    y[j, k] = state[j, k] + dt[k] / 2 * k1[j, k]
            rate(y, table[middle], k2, xi)
            for j in range(3):
                for k in range(lanes):
                    y[j, k] = state[j, k] + dt[k] / 2 * k2[j, k]
            rate(y, table[middle], k3, xi)
            for j in range(3):
                for k in range(lanes):
                    y[j, k] = state[j, k] + dt[k] * k3[j, k]
            rate(y, table[end], k4, xi)
            for j in range(3):
                for k in range(lanes):
                    state[j, k] += dt[k] / 6 * (k1[j, k] + 2 * (k2[j, k] + k3[j, k]) + k4[j, k])

    return beats


def prepare(fish: Fish, gaits: Gaits) -> tuple[Array, Array, Array]:
    """Return the state at rest [3, K], the table [2 STEPS, 6 n + 6, K] and the time step [K] of K gaits."""
    link, body = shape(fish, gaits, clock())
    rows = np.concatenate([link.reshape(*link.shape[:2], -1), body], axis=-1)
    table = np.ascontiguousarray(rows.transpose(0, 2, 1))
    return np.zeros((3, len(gaits))), table, 1 / (STEPS * gaits.frequency)


def swim(fish: Fish, gaits: Gaits, beats: int) -> Array:
    """Return the speed [K] over the last of `beats` beats from rest, m/s."""
    advance = compile_beats(fish, len(gaits))
    state, table, dt = prepare(fish, gaits)
    advance(state, table, dt, (beats - 1) * STEPS)
    body = table[:, 6 * fish.links :].transpose(0, 2, 1)
    twists = [twist(fish, state.T, body[0])]
    for step in range(STEPS):  # one step at a time: the table is rolled so that this step comes first
        advance(state, np.roll(table, -2 * step, axis=0)[:3].copy(), dt, 1)
        twists.append(twist(fish, state.T, body[(2 * step + 2) % len(body)]))
    return beat_speed(np.stack(twists, axis=0).transpose(0, 2, 1), gaits.frequency)
