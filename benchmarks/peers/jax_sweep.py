"""The sweep in JAX: double, one CPU thread, every gait swum for a number of beats. Three programs of the same model:

- `direct`, as one writes it from the paper: shape and mass matrix at every evaluation, one gait,
  `lax.scan` over the steps, `jit(vmap(...))`;
- `tabled`: as hypertuna does it, momentum as the state and the shape tabulated beforehand, again `jit(vmap(...))`;
- `fused`: the same with the gaits as an axis of every array and the sums over links in one variadic `lax.reduce`.
  XLA otherwise computes a step once for each of its three results, since it does not merge loops on the CPU; this is
  the fastest that we found, after reading the compiled program.

XLA's flags are those that all three ran fastest with.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false --xla_cpu_enable_fast_math=true"  # before JAX is imported

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from peers.fish import STEPS, Array, Fish, Gaits, beat_speed, clock, shape, twist

jax.config.update("jax_enable_x64", True)

Sweep = Callable[[], Array]


def rk4(rate: Callable[..., Any], y: Any, start: Any, middle: Any, end: Any, dt: Any) -> Any:
    """Return y after one step; rate(y, node) is called with the nodes at the step's start, middle and end."""

    def ahead(h: Any, k: Any) -> Any:
        return jax.tree.map(lambda a, b: a + h * b, y, k)

    k1 = rate(y, start)
    k2 = rate(ahead(dt / 2, k1), middle)
    k3 = rate(ahead(dt / 2, k2), middle)
    k4 = rate(ahead(dt, k3), end)
    return jax.tree.map(lambda y, a, b, c, d: y + dt / 6 * (a + 2 * (b + c) + d), y, k1, k2, k3, k4)


def beats_of(step: Callable[..., Any], twist: Callable[..., Any], start: Any, beats: int) -> Array:
    """Return the twists [STEPS, 3, ...] of the last of `beats` beats; step(y, k), twist(y, k): at step k of a beat."""
    y = lax.fori_loop(0, (beats - 1) * STEPS, lambda i, y: step(y, i % STEPS), start)
    twists = lax.scan(lambda y, k: (step(y, k), twist(y, k)), y, jnp.arange(STEPS))[1]
    return twists  # type: ignore[no-any-return]


def direct(fish: Fish, gaits: Gaits, beats: int) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return program and arguments: the paper's equations, solved for the acceleration."""
    angles, m, total_inertia = np.cumsum(fish.share, axis=0), fish.moving_mass, fish.inertia.sum()

    def along(front: Any) -> Any:
        return jnp.cumsum(fish.length * front) - (fish.length - fish.com) * front

    def acceleration(xi: Any, t: Any, gait: Any) -> Any:
        frequency, amplitude, phase = gait
        w = 2 * jnp.pi * frequency
        alpha = amplitude * jnp.sin(w * t - phase)
        theta, turn, bend = angles @ alpha, angles @ (amplitude * w * jnp.cos(w * t - phase)), angles @ (-w * w * alpha)
        c, s = jnp.cos(theta), jnp.sin(theta)
        (rx, ry), (wx, wy) = (along(c), along(s)), (along(-s * turn), along(c * turn))
        ax, ay = along(-s * bend - c * turn**2), along(c * bend - s * turn**2)
        u, v, r = xi
        vx, vy = u - r * ry + wx, v + r * rx + wy
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ft, fn = fish.k_t * vt * abs(vt), fish.k_n * vn * abs(vn)
        fx = -c * ft + s * fn - m * (ax - 2 * r * wy - r * r * rx - r * v)
        fy = -s * ft - c * fn - m * (ay + 2 * r * wx - r * r * ry + r * u)
        px, py, torque = fx.sum(), fy.sum(), (rx * fy - ry * fx - fish.inertia * bend).sum()
        # The mass matrix [[M, 0, -M y], [0, M, M x], [-M y, M x, J]], solved by hand: faster than jnp.linalg.solve.
        M, J = m.sum(), (m * (rx**2 + ry**2)).sum() + total_inertia
        x, y = (m * rx).sum() / M, (m * ry).sum() / M
        dr = (torque + y * px - x * py) / (J - M * (x**2 + y**2))
        return jnp.stack([px / M + y * dr, py / M - x * dr, dr])

    def one(start: Any, *gait: Any) -> Any:
        dt = 1 / (gait[0] * STEPS)

        def step(xi: Any, k: Any) -> Any:
            rate = lambda xi, t: acceleration(xi, t, gait)  # noqa: E731
            return rk4(rate, xi, k * dt, (k + 0.5) * dt, (k + 1) * dt, dt)

        return beats_of(step, lambda xi, k: xi, start, beats)

    no_momentum = twist(fish, np.zeros(3), shape(fish, gaits, clock()[:1])[1][0])
    return jax.vmap(one, out_axes=2), (no_momentum, gaits.frequency, gaits.amplitude, gaits.phase)


def _momentum_rate(fish: Fish, total: Callable[..., Any], spread: Callable[..., Any]) -> tuple[Any, Any]:
    """Return functions for twist and momentum rate from rows of the table: link [6][..., n], body [6][...]."""
    per_mass = 1 / fish.moving_mass.sum()

    def twist(P: Any, body: Any) -> Any:
        gx, gy, mobility, bx, by, bh = body
        px, py = P[0] - bx, P[1] - by
        r = mobility * (P[2] - bh - gx * py + gy * px)
        return px * per_mass + gy * r, py * per_mass - gx * r, r

    def rate(P: Any, row: Any) -> Any:
        (c, s, ht, hn, at, an), body = row
        u, v, r = twist(P, body)
        U, V, R = spread(u), spread(v), spread(r)
        vt, vn = c * U + s * V + ht * R + at, c * V - s * U + hn * R + an
        ft, fn = fish.k_t * vt * abs(vt), fish.k_n * vn * abs(vn)
        fx, fy, torque = total(c * ft - s * fn, s * ft + c * fn, ht * ft + hn * fn)
        return r * P[1] - fx, -r * P[0] - fy, v * P[0] - u * P[1] - torque

    return twist, rate


def _swim_table(twist: Any, rate: Any, link: Any, body: Any, dt: Any, beats: int) -> Any:
    """Swim from rest with tables link and body, each 6 arrays [2 STEPS, ...]; return the twists of the last beat."""

    def row(q: Any) -> Any:
        q = q % (2 * STEPS)
        return tuple(x[q] for x in link), tuple(x[q] for x in body)

    def step(P: Any, k: Any) -> Any:
        return rk4(rate, P, row(2 * k), row(2 * k + 1), row(2 * k + 2), dt)

    start = tuple(jnp.zeros_like(x[0]) for x in body[3:])  # at rest: no momentum
    return beats_of(step, lambda P, k: jnp.stack(twist(P, row(2 * k)[1])), start, beats)


def tabled(fish: Fish, gaits: Gaits, beats: int) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return program and arguments: momentum as the state, and a table of the shape."""
    twists, rate = _momentum_rate(fish, lambda *sums: tuple(x.sum() for x in sums), lambda x: x)
    one = lambda link, body, dt: _swim_table(twists, rate, link, body, dt, beats)  # noqa: E731
    link, body, dt = _columns(fish, gaits)
    link, body = jax.tree.map(lambda a: a.swapaxes(0, 1).copy(), (link, body))  # gaits first: half the time
    return jax.vmap(one, out_axes=2), (link, body, dt)


def fused(fish: Fish, gaits: Gaits, beats: int) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return program and arguments: `tabled`, arranged so that XLA computes nothing twice."""

    def total(*sums: Any) -> Any:
        return lax.reduce(sums, (0.0,) * 3, lambda x, y: tuple(a + b for a, b in zip(x, y, strict=True)), (1,))

    twists, rate = _momentum_rate(fish, total, lambda x: x[:, None])
    return (lambda link, body, dt: _swim_table(twists, rate, link, body, dt, beats)), _columns(fish, gaits)


def _columns(fish: Fish, gaits: Gaits) -> tuple[Any, ...]:
    link, body = (tuple(np.ascontiguousarray(a[..., j]) for j in range(6)) for a in shape(fish, gaits, clock()))
    return link, body, 1 / (gaits.frequency * STEPS)


PROGRAMS = {"direct": direct, "tabled": tabled, "fused": fused}  # ways to compute a swim, by name


def compile_sweep(program: str, fish: Fish, gaits: Gaits, beats: int) -> Sweep:
    """Compile a program; return a function that swims all gaits and returns their speeds [K], m/s."""
    function, arguments = PROGRAMS[program](fish, gaits, beats)
    compiled = jax.jit(function).lower(*arguments).compile()
    on_device = jax.device_put(arguments)

    def sweep() -> Array:
        twists = np.asarray(compiled(*on_device))
        return beat_speed(np.concatenate([twists, twists[:1]]), gaits.frequency)

    return sweep
