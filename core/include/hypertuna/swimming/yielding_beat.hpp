/// The beat of joints that yield: tabulated, measured, and settled.
#pragma once

#include "hypertuna/swimming/yielding_tangent.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A state with the pose of the nose.
template <class S, int D>
struct YieldingMotion {
    YieldingState<S, D> state;
    Pose<S> pose;

    template <class A>
    friend HYPERTUNA_INLINE YieldingMotion operator*(const A& a, const YieldingMotion& b) {
        return {a * b.state, a * b.pose};
    }
    friend HYPERTUNA_INLINE YieldingMotion operator+(const YieldingMotion& a, const YieldingMotion& b) {
        return {a.state + b.state, a.pose + b.pose};
    }
};

/// The beat from a state, measured. Springs do no mechanical power, moments that drive hinges do, each as a joint group
/// of its own: what dampers take is power less loss.
template <class S, class Law, int D>
Beat<S, YieldingState<S, D>> YieldingSwimmer<S, Law, D>::measure(const State& start) const {
    const int steps = table.instants / 2;
    const S step = period * S(base_t<S>(1.0 / steps)), zero(0), mean(base_t<S>(1.0 / steps));
    Beat<S, State> beat{};
    YieldingMotion<S, D> motion{start, {zero, zero, zero}};
    Swinging<S, D>& swing = *swings;
    for (int d = 0; d < D; ++d)
        swing.mean[d] = swing.sine[d] = swing.cosine[d] = swing.peak[d] = swing.damping[d] = zero;
    for (int k = 0; k < steps; ++k) {
        Hung<S, D> hung;
        const Moving<S, D> now = move(2 * k, motion.state, hung);
        const auto [s, c] = sincos(S(base_t<S>(2 * pi * k / steps)));
        for (int d = 0; d < D; ++d) {
            const S part = mean * motion.state.angle[d];
            swing.mean[d] += part, swing.sine[d] += (s + s) * part, swing.cosine[d] += (c + c) * part;
            swing.peak[d] = max(swing.peak[d], abs(motion.state.angle[d] + spring[d].rest));
            swing.damping[d] += mean * spring[d].drag(motion.state.angle[d]) * now.rate[d] * now.rate[d];
        }
        S accelerations[D];
        const Composite<S> body = bend(2 * k, motion.state, now, accelerations);
        const Symmetric<S> mobility = inverse(body.inertia);
        joint_torques(fish, Instant<S>{shape, acceleration, mobility, body.momentum}, now.xi, scratch.torque);
        const auto rate_of = [&](int i) { return yields.joint[2 * k * fish.links + i].rate; };
        measure_step(fish, joints, shape, now.xi, motion.pose, step, rate_of, k, scratch, beat);
        for (int d = 0; d < D; ++d) {
            const S &moment = yields.moment[2 * k][d], moment_power = moment * now.rate[d];
            beat.power += moment_power;
            beat.power_positive += max(moment_power, zero);
            scratch.sample[k].load = max(scratch.sample[k].load, abs(moment));
        }
        motion = runge_kutta_4(step, motion, [&](int half, const YieldingMotion<S, D>& m) {
            Twist<S> xi;
            const YieldingState<S, D> changes = rate(2 * k + half, m.state, xi);
            return YieldingMotion<S, D>{changes, pose_rate(m.pose, xi)};
        });
    }
    beat.end = motion.state;
    measure_end(steps, motion.pose, scratch.sample, beat);
    return beat;
}

/// Enter the beat of the prescribed joints, the yielding ones at rest, and the moments that drive these.
template <class S, class Law, int D>
HYPERTUNA_NOINLINE void tabulate_yielding(const Swimmer<S, Law>& fish, const JointShare<S>* joints,
                                          const Swing<S>* swings, const S& frequency, const Spring<S> (&spring)[D],
                                          const ShapeTable<S>& table, const YieldTable<S, D>& yields) {
    const Swimmer<S, Law> ahead{yields.link[0], fish.link, fish.water};
    for (int k = 0; k < table.instants; ++k) {
        JointMotion<S>* const joint = yields.joint + k * fish.links;
        const SinCos<S> clock = sincos(S(base_t<S>(2 * pi * k / table.instants)));
        joint_motion(fish.links, joints, swings, frequency, clock, joint);
        for (int d = 0; d < D; ++d) {
            yields.moment[k][d] = spring[d].active(clock);
            joint[yields.link[d]].angle += spring[d].rest;
        }
        tabulate(fish, joint, k, table);
        yields.ahead[k] = composite(ahead, table.shape + k * fish.links);
    }
}

/// The inertia that the free, straight body opposes to joints that turn alike, kg m^2: a spring of this inertia times
/// the square of a beat's angular frequency is in resonance with it, if it is that of a single joint.
template <class S, class Law>
S reduced_inertia(const Swimmer<S, Law>& fish, const int* hinges, int count, LinkShape<S>* shape,
                  LinkAcceleration<S>* acceleration, JointMotion<S>* joint) {
    for (int i = 0; i < fish.links; ++i) joint[i] = {S(0), S(0), S(0)};
    for (int h = 0; h < count; ++h) joint[hinges[h]].rate = S(1);
    hypertuna::shape(fish.links, fish.link, joint, shape, acceleration);
    const Composite<S> body = composite(fish, shape);  // b is what unit rates of the joints bring along
    const Twist<S> xi = inverse(body.inertia) * (S(-1) * body.momentum);
    return S(2) * kinetic_energy(fish, shape, xi);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
