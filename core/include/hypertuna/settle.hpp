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
Momentum<S> brisk_start(const ShapeTable<S>& table, int groups, const Swing<S>* swings, const S& frequency,
                        const S& length) {
    using T = base_t<S>;
    S swing(T(0.1));
    for (int g = 0; g < groups; ++g)
        swing += sqrt(swings[g].sine * swings[g].sine + swings[g].cosine * swings[g].cosine);
    const S speed = S(T(0.29)) * swing * frequency * length;
    const Symmetric<S> inertia = inverse(table.mobility[0]);
    return {-(inertia.xx * speed), S(0), S(0)};
}

struct SettleTolerances {
    double coarse, fine, last;  // size of Newton's last step at half the steps, at all of them, and when those fail
    double largest;             // size that one step may have
    double change;              // change per beat that counts as settled: body lengths or rad
};
inline constexpr SettleTolerances settle_tolerances = {1e-2, 2e-4, 1e-9, 1.0, 1e-8};

/// The settled beat by Newton's method: at half the steps first, then at all of them, then proven by the beat itself.
template <class S, class Law>
Settled<S> settle(const Swimmer<S, Law>& fish, const JointShare<S>* joints, const ShapeTable<S>& table,
                  const S& length, const S& period, const Momentum<S>& guess, int most_beats,
                  const BeatScratch<S>& scratch) {
    using T = base_t<S>;
    constexpr SettleTolerances tolerance = settle_tolerances;
    const auto prove = [&](Settled<S>& out, const Momentum<S>& start) {
        out.start = start;
        out.beat = measure_beat(fish, joints, table, period, start, scratch);
        out.residual = size_per_beat(table.mobility[0] * (out.beat.end - start), length, period);
    };
    const Momentum<S> warm = swim_beat(fish, table, 2, period, swim_beat(fish, table, 2, period, guess));
    Search<S> search = search_from(warm, S(2));
    newton(fish, table, 2, length, period, T(tolerance.coarse), T(tolerance.largest), most_beats / 4, search);
    // A lane that half the steps could not settle (too stiff for them) begins anew with all of them.
    search = search_from(select(search.size < S(T(tolerance.coarse)), search.P, guess), search.beats);
    newton(fish, table, 1, length, period, T(tolerance.fine), T(tolerance.largest), most_beats, search);

    Settled<S> out;
    prove(out, search.P);
    const auto open = !(out.residual < S(T(tolerance.change)));
    if (any(open)) {
        search.size = select(open, S(std::numeric_limits<T>::infinity()), S(0));
        search.end = select(open, out.beat.end, search.end);
        newton(fish, table, 1, length, period, T(tolerance.last), T(tolerance.largest), most_beats, search);
        prove(out, search.P);
    }
    out.monodromy = search.monodromy;
    out.beats = search.beats;
    return out;
}

/// The same by waiting: so many plain beats, and one more measured.
template <class S, class Law>
Settled<S> wait(const Swimmer<S, Law>& fish, const JointShare<S>* joints, const ShapeTable<S>& table, const S& length,
                const S& period, const Momentum<S>& from, int beats, const BeatScratch<S>& scratch) {
    Momentum<S> start = from;
    for (int k = 0; k < beats; ++k) start = swim_beat(fish, table, 1, period, start);
    Settled<S> out{measure_beat(fish, joints, table, period, start, scratch), start, {}, S(0), S(base_t<S>(beats))};
    out.residual = size_per_beat(table.mobility[0] * (out.beat.end - start), length, period);
    for (auto& row : out.monodromy.a)
        for (S& x : row) x = S(std::numeric_limits<base_t<S>>::quiet_NaN());
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
