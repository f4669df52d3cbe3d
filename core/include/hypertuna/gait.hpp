/// Gait: how the joints are told to move, and how much of it they make.
#pragma once

#include "trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// One joint's motion at one instant.
template <class S>
struct JointMotion {
    S angle;         // rad, counter-clockwise
    S rate;          // rad/s
    S acceleration;  // rad/s^2
};

/// A joint group's share of a harmonic gait: alpha(t) = bias + amplitude sin(2 pi f t - lag).
template <class S>
struct Harmonic {
    S amplitude;  // rad
    S lag;        // rad, behind the gait's clock
    S bias;       // rad
    S bandwidth;  // Hz: first-order lag between the command and the joint; infinite for an ideal joint
};

/// Which group bends a joint and by which part of the group's angle; group -1 for a rigid joint.
template <class S>
struct JointShare {
    int group;
    S share;
};

/// A group's motion at the phase whose sine and cosine are `clock`.
///
/// A first-order lag turns A sin(p) into A (sin p - x cos p) / (1 + x^2) with x = f / bandwidth: the
/// amplitude falls to A / sqrt(1 + x^2) and comes atan(x) later. The bias passes unchanged.
template <class S>
HYPERTUNA_INLINE JointMotion<S> motion(const Harmonic<S>& group, const S& frequency, const SinCos<S>& clock) {
    const SinCos<S> lag = sincos(group.lag);
    const S sine = clock.sin * lag.cos - clock.cos * lag.sin;
    const S cosine = clock.cos * lag.cos + clock.sin * lag.sin;
    const S x = frequency / group.bandwidth;
    const S in_phase = group.amplitude / (S(1) + x * x);
    const S quadrature = -x * in_phase;
    const S omega = S(base_t<S>(2 * pi)) * frequency;
    const S swing = in_phase * sine + quadrature * cosine;
    return {group.bias + swing, omega * (in_phase * cosine - quadrature * sine), -omega * omega * swing};
}

template <class S>
HYPERTUNA_INLINE JointMotion<S> operator*(const S& share, const JointMotion<S>& group) {
    return {share * group.angle, share * group.rate, share * group.acceleration};
}

/// The motion of all joints at one phase. Joint i sits at the front of link i; joint 0 does not exist
/// and stays at rest.
template <class S>
void joint_motion(int links, const JointShare<S>* joints, const Harmonic<S>* groups, const S& frequency,
                  const SinCos<S>& clock, JointMotion<S>* out) {
    for (int i = 0; i < links; ++i) {
        const S zero(0);
        out[i] = joints[i].group < 0 ? JointMotion<S>{zero, zero, zero}
                                     : joints[i].share * motion(groups[joints[i].group], frequency, clock);
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
