/// Soft joint: segments of silicone that muscles on both sides bend, each for itself (Eqs 1-3 and 18).
///
/// The neutral layer keeps its length. Where segment i bends by alpha_i the muscles of the side that it bends to have
/// the stretch 1 - w alpha_i / S_i and those of the other side 1 + w alpha_i / S_i: their walls resist too, which the
/// paper leaves out. Side 0 is left; its muscles bend the joint counter-clockwise, by a positive angle.
#pragma once

#include "hypertuna/actuation/muscle.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Segment {
    S length;     // m, of the neutral layer
    S stiffness;  // N m^2, E I of the matrix
};

/// Equations that a joint bends by: the corrected ones, or the printed ones with what they still have wrong.
struct JointLaw {
    bool printed;
    Misprints misprints;  // for the printed ones only
    bool passive;         // whether the walls of the other side resist
};

template <class S>
struct SoftJoint {
    DriveUnit<S> unit;
    S units;     // on each side
    S lever[2];  // m, of each side
    int segments;
    const Segment<S>* segment;
    JointLaw law;
};

/// Stretch of a side's muscles in a segment that bends by this angle.
template <class S>
S side_stretch(const SoftJoint<S>& joint, int i, int side, const S& angle) {
    const S strain = joint.lever[side] * angle / joint.segment[i].length;
    return side == 0 ? S(1) - strain : S(1) + strain;
}

/// Moment, N m, with which the muscles of one side bend a segment toward their own side, without friction.
template <class S>
S side_moment(const SoftJoint<S>& joint, int i, int side, const S& pressure, const S& angle) {
    const S stretch = side_stretch(joint, i, side, angle);
    const S force = joint.law.printed ? printed_pull(joint.unit, pressure, stretch, joint.law.misprints)
                                      : pull(joint.unit, pressure, stretch);
    return joint.units * joint.lever[side] * force;
}

/// Largest friction moment of one side in a segment, N m: C_f times the braid's contact pressure and area. The braid
/// lets go where the walls carry more than the pressure.
template <class S>
S friction_limit(const SoftJoint<S>& joint, int i, int side, const S& pressure, const S& angle) {
    const S stretch = side_stretch(joint, i, side, angle);
    const S grip = max(S(0), pressure - carried(joint.unit, stretch));
    return joint.units * joint.lever[side] * joint.unit.friction * contact(joint.unit, stretch) * grip;
}

/// Largest angle of a segment toward either side, rad: the stretched side keeps this part of its lumen.
template <class S>
S segment_reach(const SoftJoint<S>& joint, int i, const S& left) {
    const S lever = max(joint.lever[0], joint.lever[1]), reach = closing_stretch(joint.unit, left) - S(1);
    return min(reach, S(base_t<S>(0.95))) * joint.segment[i].length / lever;
}

/// Moment that bends a segment, N m: of the muscles of both sides at their pressures and of the matrix, with part
/// `hold` (-1 to 1) of what friction can hold.
template <class S>
S segment_moment(const SoftJoint<S>& joint, int i, const S* pressure, const S& angle, const S& hold) {
    S moment = -joint.segment[i].stiffness * angle / joint.segment[i].length;
    for (int side = 0; side < 2; ++side) {
        if (!joint.law.passive && !(S(0) < pressure[side])) continue;
        const S part = side_moment(joint, i, side, pressure[side], angle);
        moment += side == 0 ? part : -part;
        if (!joint.law.printed) moment += hold * friction_limit(joint, i, side, pressure[side], angle);
    }
    return moment;
}

/// Angle where the moments of a segment balance, rad. Friction holds against bending to the left (hold -1), to the
/// right (1), or not at all (0).
///
/// The moment falls as the angle grows, so there is one such angle: bisection, to the last digit. It ends where the
/// lumen of a stretched muscle closes; by the printed equations, where 95 % of a muscle's length would be used up.
template <std::floating_point S>
S balance(const SoftJoint<S>& joint, int i, const S* pressure, S hold) {
    const S zero(0), used = S(base_t<S>(0.95)) * joint.segment[i].length, reach = segment_reach(joint, i, zero);
    const bool free = joint.law.printed || !joint.law.passive;  // nothing locks: one side, and only toward it
    S high = !free ? reach : pressure[1] < pressure[0] ? used / joint.lever[0] : zero;
    S low = !free ? -reach : pressure[0] < pressure[1] ? -used / joint.lever[1] : zero;
    for (int k = 0; k < 8 * int(sizeof(S)); ++k) {
        const S middle = S(base_t<S>(0.5)) * (low + high);
        const S moment = segment_moment(joint, i, pressure, middle, hold);
        if (moment == zero) return middle;  // exactly straight at rest
        (zero < moment ? low : high) = middle;
    }
    return S(base_t<S>(0.5)) * (low + high);
}

/// Angle that a segment takes when the pressures come to these values from ones at which it stood at `before`: it stays
/// where friction holds it.
template <std::floating_point S>
S bend_from(const SoftJoint<S>& joint, int i, const S* pressure, S before) {
    return min(max(before, balance(joint, i, pressure, S(-1))), balance(joint, i, pressure, S(1)));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
