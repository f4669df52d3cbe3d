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

/// Size of a change of the motion: velocity of the nose in body lengths a beat, turning in rad a beat, whichever is more.
template <class S>
S size_per_beat(const Twist<S>& d, const S& length, const S& period) {
    return period * max(max(abs(d.x), abs(d.y)) / length, abs(d.z));
}

/// A change of the momentum at the start of a beat, and its size.
template <class S>
struct NewtonStep {
    Momentum<S> change;
    S size;  // body lengths or rad a beat
};

/// Newton's step from a beat map, (I - monodromy) step = Phi(P) - P, no larger than `largest`.
///
/// Thrust hardly depends on the speed and drag grows with its square, so the step is taken in u |u|, in which the
/// balance of the two is a straight line: u -> sqrt(u^2 + 2 u du), unless that would turn the body around.
template <class S>
NewtonStep<S> newton_step(const BeatMap<S>& map, const Momentum<S>& P, const Instant<S>& start, const S& length,
                          const S& period, base_t<S> largest) {
    Matrix3<S> a = map.monodromy;
    for (auto& row : a.a)
        for (S& x : row) x = -x;
    for (int k = 0; k < 3; ++k) a.a[k][k] += S(1);
    Twist<S> d = start.mobility * solve(a, map.end - P);

    const S u = twist(start, P).x;
    const S square = u * u + (u + u) * d.x;
    const S root = sqrt(max(square, S(0)));
    d.x = select(S(0) < square, select(u < S(0), -root, root) - u, d.x);

    const S size = size_per_beat(d, length, period);
    return {min(S(1), S(largest) / size) * (inverse(start.mobility) * d), size};
}

template <class S, class M>
HYPERTUNA_INLINE Planar<S> select(const M& mask, const Planar<S>& yes, const Planar<S>& no) {
    return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}

/// The search for the settled beat, lane by lane.
template <class S>
struct Search {
    Momentum<S> P;         // where the next beat starts
    Momentum<S> end;       // where the best beat so far ended
    S size;                // Newton's step from that beat: how far it is from settled; infinite before the first
    Matrix3<S> monodromy;  // its derivative
    S beats;               // beats integrated so far
};

template <class S>
Search<S> search_from(const Momentum<S>& P, const S& beats) {
    return {P, P, S(std::numeric_limits<base_t<S>>::infinity()), {}, beats};
}

/// Newton's method until its step is smaller than `tolerance`; search.P has made that last step.
///
/// A step after which the next one is not smaller (or not a number) is taken back, and a plain beat from the best start
/// is made instead, so that the search never does worse than waiting would.
template <class S, class Law>
void newton(const Swimmer<S, Law>& fish, const ShapeTable<S>& table, int stride, const S& length, const S& period,
            base_t<S> tolerance, base_t<S> largest, int most_beats, Search<S>& search) {
    const S infinite(std::numeric_limits<base_t<S>>::infinity());
    for (int beat = 0; beat < most_beats; ++beat) {
        const auto open = !(search.size < S(tolerance));
        if (!any(open)) return;
        const BeatMap<S> map = beat_map(fish, table, stride, period, search.P);
        const NewtonStep<S> step = newton_step(map, search.P, table[0], length, period, largest);
        const auto better = open & (step.size < search.size);
        const auto worse = open & !better;

        search.P = select(better, search.P + step.change, select(worse, search.end, search.P));
        search.end = select(better, map.end, search.end);
        search.size = select(better, step.size, select(worse, infinite, search.size));
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                search.monodromy.a[i][j] = select(better, map.monodromy.a[i][j], search.monodromy.a[i][j]);
        search.beats = select(open, search.beats + S(1), search.beats);
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
