/// A soft joint of round numbers for the tests: five 8 mm hoses a side.
#pragma once

#include "hypertuna/actuation/balance.hpp"

namespace hypertuna {

inline constexpr double E_MATRIX = 6 * 24e3;  // Pa
inline const Section<double> soft_sections[2] = {{0.03, 2e-3, 6e-7, 4e-3}, {0.03, 1.2e-3, 3e-7, 2e-3}};

inline SoftJoint<double> soft(double c1, double friction, double left = 0.012, double right = 0.012) {
    const double t = std::tan(37 * pi / 180);
    return {{8e-3, 5.6e-3, t * t, 0, {c1, 0}, {24e3, 0}, friction},
            5,
            {left, right},
            2,
            soft_sections,
            {false, {}, true, true},
            {0, 0}};
}

/// A copy of the joint for dynamics: its first section stands for all, at a fill pressure.
inline Joint<double> soft_joint(double fill, double friction = 0) {
    const double filled[2] = {fill, fill};
    Joint<double> joint{soft(40e3, friction), soft_sections[0], {}, 0, 0.01, 0.2};
    joint.limits = stretch_limits(joint.soft.unit);
    joint.rest = balance(joint.soft, joint.section, filled, 0.0).strain;
    return joint;
}

}  // namespace hypertuna
