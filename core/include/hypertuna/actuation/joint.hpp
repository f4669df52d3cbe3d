/// Soft joint: independent sections of silicone that muscles on both sides bend and shorten (Eqs 1-3 and 18).
///
/// Two strains describe a section of length S that bends by alpha: the stretch l of its axis, and the curvature
/// alpha / S. A body that shortens gets wider by 1/sqrt(l), so that at the lever w a muscle has the stretch
///     lambda = l -+ w q,  q = alpha / (S sqrt(l)),
/// and matrix of uniaxial energy W per volume stores A W(l) + W''(l) I q^2 / 2 per length, to second order in q.
/// Only a film or pipes on the axis, if there are any, hold the length: the axis shortens until its force vanishes. A
/// muscle whose braid is slack, by shortening or by suction, is only a hose in the matrix. Side 0 is left; its muscles
/// bend the joint counter-clockwise, by a positive angle.
#pragma once

#include <limits>
#include <type_traits>

#include "hypertuna/actuation/muscle.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Section {
    S length;  // m, of the axis at rest
    S area;    // m^2 of matrix
    S second;  // m^4, its second moment of area
    S sleeve;  // m, thickness of the matrix around each hose: its share of the section
};

/// Elastic layer on the axis, such as a film or pipes, without stiffness against bending. It carries N = stiffness e at
/// the strain e of the axis; compressed beyond the strain `buckling` it buckles, and its force grows no more.
template <class S>
struct Axis {
    S stiffness;  // N, 0 for none
    S buckling;   // compressive strain, positive; 1 if it never buckles
};

/// Equations of a joint's bend: the corrected ones, or the paper's printed ones with some of their misprints.
struct JointLaw {
    bool printed;
    Misprints misprints;  // misprints, used by the printed equations only
    bool passive;         // whether the walls of the other side resist
    bool shortens;        // whether the axis is free to shorten
};

template <class S>
struct SoftJoint {
    DriveUnit<S> unit;  // `sleeve` is replaced by that of each section
    S units;            // number of drive units on each side
    S lever[2];         // m, distance of each side's muscles from the axis
    int sections;
    const Section<S>* section;
    JointLaw law;
    Axis<S> axis;
};

/// Range of stretches in which a muscle's energy function is used; beyond it the force continues along a stiff line.
template <class S>
struct StretchLimits {
    S low, high;
    S stop;  // N, slope of the force beyond the range
};
inline constexpr double shortest_stretch = 0.5;
inline constexpr double lumen_min = 0.05;  // a stretched muscle locks when its lumen is this fraction of that at rest
inline constexpr double stop_factor =
    20;  // stiffness beyond the range of stretches, relative to that of the hose at rest
template <std::floating_point S>
StretchLimits<S> stretch_limits(const DriveUnit<S>& unit) {
    const S section = S(pi / 4) * (unit.outer * unit.outer - unit.inner * unit.inner);
    return {S(shortest_stretch), closing_stretch(unit, S(lumen_min)),
            S(stop_factor) * S(6) * (unit.hose.c1 + unit.hose.c2) * section};
}

/// Energy, forces and oil of a joint, or of one of its sections, at a bend and a strain of its axis. A slack muscle
/// keeps its oil while it bends, and its walls carry the pressure.
template <class S>
struct JointLoad {
    S energy;       // J
    S elastic;      // N m, -dU/dangle
    S axial;        // J, -dU/dstrain
    S volume[2];    // m^3
    S pressure[2];  // Pa
    S slope[2];     // m^3/rad, dV/dangle: the moment that a unit of pressure makes
    S gain[2];      // m^3, dV/dstrain
    S friction[2];  // N m per Pa of contact pressure
    S carried[2];   // Pa that the walls carry, so that contact = pressure - carried
};

/// Pressures of both sides that do not depend on the volumes.
template <class S>
struct GivenPressures {
    S given[2];

    template <class T>
    HYPERTUNA_INLINE OilAt<T> at(int side, const T&) const {
        return {T(given[side]), T(0), T(0)};
    }
};
template <class S>
GivenPressures<S> given_pressures(const S& left, const S& right) {
    return {{left, right}};
}

/// Load of a section at a bend and a strain of its axis. `oil.at` returns the pressure of a side (0 or 1) at a volume;
/// `oil.volume`, if it exists, returns the volume at a pressure.
template <class S, class Oil>
HYPERTUNA_INLINE JointLoad<S> section_load(const SoftJoint<S>& joint, const Section<S>& at,
                                           const StretchLimits<value_t<S>>& limits, const S& angle, const S& strain,
                                           const Oil& oil) {
    DriveUnit<S> unit = joint.unit;
    unit.sleeve = at.sleeve;
    const S one(1), half(base_t<S>(0.5)), Pi = S(base_t<S>(pi)), l = max(S(base_t<S>(0.3)), one + strain);
    const S L = at.length, root = one / sqrt(l), q = angle * root / L, dq_angle = root / L, dq_strain = -half * q / l;
    const Stretched<S> bar = stretched(unit.matrix, l);
    const S bending = half * at.second * q * q;
    const S axial_strain = max(S(0) - joint.axis.buckling, strain), along = joint.axis.stiffness * axial_strain;
    JointLoad<S> out;
    out.energy = L * (at.area * bar.energy + bending * bar.modulus + along * (strain - half * axial_strain));
    out.elastic = -L * bar.modulus * at.second * q * dq_angle;
    out.axial = -L * (at.area * bar.stress + bending * bar.change + bar.modulus * at.second * q * dq_strain + along);
    for (int s = 0; s < 2; ++s) {
        const S w = s == 0 ? -joint.lever[s] : joint.lever[s], whole = l + w * q;
        const S stretch = min(max(S(limits.low), whole), S(limits.high)), beyond = whole - stretch;
        const S length = joint.units * L, by_angle = w * dq_angle, by_strain = one + w * dq_strain;
        const MuscleShape<S> braid = muscle_shape(unit, stretch);
        Wall<S> wall = walls(unit, stretch, braid.swelling);
        S open = Pi * braid.slope, lumen = swollen_lumen(unit, braid.swelling) + beyond * open;
        S force = wall.along + wall.across * braid.slope;
        out.carried[s] = wall.across / Pi;
        out.pressure[s] = oil.at(s, length * lumen).pressure;
        const auto slack = out.pressure[s] < out.carried[s];
        if (any(slack)) {
            S near = braid.swelling;
            if constexpr (requires { oil.volume(s, length); })
                near = near_swelling(unit, braid.swelling, wall,
                                     [&](const S& pressure) { return oil.volume(s, pressure) / length; });
            const SlackMuscle<S> loose = slack_muscle(unit, stretch, near, braid.swelling, slack, [&](const S& now) {
                const OilAt<S> at = oil.at(s, length * now);
                return OilAt<S>{at.pressure, at.slope * length, at.change * (length * length)};
            });
            wall.energy = select(slack, loose.energy, wall.energy);
            open = select(slack, S(0), open), force = select(slack, loose.along, force);
            lumen = select(slack, swollen_lumen(unit, loose.swelling), lumen);
            out.carried[s] = select(slack, loose.across / Pi, out.carried[s]);
            out.pressure[s] = select(slack, out.carried[s], out.pressure[s]);
        }
        const S pull = force + S(limits.stop) * beyond;
        out.energy = out.energy + length * (wall.energy + beyond * (force + half * S(limits.stop) * beyond));
        out.elastic = out.elastic - length * pull * by_angle;
        out.axial = out.axial - length * pull * by_strain;
        out.volume[s] = length * lumen;
        out.slope[s] = length * open * by_angle;
        out.gain[s] = length * open * by_strain;
        out.friction[s] = joint.units * unit.friction * contact(unit, stretch) * abs(w) * root;
    }
    return out;
}

/// Moment of oil and silicone, without friction, N m.
template <class S>
S joint_moment(const JointLoad<S>& load) {
    return load.elastic + load.pressure[0] * load.slope[0] + load.pressure[1] * load.slope[1];
}
/// Axial force of oil and silicone times the joint's length, without friction, J.
template <class S>
S joint_thrust(const JointLoad<S>& load) {
    return load.axial + load.pressure[0] * load.gain[0] + load.pressure[1] * load.gain[1];
}
/// Largest moment that friction can hold, N m. A slack braid does not rub.
template <class S>
S joint_friction(const JointLoad<S>& load) {
    return load.friction[0] * max(S(0), load.pressure[0] - load.carried[0]) +
           load.friction[1] * max(S(0), load.pressure[1] - load.carried[1]);
}

/// A joint for dynamics: one equivalent section with viscosity, and the strain of its axis at the fill pressure.
template <class S>
struct Joint {
    SoftJoint<S> soft;  // without sections
    Section<S> section;
    StretchLimits<value_t<S>> limits;
    S rest;             // strain of the straight joint, filled
    S viscosity;        // N m s/rad, of bending
    S axial_viscosity;  // J s, of the axis' strain
};

/// Load of a joint at a bend and a strain of its axis, relative to the straight, filled joint; `oil` as in
/// section_load.
template <class S, class Oil>
HYPERTUNA_INLINE JointLoad<S> joint_load(const Joint<S>& joint, const S& angle, const S& strain, const Oil& oil) {
    return section_load(joint.soft, joint.section, joint.limits, angle, joint.rest + strain, oil);
}
/// Load of a joint whose braids are taut, as under a high pressure.
template <class S>
JointLoad<S> taut_load(const Joint<S>& joint, const S& angle, const S& strain) {
    const S infinite = std::numeric_limits<base_t<S>>::infinity();
    return joint_load(joint, angle, strain, given_pressures(infinite, infinite));
}

/// Order of a joint's numbers in a row from Python.
inline constexpr const char* joint_columns[] = {
    "outer",    "inner", "tan2",      "hose_c1",         "hose_c2",        "matrix_c1",     "matrix_c2",
    "friction", "units", "left",      "right",           "length",         "area",          "second",
    "sleeve",   "rest",  "viscosity", "axial_viscosity", "axis_stiffness", "axis_buckling",
};
inline constexpr int joint_column_count = sizeof(joint_columns) / sizeof(joint_columns[0]);

template <class S>
Joint<S> read_joint(const S* row, const StretchLimits<S>& limits) {
    Joint<S> out{};
    out.soft = {{row[0], row[1], row[2], row[14], {row[3], row[4]}, {row[5], row[6]}, row[7]},
                row[8],
                {row[9], row[10]},
                0,
                nullptr,
                {false, {false, false}, true, true},
                {row[18], row[19]}};
    out.section = {row[11], row[12], row[13], row[14]};
    out.limits = limits;
    out.rest = row[15], out.viscosity = row[16], out.axial_viscosity = row[17];
    return out;
}
template <std::floating_point S>
Joint<S> read_joint(const S* row) {
    return read_joint(row, stretch_limits(read_joint(row, StretchLimits<S>{}).soft.unit));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
