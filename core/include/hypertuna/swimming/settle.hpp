/// From a gait to its settled beat: guess, coarse search, fine search, and the proof by one more beat. Then, where a
/// start from rest leads.
#pragma once

#include "hypertuna/swimming/beat.hpp"
#include "hypertuna/swimming/periodic.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Where a failed search begins again: at its last state, at its guess or at rest; `Retry::wait` beats are swum from
/// there first.
enum class From { here, guess, rest };
struct Retry {
    From from;
    int wait;
    bool damped;
};
inline constexpr int long_wait = 200;  // beats after which even slow transients approach one settled motion

/// A swimmer with its gait, in the form that the search for a settled beat needs: its state is the momentum. A body
/// whose state has more coordinates is another type with the same members.
template <class S, class Law>
struct PeriodicSwimmer {
    using Scalar = S;
    using State = Momentum<S>;
    static constexpr Retry retries[] = {{From::here, 0, false}, {From::guess, 2, true}, {From::guess, long_wait, true}};

    const Swimmer<S, Law>& fish;
    const JointShare<S>* joints;
    const ShapeTable<S>& table;
    S length, period;
    const BeatScratch<S>& scratch;

    /// State after a beat.
    template <class V>
    Momentum<V> swim(const Momentum<V>& P, int stride_instants = 1) const {
        return swim_beat(fish, table, stride_instants, period, P);
    }
    Beat<S> measure(const Momentum<S>& P) const { return measure_beat(fish, joints, table, period, P, scratch); }
    /// Twist of the head at the beat's start.
    Twist<S> head(const Momentum<S>& P) const { return twist(table[0], P); }
    /// A change of the state as a change of the motion at the beat's start, and back.
    Twist<S> motion(const Momentum<S>& change) const { return table.mobility[0] * change; }
    Momentum<S> state(const Twist<S>& change) const { return inverse(table.mobility[0]) * change; }
    /// Size of a change of the motion: velocity of the nose in body lengths per beat or turning in rad per beat,
    /// whichever is larger.
    S size(const Twist<S>& d) const { return period * max(max(abs(d.x), abs(d.y)) / length, abs(d.z)); }
    /// Unit of a search's distances: the body's travel in a beat, in body lengths, plus a little for a body at rest.
    S stride(const Momentum<S>& P) const { return period * abs(surge(P)) / length + S(base_t<S>(1e-3)); }
    /// Newton's step d from a state, taken in u |u|: u -> sqrt(u^2 + 2 u du), unless that would turn the body around.
    ///
    /// Thrust hardly depends on the speed and drag grows with its square, so in u |u| their balance is a straight line,
    /// and Newton's method arrives in few steps from far away.
    Twist<S> step_in_square(const Twist<S>& d, const Momentum<S>& P) const {
        const S u = surge(P), square = u * u + (u + u) * d.x;
        const S root = sqrt(max(square, S(0)));
        return {select(S(0) < square, select(u < S(0), -root, root) - u, d.x), d.y, d.z};
    }

  private:
    S surge(const Momentum<S>& P) const { return head(P).x; }
};

template <class S, class Y = Momentum<S>>
struct Settled {
    Beat<S, Y> beat;
    Y start;
    Matrix<S, Y::size> monodromy;
    S residual;  // change of the motion over the measured beat, body lengths or rad
    S distance;  // Newton's step from the start, relative to the stride: how far the start is from settled
    S beats;     // beats integrated to find it
    S retry;     // place in the body's list of the retry that found it; 0 also where none was needed
};

template <class S, class Y, class M>
Settled<S, Y> select(const M& mask, const Settled<S, Y>& yes, const Settled<S, Y>& no) {
    const auto pick = [&](const S& a, const S& b) { return select(mask, a, b); };
    return {
        select(mask, yes.beat, no.beat),
        select(mask, yes.start, no.start),
        select(mask, BeatMap<S, Y>{yes.beat.end, yes.monodromy}, BeatMap<S, Y>{no.beat.end, no.monodromy}).monodromy,
        pick(yes.residual, no.residual),
        pick(yes.distance, no.distance),
        pick(yes.beats, no.beats),
        pick(yes.retry, no.retry)};
}

/// A brisk start for the search: above most gaits' speed, because Newton's method arrives from above in a few steps and
/// overshoots from below. Straight ahead at 0.29 (0.1 + sum of amplitudes) body lengths per beat.
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

/// Tolerances of Newton's last step, relative to the stride: with half the time steps, with all of them, in a retry,
/// and for a beat that counts as settled.
struct SettleTolerances {
    double coarse, fine, last, settled;
};
inline constexpr SettleTolerances settle_tolerances = {5e-2, 1e-3, 1e-5, 1e-7};
inline constexpr int quick_beats = 12;  // largest number of beats for undamped Newton with each number of time steps

/// Outcome of a search as a BeatStatus: 0 settled (it may yet be unstable), 1 unsettled, 3 diverged.
template <class S, class Y>
S search_status(const Settled<S, Y>& found, const S& speed) {
    using T = base_t<S>;
    const S most(std::numeric_limits<T>::max()), &turn = found.beat.displacement.heading;
    const auto finite = (abs(turn + found.beat.power + found.beat.loss + found.residual) <= most) &
                        ((abs(speed + found.beat.excursion) <= most) | (S(T(pi)) < abs(turn)));
    return select(finite, select(found.distance < S(T(settle_tolerances.settled)), S(0), S(1)), S(3));
}

/// Measure the beat from `start`, and how far it is from settled: the proof of a search.
template <class Body, class S, class Y>
HYPERTUNA_NOINLINE Settled<S, Y> prove(const Body& body, const Y& start, const Search<S, Y>& search) {
    const Beat<S, Y> beat = body.measure(start);
    const auto step = newton_step(body, BeatMap<S, Y>{beat.end, search.map.monodromy}, start);
    return {beat,
            start,
            search.map.monodromy,
            body.size(body.motion(beat.end - start)),
            body.size(step) / body.stride(start),
            search.beats + S(1),
            S(0)};
}

/// A state with the same number everywhere.
template <class Y, class S>
Y filled(const S& number) {
    Y state;
    for (int k = 0; k < Y::size; ++k) component(state, k) = number;
    return state;
}

/// Find the settled beat by Newton's method: with half the time steps first, then with all of them; one more beat
/// proves it. Where that fails, the search is retried as the body's list says.
template <class Body, class Y, class S = typename Body::Scalar>
Settled<S, Y> settle(const Body& body, const Y& guess, int max_beats) {
    using T = base_t<S>;
    constexpr SettleTolerances tolerance = settle_tolerances;
    Search<S, Y> search = search_from(body.swim(body.swim(guess, 2), 2), S(2));
    newton(body, 2, T(tolerance.coarse), false, quick_beats, search);
    // A gait that is too stiff for half the time steps begins again with all of them.
    search = search_from(select(search.distance < S(T(tolerance.coarse)), search.P, guess), search.beats);
    newton(body, 1, T(tolerance.fine), false, quick_beats, search);
    Settled<S, Y> out = prove(body, search.P, search);

    int tried = 0;
    for (const Retry& retry : Body::retries) {
        const auto open = !(out.distance < S(T(tolerance.settled)));
        if (!any(open)) break;
        Y start = retry.from == From::here ? search.P : retry.from == From::guess ? guess : filled<Y>(S(0));
        for (int k = 0; k < retry.wait; ++k) start = body.swim(start);
        // Gaits that are settled keep what they have: their search is closed from the start.
        Search<S, Y> again = search_from(start, out.beats + S(T(retry.wait)));
        again.distance = select(open, again.distance, S(0));
        newton(body, 1, T(tolerance.last), retry.damped, retry.from == From::here ? quick_beats : max_beats, again);
        Settled<S, Y> found = prove(body, again.P, again);
        found.retry = S(T(tried++));
        out = select(open, found, out);
    }
    return out;
}

/// Find the settled beat by waiting: swim `beats` plain beats, and measure one more. Its distance from the settled beat
/// follows from how the change per beat shrinks, as in a geometric series.
template <class Body, class Y, class S = typename Body::Scalar>
Settled<S, Y> wait(const Body& body, const Y& from, int beats) {
    using T = base_t<S>;
    Y start = from;
    S before(0);
    for (int k = 0; k < beats; ++k) {
        const Y end = body.swim(start);
        before = body.size(body.motion(end - start));
        start = end;
    }
    Search<S, Y> search = search_from(start, S(T(beats)));
    for (auto& row : search.map.monodromy.a)
        for (S& x : row) x = S(std::numeric_limits<T>::quiet_NaN());
    Settled<S, Y> out = prove(body, start, search);
    const S rounding(T(64) * std::numeric_limits<T>::epsilon());  // rounding: a change this small shrinks no more
    const S shrinks =
        max(S(1) - out.residual / max(before, S(T(1e-30))), select(out.residual < rounding, S(T(1e-3)), S(T(1e-6))));
    out.distance = out.residual / (shrinks * body.stride(start));
    return out;
}

/// A start from rest, followed toward a settled beat.
template <class S, class Y = Momentum<S>>
struct Approach {
    Y end;       // state after the last beat
    S distance;  // distance of `end` from the settled beat, relative to the stride
    S beats;     // number of beats swum
};

/// `arrived`: distance below which a motion has arrived at a settled beat, since its multipliers damp such
/// disturbances. `standing`: change per beat below which a motion elsewhere will not arrive.
struct ApproachTolerances {
    double arrived, standing;
};
inline constexpr ApproachTolerances approach_tolerances = {1e-2, 1e-6};

template <class S, class Y, class M>
Approach<S, Y> select(const M& mask, const Approach<S, Y>& yes, const Approach<S, Y>& no) {
    return {select(mask, yes.end, no.end), select(mask, yes.distance, no.distance), select(mask, yes.beats, no.beats)};
}

/// Swim plain beats from rest until the motion arrives at the settled beat that starts with `target`, settles
/// elsewhere, or has had `max_beats`. `stride_instants` of the table's instants make half a time step.
template <class Body, class Y, class S = typename Body::Scalar>
HYPERTUNA_NOINLINE Approach<S, Y> swim_toward(const Body& body, int stride_instants, const Y& target, int max_beats) {
    using T = base_t<S>;
    const S scale = S(1) / body.stride(target);
    const auto size = [&](const Y& a, const Y& b) { return scale * body.size(body.motion(a - b)); };
    Approach<S, Y> way{filled<Y>(S(0)), S(0), S(0)};
    way.distance = size(way.end, target);
    S change(std::numeric_limits<T>::infinity());
    for (int k = 0; k < max_beats; ++k) {
        // A comparison with NaN is false: a lane that diverges stops.
        const auto open =
            (S(T(approach_tolerances.arrived)) <= way.distance) & (S(T(approach_tolerances.standing)) <= change);
        if (!any(open)) break;
        const Y next = body.swim(way.end, stride_instants);
        change = size(next, way.end);
        way.end = select(open, next, way.end);
        way.beats = select(open, way.beats + S(1), way.beats);
        way.distance = size(way.end, target);
    }
    return way;
}

/// Follow a start from rest toward a settled beat: with half the time steps, and where that does not arrive, with all.
/// Newton's method jumps from one basin of attraction into another; plain beats do not.
template <class Body, class Y, class S = typename Body::Scalar>
Approach<S, Y> approach(const Body& body, const Y& target, int max_beats) {
    using T = base_t<S>;
    const Approach<S, Y> coarse = swim_toward(body, 2, target, max_beats);
    const auto arrived = coarse.distance < S(T(approach_tolerances.arrived));
    const Y remaining = select(arrived, filled<Y>(S(std::numeric_limits<T>::quiet_NaN())), target);
    return select(arrived, coarse, swim_toward(body, 1, remaining, max_beats));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
