/// From a gait to its settled beat: guess, coarse search, fine search, and the proof by one more beat. Then, where a
/// start from rest leads.
#pragma once

#include "hypertuna/swimming/beat.hpp"
#include "hypertuna/swimming/periodic.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Settled {
    Beat<S> beat;
    Momentum<S> start;
    Matrix3<S> monodromy;
    S residual;  // change of the motion over the measured beat, body lengths or rad
    S distance;  // Newton's step from it, relative to the stride: how far it is from settled
    S beats;     // beats integrated to find it
};

template <class S, class M>
Settled<S> select(const M& mask, const Settled<S>& yes, const Settled<S>& no) {
    const auto pick = [&](const S& a, const S& b) { return select(mask, a, b); };
    const Beat<S>&a = yes.beat, &b = no.beat;
    const Pose<S>&p = a.displacement, &q = b.displacement;
    const BeatMap<S> monodromy = select(mask, BeatMap<S>{a.end, yes.monodromy}, BeatMap<S>{b.end, no.monodromy});
    return {{monodromy.end,
             {pick(p.x, q.x), pick(p.y, q.y), pick(p.heading, q.heading)},
             pick(a.power, b.power),
             pick(a.power_positive, b.power_positive),
             pick(a.loss, b.loss),
             pick(a.torque_peak, b.torque_peak),
             pick(a.excursion, b.excursion),
             pick(a.arc, b.arc),
             pick(a.radius, b.radius),
             pick(a.advance, b.advance)},
            select(mask, yes.start, no.start),
            monodromy.monodromy,
            pick(yes.residual, no.residual),
            pick(yes.distance, no.distance),
            pick(yes.beats, no.beats)};
}

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

/// Newton's last step, relative to the stride: at half the steps, at all of them, in a second try, and what counts as
/// settled.
struct SettleTolerances {
    double coarse, fine, last, settled;
};
inline constexpr SettleTolerances settle_tolerances = {5e-2, 1e-3, 1e-5, 1e-7};
enum class Retry { go_on, damped, patient };
inline constexpr int quick_beats = 12;  // that undamped Newton gets at each number of steps
inline constexpr int long_wait = 200;   // beats after which even the slow transients have chosen their way

/// What became of a search, as BeatStatus: 0 settled (it may yet be unstable), 1 unsettled, 3 diverged.
template <class S>
S search_status(const Settled<S>& found, const S& speed) {
    using T = base_t<S>;
    const S most(std::numeric_limits<T>::max()), &turn = found.beat.displacement.heading;
    const auto finite = (abs(turn + found.beat.power + found.beat.loss + found.residual) <= most) &
                        ((abs(speed + found.beat.excursion) <= most) | (S(T(pi)) < abs(turn)));
    return select(finite, select(found.distance < S(T(settle_tolerances.settled)), S(0), S(1)), S(3));
}

/// Measure the beat from `start`, and how far it is from settled: the proof of a search.
template <class S, class Law>
HYPERTUNA_NOINLINE Settled<S> prove(const Swimmer<S, Law>& fish, const JointShare<S>* joints,
                                    const ShapeTable<S>& table, const S& length, const S& period,
                                    const Momentum<S>& start, const Search<S>& search, const BeatScratch<S>& scratch) {
    const Instant<S> now = table[0];
    const Beat<S> beat = measure_beat(fish, joints, table, period, start, scratch);
    const Twist<S> step = newton_step(BeatMap<S>{beat.end, search.map.monodromy}, start, now);
    return {beat,
            start,
            search.map.monodromy,
            size_per_beat(now.mobility * (beat.end - start), length, period),
            size_per_beat(step, length, period) / stride(twist(now, start), length, period),
            search.beats + S(1)};
}

/// The settled beat by Newton's method: at half the steps first, then at all of them, proven by the beat itself.
///
/// Where that fails, the search goes on; then it begins again with damped steps; and at last after a long wait.
template <class S, class Law>
Settled<S> settle(const Swimmer<S, Law>& fish, const JointShare<S>* joints, const ShapeTable<S>& table, const S& length,
                  const S& period, const Momentum<S>& guess, int max_beats, const BeatScratch<S>& scratch) {
    using T = base_t<S>;
    constexpr SettleTolerances tolerance = settle_tolerances;
    const Momentum<S> warm = swim_beat(fish, table, 2, period, swim_beat(fish, table, 2, period, guess));
    Search<S> search = search_from(warm, S(2));
    newton(fish, table, 2, length, period, T(tolerance.coarse), false, quick_beats, search);
    // What half the steps could not settle (too stiff for them) begins again with all of them.
    search = search_from(select(search.distance < S(T(tolerance.coarse)), search.P, guess), search.beats);
    newton(fish, table, 1, length, period, T(tolerance.fine), false, quick_beats, search);
    Settled<S> out = prove(fish, joints, table, length, period, search.P, search, scratch);

    for (const Retry retry : {Retry::go_on, Retry::damped, Retry::patient}) {
        const auto open = !(out.distance < S(T(tolerance.settled)));
        if (!any(open)) break;
        Momentum<S> start = retry == Retry::go_on ? search.P : guess;
        const int wait = retry == Retry::go_on ? 0 : retry == Retry::damped ? 2 : long_wait;
        for (int k = 0; k < wait; ++k) start = swim_beat(fish, table, 1, period, start);
        // Gaits that are settled keep what they have: their search is closed from the start.
        Search<S> again = search_from(start, out.beats + S(T(wait)));
        again.distance = select(open, again.distance, S(0));
        const bool damped = retry != Retry::go_on;
        newton(fish, table, 1, length, period, T(tolerance.last), damped, damped ? max_beats : quick_beats, again);
        out = select(open, prove(fish, joints, table, length, period, again.P, again, scratch), out);
    }
    return out;
}

/// The same by waiting: `beats` plain beats, and one more measured. Its distance from the settled beat follows from how
/// the change per beat shrinks, as in a geometric series.
template <class S, class Law>
Settled<S> wait(const Swimmer<S, Law>& fish, const JointShare<S>* joints, const ShapeTable<S>& table, const S& length,
                const S& period, const Momentum<S>& from, int beats, const BeatScratch<S>& scratch) {
    using T = base_t<S>;
    const Instant<S> now = table[0];
    Momentum<S> start = from;
    S before(0);
    for (int k = 0; k < beats; ++k) {
        const Momentum<S> end = swim_beat(fish, table, 1, period, start);
        before = size_per_beat(now.mobility * (end - start), length, period);
        start = end;
    }
    Search<S> search = search_from(start, S(T(beats)));
    for (auto& row : search.map.monodromy.a)
        for (S& x : row) x = S(std::numeric_limits<T>::quiet_NaN());
    Settled<S> out = prove(fish, joints, table, length, period, start, search, scratch);
    const S rounding(T(64) * std::numeric_limits<T>::epsilon());  // no change is smaller, and then it shrinks no more
    const S shrinks =
        max(S(1) - out.residual / max(before, S(T(1e-30))), select(out.residual < rounding, S(T(1e-3)), S(T(1e-6))));
    out.distance = out.residual / (shrinks * stride(twist(now, start), length, period));
    return out;
}

/// A start from rest, followed toward a settled beat.
template <class S>
struct Approach {
    Momentum<S> end;  // momentum after the last beat
    S distance;       // of that from the settled beat, relative to the stride
    S beats;          // swum
};

/// Distance at which a motion has arrived at a settled beat: disturbances so small die out by its multipliers. A motion
/// elsewhere that changes by less than `standing` a beat will not come.
struct ApproachTolerances {
    double arrived, standing;
};
inline constexpr ApproachTolerances approach_tolerances = {1e-2, 1e-6};

template <class S, class M>
Approach<S> select(const M& mask, const Approach<S>& yes, const Approach<S>& no) {
    return {select(mask, yes.end, no.end), select(mask, yes.distance, no.distance), select(mask, yes.beats, no.beats)};
}

/// Swim plain beats from rest, every `stride_instants` of the table's instants half a step, until the motion arrives at
/// the settled beat that starts with `target`, stands elsewhere, or has had `max_beats`.
template <class S, class Law>
HYPERTUNA_NOINLINE Approach<S> swim_toward(const Swimmer<S, Law>& fish, const ShapeTable<S>& table, int stride_instants,
                                           const S& length, const S& period, const Momentum<S>& target, int max_beats) {
    using T = base_t<S>;
    const Instant<S> now = table[0];
    const S scale = S(1) / stride(twist(now, target), length, period);
    const auto size = [&](const Momentum<S>& a, const Momentum<S>& b) {
        return scale * size_per_beat(now.mobility * (a - b), length, period);
    };
    const S zero(0);
    Approach<S> way{{zero, zero, zero}, zero, zero};
    way.distance = size(way.end, target);
    S change(std::numeric_limits<T>::infinity());
    for (int k = 0; k < max_beats; ++k) {
        // A comparison with NaN is false: what diverges goes no further.
        const auto open =
            (S(T(approach_tolerances.arrived)) <= way.distance) & (S(T(approach_tolerances.standing)) <= change);
        if (!any(open)) break;
        const Momentum<S> next = swim_beat(fish, table, stride_instants, period, way.end);
        change = size(next, way.end);
        way.end = select(open, next, way.end);
        way.beats = select(open, way.beats + S(1), way.beats);
        way.distance = size(way.end, target);
    }
    return way;
}

/// Follow a start from rest toward a settled beat: with half the steps, and where that does not arrive, with all of
/// them. Newton's method jumps from one basin of attraction into another; plain beats do not.
template <class S, class Law>
Approach<S> approach(const Swimmer<S, Law>& fish, const ShapeTable<S>& table, const S& length, const S& period,
                     const Momentum<S>& target, int max_beats) {
    using T = base_t<S>;
    const S none(std::numeric_limits<T>::quiet_NaN());
    const Approach<S> coarse = swim_toward(fish, table, 2, length, period, target, max_beats);
    const auto arrived = coarse.distance < S(T(approach_tolerances.arrived));
    const Momentum<S> left = select(arrived, Momentum<S>{none, none, none}, target);
    return select(arrived, coarse, swim_toward(fish, table, 1, length, period, left, max_beats));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
