/// The settled beat: the motion that repeats itself, computed by Newton's method instead of by waiting.
///
/// One beat maps the state at its start to the state at its end, P -> Phi(P). Dual numbers give the exact derivative of
/// that map (the monodromy matrix), and Newton solves Phi(P) = P.
///
/// A body type (such as PeriodicSwimmer in settle.hpp) has a state of its own: a vector of `size` numbers, each a
/// component(P, k).
#pragma once

#include <limits>

#include "hypertuna/swimming/stepping.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A square matrix by its rows.
template <class S, int N>
struct Matrix {
    S a[N][N];
};

/// Solve A x = b by Cramer's rule.
template <class S>
Planar<S> solve(const Matrix<S, 3>& m, const Planar<S>& b) {
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

/// Solve A x = b of any size by elimination with the largest pivot of each column.
template <class S, int N, class Y>
Y solve(Matrix<S, N> m, Y b) {
    auto& a = m.a;
    const auto swap_where = [](const auto& mask, S& x, S& y) {
        const S before = x;
        x = select(mask, y, x), y = select(mask, before, y);
    };
    for (int k = 0; k < N; ++k)
        for (int i = k + 1; i < N; ++i) {
            const auto larger = abs(a[k][k]) < abs(a[i][k]);
            for (int j = k; j < N; ++j) swap_where(larger, a[k][j], a[i][j]);
            swap_where(larger, component(b, k), component(b, i));
            const S factor = a[i][k] / a[k][k];
            for (int j = k; j < N; ++j) a[i][j] -= factor * a[k][j];
            component(b, i) -= factor * component(b, k);
        }
    for (int k = N - 1; k >= 0; --k) {
        for (int j = k + 1; j < N; ++j) component(b, k) -= a[k][j] * component(b, j);
        component(b, k) = component(b, k) / a[k][k];
    }
    return b;
}

/// State at the end of one beat from P, and its derivative with respect to P.
template <class S, class Y = Momentum<S>>
struct BeatMap {
    Y end;
    Matrix<S, Y::size> monodromy;
};

template <class Body, class Y>
auto beat_map(const Body& body, int stride_instants, const Y& P) {
    using S = typename Body::Scalar;
    auto start = widen<Dual<S, Y::size>>(P);
    for (int k = 0; k < Y::size; ++k) component(start, k).d[k] = S(1);
    auto end = body.swim(start, stride_instants);
    BeatMap<S, Y> map;
    for (int i = 0; i < Y::size; ++i) {
        component(map.end, i) = component(end, i).v;
        for (int k = 0; k < Y::size; ++k) map.monodromy.a[i][k] = component(end, i).d[k];
    }
    return map;
}

/// Newton's step from a beat map, (I - monodromy) step = Phi(P) - P, as a change of the motion at the beat's start.
template <class Body, class S, class Y>
auto newton_step(const Body& body, const BeatMap<S, Y>& map, const Y& P) {
    Matrix<S, Y::size> a = map.monodromy;
    for (auto& row : a.a)
        for (S& x : row) x = -x;
    for (int k = 0; k < Y::size; ++k) a.a[k][k] += S(1);
    return body.motion(solve(a, map.end - P));
}

template <class S, class M>
HYPERTUNA_INLINE Planar<S> select(const M& mask, const Planar<S>& yes, const Planar<S>& no) {
    return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
template <class S, class Y, class M>
HYPERTUNA_INLINE BeatMap<S, Y> select(const M& mask, const BeatMap<S, Y>& yes, const BeatMap<S, Y>& no) {
    BeatMap<S, Y> map{select(mask, yes.end, no.end), {}};
    for (int i = 0; i < Y::size; ++i)
        for (int j = 0; j < Y::size; ++j)
            map.monodromy.a[i][j] = select(mask, yes.monodromy.a[i][j], no.monodromy.a[i][j]);
    return map;
}

/// The search for the settled beat, lane by lane.
template <class S, class Y = Momentum<S>>
struct Search {
    Y P;                // state at the start of the next beat
    Y best;             // where the best beat so far started,
    BeatMap<S, Y> map;  // and its beat map
    S residual;         // change of the motion over that beat, infinite before the first
    S distance;         // size of Newton's step from it, relative to the stride
    S damping;          // part of Newton's step to take
    S beats;            // beats integrated so far
};

template <class S, class Y>
Search<S, Y> search_from(const Y& P, const S& beats) {
    const S infinite(std::numeric_limits<base_t<S>>::infinity());
    return {P, P, {}, infinite, infinite, S(1), beats};
}

/// Newton's method until its step is smaller than `tolerance` of the stride; search.P has made that last step.
///
/// Undamped, every step is taken in full, in u |u|: quick, and nearly always enough. Damped, a step that does not lower
/// the residual, or is not finite, is halved.
template <class Body, class S, class Y>
HYPERTUNA_NOINLINE void newton(const Body& body, int stride_instants, base_t<S> tolerance, bool damped, int max_beats,
                               Search<S, Y>& search) {
    using T = base_t<S>;
    for (int beat = 0; beat < max_beats; ++beat) {
        const auto open = !(search.distance < S(tolerance));
        if (!any(open)) return;
        const BeatMap<S, Y> map = beat_map(body, stride_instants, search.P);
        const S residual = body.size(body.motion(map.end - search.P));
        const auto better = open & (residual < (damped ? search.residual : S(std::numeric_limits<T>::infinity())));

        search.best = select(better, search.P, search.best);
        search.map = select(better, map, search.map);
        search.residual = select(better, residual, search.residual);
        search.damping = select(better, min(S(1), S(T(2)) * search.damping), S(T(0.5)) * search.damping);
        if (!damped) search.damping = S(1);

        auto step = newton_step(body, search.map, search.best);
        if (!damped) step = body.step_in_square(step, search.best);
        const S size = body.size(step);
        search.distance = select(better, size / body.stride(search.best), search.distance);
        const S part = min(search.damping, S(1) / size);  // no step of more than a body length a beat
        search.P = select(open, search.best + part * body.state(step), search.P);
        search.beats = select(open, search.beats + S(1), search.beats);
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
