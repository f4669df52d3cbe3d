/// Stepping through time: fourth-order Runge-Kutta over a moving shape that is tabulated once.
///
/// The shape does not depend on how the body swims, so its instants are laid out beforehand: two a step, at its start
/// and at its middle. Memory is the caller's.
#pragma once

#include "hypertuna/swimming/swimmer.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Instants of a moving shape, two per time step. A beat repeats itself: instant `instants` is instant 0 again.
template <class S, class G = S>
struct ShapeTable {
    int links;
    int instants;
    LinkShape<G>* shape;                // instants x links
    LinkAcceleration<G>* acceleration;  // instants x links
    Symmetric<S>* mobility;             // instants
    Momentum<S>* momentum;              // instants

    HYPERTUNA_INLINE Instant<S, G> operator[](int k) const {
        k = k < instants ? k : k - instants;
        return {shape + k * links, acceleration + k * links, mobility[k], momentum[k]};
    }
};

/// Tabulate the body's mobility and shape momentum at instant k.
template <class S, class Law, class G>
HYPERTUNA_INLINE void weigh(const Swimmer<S, Law, G>& fish, int k, const ShapeTable<S, G>& table) {
    const Composite<S> body = composite(fish, table.shape + k * fish.links);
    table.mobility[k] = inverse(body.inertia);
    table.momentum[k] = body.momentum;
}

/// Tabulate the shape of the body at instant k from the joints' motion, with its mobility and shape momentum.
template <class S, class Law, class G>
void tabulate(const Swimmer<S, Law, G>& fish, const JointMotion<G>* joint, int k, const ShapeTable<S, G>& table) {
    shape(fish.links, fish.link, joint, table.shape + k * fish.links, table.acceleration + k * fish.links);
    weigh(fish, k, table);
}

/// Tabulate a whole beat of a harmonic gait. `joint` is scratch for one instant.
template <class S, class Law, class G>
HYPERTUNA_NOINLINE void tabulate_beat(const Swimmer<S, Law, G>& fish, const JointShare<G>* joints,
                                      const Swing<G>* swings, const G& frequency, JointMotion<G>* joint,
                                      const ShapeTable<S, G>& table) {
    for (int k = 0; k < table.instants; ++k) {
        const SinCos<G> clock = sincos(G(base_t<G>(2 * pi * k / table.instants)));
        joint_motion(fish.links, joints, swings, frequency, clock, joint);
        tabulate(fish, joint, k, table);
    }
}

/// Position of the nose and heading of the head's x axis, in the frame of the water.
template <class S>
struct Pose {
    S x, y, heading;  // m, m, rad counter-clockwise

    template <class A>
    friend HYPERTUNA_INLINE Pose operator*(const A& a, const Pose& b) {
        return {a * b.x, a * b.y, a * b.heading};
    }
    friend HYPERTUNA_INLINE Pose operator+(const Pose& a, const Pose& b) {
        return {a.x + b.x, a.y + b.y, a.heading + b.heading};
    }
};

template <class S>
HYPERTUNA_INLINE Pose<S> pose_rate(const Pose<S>& pose, const Twist<S>& xi) {
    const auto [s, c] = sincos(pose.heading);
    return {c * xi.x - s * xi.y, s * xi.x + c * xi.y, xi.z};
}

/// A point of the body, given in body axes, in the frame of the water.
template <class S, class G>
HYPERTUNA_INLINE Planar<S> place(const Pose<S>& pose, const Planar<G>& point) {
    const auto [s, c] = sincos(pose.heading);
    return {pose.x + c * point.x - s * point.y, pose.y + s * point.x + c * point.y, S(point.z)};
}

/// A swimming body: its momentum and its pose.
template <class S>
struct Motion {
    Momentum<S> momentum;
    Pose<S> pose;

    template <class A>
    friend HYPERTUNA_INLINE Motion operator*(const A& a, const Motion& b) {
        return {a * b.momentum, a * b.pose};
    }
    friend HYPERTUNA_INLINE Motion operator+(const Motion& a, const Motion& b) {
        return {a.momentum + b.momentum, a.pose + b.pose};
    }
};

/// One step of the classical Runge-Kutta method; rate(k, y) at the step's start, middle and end, k = 0, 1, 2.
template <class A, class Y, class Rate>
HYPERTUNA_INLINE Y runge_kutta_4(const A& step, const Y& y, const Rate& rate) {
    const A half = A(base_t<A>(0.5)) * step, sixth = A(base_t<A>(1.0 / 6)) * step, third = sixth + sixth;
    const Y k1 = rate(0, y);
    const Y k2 = rate(1, y + half * k1);
    const Y k3 = rate(1, y + half * k2);
    const Y k4 = rate(2, y + step * k3);
    return y + sixth * k1 + third * k2 + third * k3 + sixth * k4;
}

/// Momentum after one step that starts at instant k; `stride` instants make half a step.
template <class S, class Law, class G, class V>
HYPERTUNA_INLINE Momentum<V> swim_step(const Swimmer<S, Law, G>& fish, const ShapeTable<S, G>& table, int k, int stride,
                                       const S& step, const Momentum<V>& P) {
    return runge_kutta_4(step, P, [&](int half, const Momentum<V>& p) {
        const Instant<S, G> now = table[k + half * stride];
        return momentum_rate(fish, now, p, twist(now, p));
    });
}

/// Momentum and pose after one step that starts at instant k; `stride` instants make half a step.
template <class S, class Law, class G>
HYPERTUNA_INLINE Motion<S> swim_step(const Swimmer<S, Law, G>& fish, const ShapeTable<S, G>& table, int k, int stride,
                                     const S& step, const Motion<S>& motion) {
    return runge_kutta_4(step, motion, [&](int half, const Motion<S>& m) {
        const Instant<S, G> now = table[k + half * stride];
        const Twist<S> xi = twist(now, m.momentum);
        return Motion<S>{momentum_rate(fish, now, m.momentum, xi), pose_rate(m.pose, xi)};
    });
}

/// Momentum after one beat. With stride 2 every second instant is used, for half the steps.
template <class S, class Law, class G, class V>
HYPERTUNA_NOINLINE Momentum<V> swim_beat(const Swimmer<S, Law, G>& fish, const ShapeTable<S, G>& table, int stride,
                                         const S& period, Momentum<V> P) {
    const S step = period * S(base_t<S>(2.0 * stride / table.instants));
    for (int k = 0; k < table.instants; k += 2 * stride) P = swim_step(fish, table, k, stride, step, P);
    return P;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
