/// The settled beat: the motion that repeats itself, computed by Newton's method instead of by waiting.
///
/// One beat maps the momentum at its start to the momentum at its end, P -> Phi(P). Dual numbers give the exact
/// derivative of that map (the monodromy matrix), and Newton solves Phi(P) = P.
#pragma once

#include <limits>

#include "hypertuna/swimming/stepping.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A matrix by its rows.
template <class S>
struct Matrix3 {
    S a[3][3];
};

/// Solve A x = b by Cramer's rule.
template <class S>
Planar<S> solve(const Matrix3<S>& m, const Planar<S>& b) {
    const auto& a = m.a;
    const S c0 = a[1][1] * a[2][2] - a[1][2] * a[2][1];
    const S c1 = a[1][2] * a[2][0] - a[1][0] * a[2][2];
    const S c2 = a[1][0] * a[2][1] - a[1][1] * a[2][0];
    const S scale = S(1) / (a[0][0] * c0 + a[0][1] * c1 + a[0][2] * c2);
    return {
        scale *
            (c0 * b.x + (a[0][2] * a[2][1] - a[0][1] * a[2][2]) * b.y + (a[0][1] * a[1][2] - a[0][2] * a[1][1]) * b.z),
        scale *
            (c1 * b.x + (a[0][0] * a[2][2] - a[0][2] * a[2][0]) * b.y + (a[0][2] * a[1][0] - a[0][0] * a[1][2]) * b.z),
        scale *
            (c2 * b.x + (a[0][1] * a[2][0] - a[0][0] * a[2][1]) * b.y + (a[0][0] * a[1][1] - a[0][1] * a[1][0]) * b.z)};
}

/// One beat from P: where it ends, and the derivative of that by P.
template <class S>
struct BeatMap {
    Momentum<S> end;
    Matrix3<S> monodromy;
};

template <class S, class Law>
BeatMap<S> beat_map(const Swimmer<S, Law>& fish, const ShapeTable<S>& table, int stride, const S& period,
                    const Momentum<S>& P) {
    Momentum<Dual<S, 3>> start = widen<Dual<S, 3>>(P);
    start.x.d[0] = start.y.d[1] = start.z.d[2] = S(1);
    const Momentum<Dual<S, 3>> end = swim_beat(fish, table, stride, period, start);
    BeatMap<S> map{{end.x.v, end.y.v, end.z.v}, {}};
    for (int k = 0; k < 3; ++k) {
        map.monodromy.a[0][k] = end.x.d[k];
        map.monodromy.a[1][k] = end.y.d[k];
        map.monodromy.a[2][k] = end.z.d[k];
    }
    return map;
}

/// Size of a change of the motion: velocity of the nose in body lengths a beat, turning in rad a beat, whichever is
/// more.
template <class S>
S size_per_beat(const Twist<S>& d, const S& length, const S& period) {
    return period * max(max(abs(d.x), abs(d.y)) / length, abs(d.z));
}

/// Newton's step from a beat map, (I - monodromy) step = Phi(P) - P, as a change of the twist at the beat's start.
template <class S>
Twist<S> newton_step(const BeatMap<S>& map, const Momentum<S>& P, const Instant<S>& start) {
    Matrix3<S> a = map.monodromy;
    for (auto& row : a.a)
        for (S& x : row) x = -x;
    for (int k = 0; k < 3; ++k) a.a[k][k] += S(1);
    return start.mobility * solve(a, map.end - P);
}

/// The same step taken in u |u|: u -> sqrt(u^2 + 2 u du), unless that would turn the body around.
///
/// Thrust hardly depends on the speed and drag grows with its square, so in u |u| their balance is a straight line, and
/// Newton's method arrives in few steps from far away.
template <class S>
Twist<S> step_in_square(const Twist<S>& d, const S& u) {
    const S square = u * u + (u + u) * d.x;
    const S root = sqrt(max(square, S(0)));
    return {select(S(0) < square, select(u < S(0), -root, root) - u, d.x), d.y, d.z};
}

template <class S, class M>
HYPERTUNA_INLINE Planar<S> select(const M& mask, const Planar<S>& yes, const Planar<S>& no) {
    return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
template <class S, class M>
HYPERTUNA_INLINE BeatMap<S> select(const M& mask, const BeatMap<S>& yes, const BeatMap<S>& no) {
    BeatMap<S> map{select(mask, yes.end, no.end), {}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) map.monodromy.a[i][j] = select(mask, yes.monodromy.a[i][j], no.monodromy.a[i][j]);
    return map;
}

/// The search for the settled beat, lane by lane.
template <class S>
struct Search {
    Momentum<S> P;     // where the next beat starts
    Momentum<S> best;  // where the best beat so far started,
    BeatMap<S> map;    // and what became of it
    S residual;        // change of the motion over that beat, infinite before the first
    S distance;        // size of Newton's step from it, relative to the stride
    S damping;         // part of Newton's step to take
    S beats;           // beats integrated so far
};

template <class S>
Search<S> search_from(const Momentum<S>& P, const S& beats) {
    const S infinite(std::numeric_limits<base_t<S>>::infinity());
    return {P, P, {}, infinite, infinite, S(1), beats};
}

/// What a distance is measured by: the way the body makes in a beat, in body lengths, and a little for a body at rest.
template <class S>
S stride(const Twist<S>& xi, const S& length, const S& period) {
    return period * abs(xi.x) / length + S(base_t<S>(1e-3));
}

/// Newton's method until its step is smaller than `tolerance` of the stride; search.P has made that last step.
///
/// Undamped, every step is taken whole, in u |u|: quick, and nearly always enough. Damped, a step that does not lower
/// the residual (or leaves the numbers) is halved.
template <class S, class Law>
HYPERTUNA_NOINLINE void newton(const Swimmer<S, Law>& fish, const ShapeTable<S>& table, int stride_instants,
                               const S& length, const S& period, base_t<S> tolerance, bool damped, int max_beats,
                               Search<S>& search) {
    using T = base_t<S>;
    const Instant<S> start = table[0];
    const Symmetric<S> inertia = inverse(start.mobility);
    for (int beat = 0; beat < max_beats; ++beat) {
        const auto open = !(search.distance < S(tolerance));
        if (!any(open)) return;
        const BeatMap<S> map = beat_map(fish, table, stride_instants, period, search.P);
        const S residual = size_per_beat(start.mobility * (map.end - search.P), length, period);
        const auto better = open & (residual < (damped ? search.residual : S(std::numeric_limits<T>::infinity())));

        search.best = select(better, search.P, search.best);
        search.map = select(better, map, search.map);
        search.residual = select(better, residual, search.residual);
        search.damping = select(better, min(S(1), S(T(2)) * search.damping), S(T(0.5)) * search.damping);
        if (!damped) search.damping = S(1);

        const Twist<S> xi = twist(start, search.best);
        Twist<S> step = newton_step(search.map, search.best, start);
        if (!damped) step = step_in_square(step, xi.x);
        const S size = size_per_beat(step, length, period);
        search.distance = select(better, size / stride(xi, length, period), search.distance);
        const S part = min(search.damping, S(1) / size);  // no step of more than a body length a beat
        search.P = select(open, search.best + part * (inertia * step), search.P);
        search.beats = select(open, search.beats + S(1), search.beats);
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
