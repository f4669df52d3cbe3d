/// One beat, measured: how far it carries the body and what it costs.
#pragma once

#include <limits>

#include "hypertuna/swimming/stepping.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Numbers of a beat. Each is declared here and listed in `numbers`, which code that copies them goes through.
template <class S>
struct BeatNumbers {
    Pose<S> displacement;  // displacement of the nose over the beat, in body axes at its start
    S power;               // W, mean of the sum of joint torque times joint rate
    S power_positive;      // W, mean of the same sum with every joint group's negative power counted as zero
    S loss;                // W, mean power that the water takes
    S torque_peak;         // N m, largest magnitude of any driven joint's torque
    // The next three describe the mean path. A beat that turns the body by more than half a circle has none: NaN.
    S excursion;  // m, of the tail tip across the mean path, peak to peak
    S arc;        // m, length of the mean path: of the circle at the nose's mean distance from the center
    S radius;     // m, mean distance of the nose from the center of the turn; infinite when straight
    S advance;    // m, motion of the nose along its axis over the beat, positive toward the head, as the speed is

    static constexpr S BeatNumbers::* numbers[] = {&BeatNumbers::power,     &BeatNumbers::power_positive,
                                                   &BeatNumbers::loss,      &BeatNumbers::torque_peak,
                                                   &BeatNumbers::excursion, &BeatNumbers::arc,
                                                   &BeatNumbers::radius,    &BeatNumbers::advance};
};

/// A measured beat: its numbers, and the state after it.
template <class S, class Y = Momentum<S>>
struct Beat : BeatNumbers<S> {
    static constexpr int count = sizeof(BeatNumbers<S>::numbers) / sizeof(S BeatNumbers<S>::*);
    static_assert(sizeof(BeatNumbers<S>) == sizeof(Pose<S>) + count * sizeof(S), "numbers lists all of them");
    Y end;
};

template <class S, class Y, class M>
Beat<S, Y> select(const M& mask, const Beat<S, Y>& yes, const Beat<S, Y>& no) {
    Beat<S, Y> beat;
    const Pose<S>&p = yes.displacement, &q = no.displacement;
    beat.displacement = {select(mask, p.x, q.x), select(mask, p.y, q.y), select(mask, p.heading, q.heading)};
    for (const auto number : beat.numbers) beat.*number = select(mask, yes.*number, no.*number);
    beat.end = select(mask, yes.end, no.end);
    return beat;
}

/// What is sampled at a step of a beat.
template <class S>
struct BeatSample {
    S load;          // largest magnitude of any driven joint's torque
    Planar<S> tail;  // position of the tail tip in the frame of the beat's start
    Planar<S> nose;
};

/// Scratch memory for measuring a beat.
template <class S>
struct BeatScratch {
    S* torque;              // links
    S* group_power;         // links
    BeatSample<S>* sample;  // steps
};

/// Largest magnitude of any driven joint's torque.
template <class S, class G>
HYPERTUNA_INLINE S largest_torque(int links, const JointShare<G>* joints, const S* torque) {
    S largest(0);
    for (int i = 1; i < links; ++i)
        if (joints[i].group >= 0) largest = max(largest, abs(torque[i]));
    return largest;
}

/// Signed distance of a point from the circle through the origin with this curvature whose tangent there is
/// (cos, sin); finite for a straight line too, where it is the offset to the left.
template <class S>
HYPERTUNA_INLINE S offset(const Planar<S>& point, const SinCos<S>& tangent, const S& curvature) {
    const S left = point.y * tangent.cos - point.x * tangent.sin;
    const S square = point.x * point.x + point.y * point.y;
    const S two(base_t<S>(2));
    return (two * left - curvature * square) / (S(1) + sqrt(S(1) - curvature * (two * left - curvature * square)));
}

/// Largest value of a periodic series, by the parabola through the highest sample and its neighbors.
template <class S, class At>
S peak(int count, const At& at) {
    S highest = at(0);
    for (int k = 0; k < count; ++k) {
        const S before = at((k + count - 1) % count), here = at(k), after = at((k + 1) % count);
        const S bend = here + here - before - after, difference = after - before;
        const S top = here + difference * difference / (S(base_t<S>(8)) * bend);
        // The parabola has its top within half a sample of a sample that neither neighbor exceeds.
        const auto summit = (abs(difference) <= bend) & (S(0) < bend);
        highest = max(highest, select(summit, top, here));
    }
    return highest;
}

/// Compute the mean path of a beat: its arc and radius, and the tail's excursion across it.
///
/// Positions a beat apart sample the mean path. Where the body turns by more than half a circle from one to the next,
/// two circles, traveled in opposite directions, fit the samples: the body spins, and has no path.
template <class S>
void measure_path(int steps, const BeatSample<S>* sample, BeatNumbers<S>& beat) {
    using T = base_t<S>;
    const Pose<S>& d = beat.displacement;
    const S chord = sqrt(d.x * d.x + d.y * d.y + S(T(1e-30)));
    const auto [half_sin, half_cos] = sincos(S(T(0.5)) * d.heading);
    // Over a beat the body turns by d.heading on a circle that the chord cuts: curvature 2 sin(turn/2) / chord.
    const S curvature = (half_sin + half_sin) / chord;
    // The circle leaves the origin along the chord, turned back by half the turn.
    const SinCos<S> tangent = {(d.y * half_cos - d.x * half_sin) / chord, (d.x * half_cos + d.y * half_sin) / chord};
    const auto across = [&](const Planar<S>& p) { return offset(p, tangent, curvature); };
    const auto tail = [&](int k) { return across(sample[k].tail); };
    beat.excursion = peak<S>(steps, tail) + peak<S>(steps, [&](int k) { return -tail(k); });
    S wander(0);
    for (int k = 0; k < steps; ++k) wander += across(sample[k].nose);
    wander = wander * S(T(1.0 / steps));
    // The circle through the origin is chord h / sin h long over the beat, h half the turn; the mean path lies `wander`
    // to the left of it.
    const S h = S(T(0.5)) * d.heading, square = h * h;
    const S near_straight = S(1) + square * (S(T(1.0 / 6)) + square * S(T(7.0 / 360)));
    beat.arc = chord * select(square < S(T(1e-6)), near_straight, h / half_sin) * (S(1) - curvature * wander);
    beat.radius = S(1) / abs(curvature) - select(curvature < S(0), -wander, wander);
    const auto sampled = abs(d.heading) <= S(T(pi));
    const S none(std::numeric_limits<T>::quiet_NaN());
    for (S* of_path : {&beat.arc, &beat.radius, &beat.excursion}) *of_path = select(sampled, *of_path, none);
}

/// Measure step k of a beat: the body's shape and motion, the torques in `scratch`, and `rate_of(i)` of the joints.
///
/// Mechanical power is that of all joints: net, and with the negative power of each joint group left out.
template <class S, class Law, class G, class Rate>
HYPERTUNA_INLINE void measure_step(const Swimmer<S, Law, G>& fish, const JointShare<G>* joints,
                                   const LinkShape<G>* shape, const Twist<S>& xi, const Pose<S>& pose, const S& step,
                                   const Rate& rate_of, int k, const BeatScratch<S>& scratch, BeatNumbers<S>& beat) {
    for (int i = 0; i < fish.links; ++i) scratch.group_power[i] = S(0);
    for (int i = 1; i < fish.links; ++i)
        if (joints[i].group >= 0) scratch.group_power[joints[i].group] += scratch.torque[i] * rate_of(i);
    for (int g = 0; g < fish.links; ++g) {
        beat.power += scratch.group_power[g];
        beat.power_positive += max(scratch.group_power[g], S(0));
    }
    beat.loss += water_loss(fish, shape, xi);
    beat.advance -= xi.x * step;
    const Link<G>& link = fish.link[fish.links - 1];
    const LinkShape<G>& last = shape[fish.links - 1];
    const Planar<G> joint = joint_position(last, link);
    scratch.sample[k] = {largest_torque(fish.links, joints, scratch.torque),
                         place(pose, Planar<G>{joint.x + link.length * last.c, joint.y + link.length * last.s, G(0)}),
                         {pose.x, pose.y, S(0)}};
}

/// Turn the sums and samples of a beat's steps into means and peaks.
template <class S>
void measure_end(int steps, const Pose<S>& displacement, const BeatSample<S>* sample, BeatNumbers<S>& beat) {
    const S mean(base_t<S>(1.0 / steps));
    beat.power = mean * beat.power;
    beat.power_positive = mean * beat.power_positive;
    beat.loss = mean * beat.loss;
    const S none(std::numeric_limits<base_t<S>>::quiet_NaN()), most(std::numeric_limits<base_t<S>>::max());
    const S highest = peak<S>(steps, [&](int k) { return sample[k].load; });
    beat.torque_peak = select(abs(beat.power) <= most, highest, none);  // of a diverged beat, of its first steps alone
    beat.displacement = displacement;
    measure_path(steps, sample, beat);
}

/// Swim one beat from momentum P and measure it.
template <class S, class Law, class G>
HYPERTUNA_NOINLINE Beat<S> measure_beat(const Swimmer<S, Law, G>& fish, const JointShare<G>* joints,
                                        const ShapeTable<S, G>& table, const S& period, const Momentum<S>& P,
                                        const BeatScratch<S>& scratch) {
    using T = base_t<S>;
    const int steps = table.instants / 2;
    const S step = period * S(T(1.0 / steps)), zero(0);
    Beat<S> beat{};
    Motion<S> motion{P, {zero, zero, zero}};
    for (int k = 0; k < steps; ++k) {
        const Instant<S, G> now = table[2 * k];
        const Twist<S> xi = twist(now, motion.momentum);
        joint_torques(fish, now, xi, scratch.torque);
        const auto rate_of = [&](int i) { return joint_rate(now.shape, i); };
        measure_step(fish, joints, now.shape, xi, motion.pose, step, rate_of, k, scratch, beat);
        motion = swim_step(fish, table, 2 * k, 1, step, motion);
    }
    beat.end = motion.momentum;
    measure_end(steps, motion.pose, scratch.sample, beat);
    return beat;
}

/// Mean speed along the path, m/s, forward positive; NaN for a body that spins.
template <class S>
HYPERTUNA_INLINE S mean_speed(const BeatNumbers<S>& beat, const S& frequency) {
    return frequency * select(beat.advance < S(0), -beat.arc, beat.arc);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
