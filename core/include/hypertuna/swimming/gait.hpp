/// Gait: the commanded motion of the joints, and their response.
#pragma once

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// One joint's motion at one instant.
template <class S>
struct JointMotion {
    S angle;         // rad, counter-clockwise
    S rate;          // rad/s
    S acceleration;  // rad/s^2
};

/// Command of a harmonic gait to a joint group: alpha(t) = bias + amplitude sin(2 pi f t - lag).
template <class S>
struct Harmonic {
    S amplitude;       // rad
    S lag;             // rad, behind the gait's clock
    S bias;            // rad
    S bandwidth;       // Hz: first-order lag between the command and the joint; infinite for an ideal joint
    S phase_offset{};  // rad: further lag of the joint, at every frequency
};

/// Which group bends a joint and by which part of the group's angle; group -1 for a rigid joint.
template <class S>
struct JointShare {
    int group;
    S share;
};

/// Angle of a joint group as it responds: alpha = bias + sine sin(p) + cosine cos(p), p = 2 pi f t.
template <class S>
struct Swing {
    S bias, sine, cosine;  // rad
};

/// Response of a joint group to its command through a first-order lag.
///
/// The lag turns A sin(p) into A (sin p - x cos p) / (1 + x^2) with x = f / bandwidth: the amplitude falls
/// to A / sqrt(1 + x^2), and the motion comes atan(x) later. The phase offset delays it further; the bias is unchanged.
template <class S>
Swing<S> response(const Harmonic<S>& group, const S& frequency) {
    const auto [s, c] = sincos(group.lag + group.phase_offset);
    const S x = frequency / group.bandwidth;
    const S in_phase = group.amplitude / (S(1) + x * x), quadrature = -x * in_phase;
    return {group.bias, in_phase * c + quadrature * s, quadrature * c - in_phase * s};
}

/// Largest rate of any group over the beat, rad/s: 2 pi f times the group's amplitude after its lag.
template <class S>
S largest_rate(int groups, const Harmonic<S>* group, const S& frequency) {
    S amplitude(0);
    for (int g = 0; g < groups; ++g) {
        const S x = frequency / group[g].bandwidth;
        amplitude = max(amplitude, abs(group[g].amplitude) / sqrt(S(1) + x * x));
    }
    return S(base_t<S>(2 * pi)) * frequency * amplitude;
}

/// The motion of all joints where the sine and cosine of 2 pi f t are `clock`. Joint i sits at the front of link i;
/// joint 0 does not exist and stays at rest.
template <class S>
void joint_motion(int links, const JointShare<S>* joints, const Swing<S>* swings, const S& frequency,
                  const SinCos<S>& clock, JointMotion<S>* out) {
    const S omega = S(base_t<S>(2 * pi)) * frequency, zero(0);
    for (int i = 0; i < links; ++i) {
        if (joints[i].group < 0) {
            out[i] = {zero, zero, zero};
            continue;
        }
        const Swing<S>& w = swings[joints[i].group];
        const S swing = w.sine * clock.sin + w.cosine * clock.cos;
        const S rate = omega * (w.sine * clock.cos - w.cosine * clock.sin);
        const S share = joints[i].share;
        out[i] = {share * (w.bias + swing), share * rate, -share * omega * omega * swing};
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
