/// From a gait to its settled beat: guess, coarse search, fine search, and the proof by one more beat.
#pragma once

#include "beat.hpp"
#include "periodic.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Settled {
    Beat<S> beat;
    Momentum<S> start;
    Matrix3<S> monodromy;
    S residual;  // change per beat of the measured beat itself, body lengths or rad
    S beats;     // beats integrated to find it
};

/// A brisk start for the search: above most gaits' speed, because Newton comes down on it from above in a few steps and
/// overshoots from below. Straight ahead at 0.29 (0.1 + sum of amplitudes) body lengths a beat.
template <class S>
Momentum<S> brisk_start(const ShapeTable<S>& table, int groups, const Harmonic<S>* group, const S& frequency,
                        const S& length) {
    using T = base_t<S>;
    S swing(T(0.1));
    for (int g = 0; g < groups; ++g) {
        const S x = frequency / group[g].bandwidth;
        swing += group[g].amplitude / sqrt(S(1) + x * x);
    }
    const S speed = S(T(0.29)) * swing * frequency * length;
    const Symmetric<S> inertia = inverse(table.mobility[0]);
    return {-(inertia.xx * speed), S(0), S(0)};
}

/// Apply Newton's step once more to the best beat of a search.
template <class S>
Momentum<S> last_step(const Search<S>& search, const Symmetric<S>& mobility, const S& length, const S& period,
                      double largest_step) {
    return search.P +
           newton_step(BeatMap<S>{search.end, search.monodromy}, search.P, mobility, length, period, base_t<S>(largest_step));
}

/// The settled beat by Newton's method: at half the steps first, then at all of them.
template <class S, class Law>
Settled<S> settle(const Swimmer<S, Law>& fish, const JointShare<S>* joints, const ShapeTable<S>& table,
                  const S& length, const S& period, const Momentum<S>& guess, const NewtonOptions& options,
                  const BeatScratch<S>& scratch) {
    using T = base_t<S>;
    const S infinite(std::numeric_limits<T>::infinity()), zero(0);
    const Symmetric<S> mobility = table.mobility[0];
    const NewtonOptions coarse{1e-3, options.largest_step, options.most_beats / 2};
    const NewtonOptions near{1e-3, options.largest_step, options.most_beats};

    Momentum<S> start = swim_beat(fish, table, 2, period, swim_beat(fish, table, 2, period, guess));
    Search<S> search{start, start, infinite, {}, S(T(2))};
    newton(fish, table, 2, length, period, coarse, search);
    // A lane that the coarse steps could not settle (too stiff for them) begins anew with the fine ones.
    start = select(search.residual < S(T(coarse.tolerance)), last_step(search, mobility, length, period, 1.0), guess);
    search = {start, start, infinite, {}, search.beats};
    newton(fish, table, 1, length, period, near, search);

    // One step beyond, and the beat from there is measured: its own change is the proof.
    start = select(search.residual < S(T(near.tolerance)), last_step(search, mobility, length, period, 1.0), search.P);
    Settled<S> out{measure_beat(fish, joints, table, period, start, scratch), start, search.monodromy, zero, search.beats};
    out.residual = change_per_beat(mobility, length, period, out.beat.end - start);
    const auto open = !(out.residual < S(T(options.tolerance)));
    if (any(open)) {
        newton(fish, table, 1, length, period, options, search);
        out.start = select(open, search.P, start);
        out.beat = measure_beat(fish, joints, table, period, out.start, scratch);
        out.residual = change_per_beat(mobility, length, period, out.beat.end - out.start);
        out.monodromy = search.monodromy;
        out.beats = search.beats;
    }
    return out;
}

/// The same by waiting: so many plain beats, and one more measured.
template <class S, class Law>
Settled<S> wait(const Swimmer<S, Law>& fish, const JointShare<S>* joints, const ShapeTable<S>& table, const S& length,
                const S& period, const Momentum<S>& from, int beats, const BeatScratch<S>& scratch) {
    Momentum<S> start = from;
    for (int k = 0; k < beats; ++k) start = swim_beat(fish, table, 1, period, start);
    Settled<S> out{measure_beat(fish, joints, table, period, start, scratch), start, {}, S(0), S(base_t<S>(beats))};
    out.residual = change_per_beat(table.mobility[0], length, period, out.beat.end - start);
    for (auto& row : out.monodromy.a)
        for (S& x : row) x = S(std::numeric_limits<base_t<S>>::quiet_NaN());
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
