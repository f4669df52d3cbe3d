/// The settled beat: the motion that repeats itself, found by Newton's method instead of by waiting.
///
/// One beat maps the momentum at its start to the momentum at its end, P -> Phi(P). Dual numbers give the exact
/// derivative of that map (the monodromy matrix), and Newton solves Phi(P) = P.
#pragma once

#include <limits>

#include "stepping.hpp"

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
    return {scale * (c0 * b.x + (a[0][2] * a[2][1] - a[0][1] * a[2][2]) * b.y +
                     (a[0][1] * a[1][2] - a[0][2] * a[1][1]) * b.z),
            scale * (c1 * b.x + (a[0][0] * a[2][2] - a[0][2] * a[2][0]) * b.y +
                     (a[0][2] * a[1][0] - a[0][0] * a[1][2]) * b.z),
            scale * (c2 * b.x + (a[0][1] * a[2][0] - a[0][0] * a[2][1]) * b.y +
                     (a[0][0] * a[1][1] - a[0][1] * a[1][0]) * b.z)};
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

/// How much a change of momentum changes the motion: velocity of the nose in body lengths a beat, turning in rad
/// a beat, whichever is more.
template <class S>
S change_per_beat(const Symmetric<S>& mobility, const S& length, const S& period, const Momentum<S>& dP) {
    const Twist<S> d = mobility * dP;
    return period * max(max(abs(d.x), abs(d.y)) / length, abs(d.z));
}

/// Newton's step from a beat map, (I - monodromy) step = Phi(P) - P, kept within a largest change per beat.
template <class S>
Momentum<S> newton_step(const BeatMap<S>& map, const Momentum<S>& P, const Symmetric<S>& mobility, const S& length,
                        const S& period, base_t<S> largest) {
    Matrix3<S> a = map.monodromy;
    for (auto& row : a.a)
        for (S& x : row) x = -x;
    for (int k = 0; k < 3; ++k) a.a[k][k] += S(1);
    const Momentum<S> step = solve(a, map.end - P);
    const S size = change_per_beat(mobility, length, period, step);
    return min(S(1), S(largest) / size) * step;
}

template <class S, class M>
HYPERTUNA_INLINE Planar<S> select(const M& mask, const Planar<S>& yes, const Planar<S>& no) {
    return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}

/// The search for the settled beat, lane by lane.
template <class S>
struct Search {
    Momentum<S> P;         // start of the best beat so far
    Momentum<S> end;       // where that beat ends
    S residual;            // its change per beat; infinite before the first
    Matrix3<S> monodromy;  // its derivative
    S beats;               // beats integrated so far
};

struct NewtonOptions {
    double tolerance;     // change per beat that counts as settled
    double largest_step;  // change per beat that one Newton step may make
    int most_beats;       // give up after so many
};

/// Newton's method from search.P. A step that does not lower the residual (or leaves the numbers) is taken back, and a
/// plain beat from the best start is made instead, so that the search never does worse than waiting would.
template <class S, class Law>
void newton(const Swimmer<S, Law>& fish, const ShapeTable<S>& table, int stride, const S& length, const S& period,
            const NewtonOptions& options, Search<S>& search) {
    using T = base_t<S>;
    const S tolerance(T(options.tolerance)), infinite(std::numeric_limits<T>::infinity());
    const Symmetric<S> mobility = table.mobility[0];
    Momentum<S> trial = search.P;
    for (int beat = 0; beat < options.most_beats; ++beat) {
        const auto open = !(search.residual < tolerance);
        if (!any(open)) return;
        const BeatMap<S> map = beat_map(fish, table, stride, period, trial);
        const S residual = change_per_beat(mobility, length, period, map.end - trial);
        const auto better = open & (residual < search.residual);
        const auto worse = open & !better;

        search.P = select(better, trial, search.P);
        search.end = select(better, map.end, search.end);
        search.residual = select(better, residual, select(worse, infinite, search.residual));
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                search.monodromy.a[i][j] = select(better, map.monodromy.a[i][j], search.monodromy.a[i][j]);
        search.beats = select(open, search.beats + S(1), search.beats);

        const Momentum<S> step = newton_step(map, trial, mobility, length, period, T(options.largest_step));
        trial = select(better, trial + step, select(worse, search.end, search.P));
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
