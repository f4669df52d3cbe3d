/// Soft joint: sections of silicone that muscles on both sides bend and shorten, each for itself (Eqs 1-3 and 18).
///
/// Two strains describe a section of length S that bends by alpha: the stretch l of its axis, and the curvature
/// alpha / S. A body that shortens gets wider by 1/sqrt(l), so that at the lever w a muscle has the stretch
///     lambda = l -+ w q,  q = alpha / (S sqrt(l)),
/// and matrix of uniaxial energy W per volume stores A W(l) + W''(l) I q^2 / 2 per length, to second order in q.
/// Nothing holds the length: the axis shortens until its force vanishes. A muscle whose braid is slack, by shortening
/// or by suction, is a hose in the matrix alone. Side 0 is left; its muscles bend the joint counter-clockwise, by a
/// positive angle.
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

/// Equations that a joint bends by: the corrected ones, or the printed ones with what they still have wrong.
struct JointLaw {
    bool printed;
    Misprints misprints;  // for the printed ones only
    bool passive;         // whether the walls of the other side resist
    bool shortens;        // whether the axis is free to shorten
};

template <class S>
struct SoftJoint {
    DriveUnit<S> unit;  // its sleeve is that of the section
    S units;            // on each side
    S lever[2];         // m, of each side
    int sections;
    const Section<S>* section;
    JointLaw law;
};

/// Stretches between which a muscle's energy is used; beyond them its force goes on along a stiff line.
template <class S>
struct StretchLimits {
    S low, high;
    S stop;  // N, slope of the force beyond them
};
inline constexpr double shortest_stretch = 0.5;
inline constexpr double lumen_min = 0.05;  // lumen of a stretched muscle over that at rest at which it locks
inline constexpr double stop_factor = 20;  // stiffness beyond over that of the hose at rest
template <std::floating_point S>
StretchLimits<S> stretch_limits(const DriveUnit<S>& unit) {
    const S section = S(pi / 4) * (unit.outer * unit.outer - unit.inner * unit.inner);
    return {S(shortest_stretch), closing_stretch(unit, S(lumen_min)),
            S(stop_factor) * S(6) * (unit.hose.c1 + unit.hose.c2) * section};
}

/// A joint, or one of its sections, at a bend and a strain of its axis. Of each side: oil, and how it changes. A slack
/// muscle keeps its oil while it bends, and its walls carry the pressure.
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

/// `oil.at` returns the pressure of a side (0 or 1) at a volume; `oil.volume`, if it exists, the volume at a pressure.
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
    JointLoad<S> out;
    out.energy = L * (at.area * bar.energy + bending * bar.modulus);
    out.elastic = -L * bar.modulus * at.second * q * dq_angle;
    out.axial = -L * (at.area * bar.stress + bending * bar.change + bar.modulus * at.second * q * dq_strain);
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

/// Moment and axial force times length of oil and silicone, N m and J, without friction.
template <class S>
S joint_moment(const JointLoad<S>& load) {
    return load.elastic + load.pressure[0] * load.slope[0] + load.pressure[1] * load.slope[1];
}
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

/// Root of a falling function between two bounds: Newton's method, with bisection where it leaves them.
/// `of` takes a Dual and returns one.
template <std::floating_point S, class F>
S falling_root(F of, S low, S high, S at) {
    for (int k = 0; k < 80; ++k) {
        Dual<S, 1> x(at);
        x.d[0] = S(1);
        const Dual<S, 1> y = of(x);
        if (!(y.v != S(0))) return at;
        (S(0) < y.v ? low : high) = at;
        S next = at - y.v / y.d[0];
        if (abs(next - at) <= S(1e-15) * (S(1) + abs(at))) return next;
        if (!(low < next && next < high)) next = S(0.5) * (low + high);
        at = next;
    }
    return at;
}

/// A joint whose numbers are duals, to be differentiated.
template <class D, std::floating_point S>
SoftJoint<D> lifted(const SoftJoint<S>& j) {
    const DriveUnit<S>& u = j.unit;
    return {{D(u.outer),
             D(u.inner),
             D(u.tan2),
             D(u.sleeve),
             {D(u.hose.c1), D(u.hose.c2)},
             {D(u.matrix.c1), D(u.matrix.c2)},
             D(u.friction)},
            D(j.units),
            {D(j.lever[0]), D(j.lever[1])},
            0,
            nullptr,
            j.law};
}
template <class D, std::floating_point S>
Section<D> lifted(const Section<S>& at) {
    return {D(at.length), D(at.area), D(at.second), D(at.sleeve)};
}

/// Bend and strain of a section.
template <class S>
struct Bent {
    S angle;   // rad
    S strain;  // of the axis
};

/// Root of two functions of two numbers: Newton's method from near, in steps of at most `most`. `of` takes and returns
/// duals. Returns whether it converged.
template <std::floating_point S, class F>
bool newton_pair(F of, const S (&most)[2], S (&at)[2]) {
    using D = Dual<S, 2>;
    for (int k = 0; k < 60; ++k) {
        D x(at[0]), y(at[1]);
        x.d[0] = y.d[1] = S(1);
        const auto [f, g] = of(x, y);
        const S determinant = f.d[0] * g.d[1] - f.d[1] * g.d[0];
        const S step[2] = {(f.d[1] * g.v - g.d[1] * f.v) / determinant, (g.d[0] * f.v - f.d[0] * g.v) / determinant};
        const S scale = S(1) / max(S(1), max(abs(step[0]) / most[0], abs(step[1]) / most[1]));
        bool still = true;
        for (int i = 0; i < 2; ++i) {
            at[i] += scale * step[i];
            still = still && abs(step[i]) < S(1e-13) * (most[i] + abs(at[i]));
        }
        if (still) return true;
    }
    return false;
}

/// Bend and strain where moment and axial force of a section vanish. `forces` takes the load as duals and returns both.
/// NaN where Newton's method from near does not converge.
template <std::floating_point S, class Oil, class F>
Bent<S> newton_balance(const SoftJoint<S>& joint, const Section<S>& at, const StretchLimits<S>& limits, Bent<S> near,
                       const Oil& oil, F forces) {
    using D = Dual<S, 2>;
    const SoftJoint<D> soft = lifted<D>(joint);
    const Section<D> section = lifted<D>(at);
    S bent[2] = {near.angle, near.strain};
    const auto left = [&](const D& angle, const D& strain) {
        return forces(section_load(soft, section, limits, angle, strain, oil));
    };
    if (newton_pair<S>(left, {S(0.1), S(0.03)}, bent)) return {bent[0], bent[1]};
    return {std::numeric_limits<S>::quiet_NaN(), S(0)};
}

/// Strain of a section's axis at a bend, where its force vanishes.
template <std::floating_point S>
S strain_under(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S angle, S near) {
    if (!joint.law.shortens) return S(0);
    using D = Dual<S, 1>;
    const SoftJoint<D> dual = lifted<D>(joint);
    const Section<D> section = lifted<D>(at);
    const StretchLimits<S> limits = stretch_limits(joint.unit);
    const auto oil = given_pressures(pressure[0], pressure[1]);
    const auto thrust = [&](const D& strain) {
        return joint_thrust(section_load(dual, section, limits, D(angle), strain, oil));
    };
    return falling_root<S>(thrust, S(-0.6), S(1), near);
}

/// Moment that bends a section whose axis is held at its length, N m: printed equations, or corrected ones step by
/// step.
template <std::floating_point S>
S held_moment(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S angle) {
    DriveUnit<S> unit = joint.unit;
    unit.sleeve = at.sleeve;
    S moment = -S(6) * (unit.matrix.c1 + unit.matrix.c2) * at.second * angle / at.length;
    for (int s = 0; s < 2; ++s) {
        if (!joint.law.passive && !(S(0) < pressure[s])) continue;
        const S w = s == 0 ? joint.lever[s] : -joint.lever[s], stretch = S(1) - w * angle / at.length;
        const S force = joint.law.printed ? printed_pull(unit, pressure[s], stretch, joint.law.misprints)
                                          : pull(unit, pressure[s], stretch);
        moment += joint.units * w * force;
    }
    return moment;
}

/// Moment that bends a section, N m, its axis free, with part `hold` (-1 to 1) of what friction can hold. `strain` is
/// near that of the axis, and becomes it.
template <std::floating_point S>
S section_moment(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S angle, S hold, S& strain) {
    if (joint.law.printed || !joint.law.passive) return held_moment(joint, at, pressure, angle);
    strain = strain_under(joint, at, pressure, angle, strain);
    const JointLoad<S> load =
        section_load(joint, at, stretch_limits(joint.unit), angle, strain, given_pressures(pressure[0], pressure[1]));
    return joint_moment(load) + hold * joint_friction(load);
}

/// Where the moments of a section balance. Friction holds against bending to the left (hold -1), to the right (1), or
/// not at all (0).
///
/// Newton's method; where it fails, and by the equations that hold the axis, bisection: the moment falls as the angle
/// grows. By the printed equations the search ends where 95 % of a muscle's length would be used up.
template <std::floating_point S>
Bent<S> balance(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S hold) {
    if (joint.law.shortens) {
        const Bent<S> found =
            newton_balance(joint, at, stretch_limits(joint.unit), Bent<S>{S(0), S(0)},
                           given_pressures(pressure[0], pressure[1]), [&](const auto& load) {
                               return Bent{joint_moment(load) + hold * joint_friction(load), joint_thrust(load)};
                           });
        if (found.angle == found.angle) return found;
    }
    const S zero(0), used = S(0.95) * at.length;
    const bool one_sided = joint.law.printed || !joint.law.passive;  // nothing locks: one side, and only toward it
    S high = one_sided && !(pressure[1] < pressure[0]) ? zero : used / joint.lever[0], strain(0);
    S low = one_sided && !(pressure[0] < pressure[1]) ? zero : -used / joint.lever[1];
    for (int k = 0; k < 8 * int(sizeof(S)); ++k) {
        const S middle = S(0.5) * (low + high), moment = section_moment(joint, at, pressure, middle, hold, strain);
        if (moment == zero) return {middle, strain};  // exactly straight at rest
        (zero < moment ? low : high) = middle;
    }
    return {S(0.5) * (low + high), strain};
}

/// Bend that a section takes when the pressures come to these values from ones at which it stood at `before`: it stays
/// where friction holds it.
template <std::floating_point S>
Bent<S> bend_from(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S before) {
    const Bent<S> up = balance(joint, at, pressure, S(-1)), down = balance(joint, at, pressure, S(1));
    if (before <= up.angle) return up;
    if (down.angle <= before) return down;
    return {before, strain_under(joint, at, pressure, before, up.strain)};
}

/// One section that stands for all: with its area and second moment it bends and shortens under these pressures as the
/// sections do together. Both forces are linear in the two.
template <std::floating_point S>
Section<S> one_section(const SoftJoint<S>& joint, const S* pressure) {
    Section<S> sum{0, 0, 1, 0};
    Bent<S> whole{0, 0};
    for (int i = 0; i < joint.sections; ++i) {
        const Section<S>& at = joint.section[i];
        const Bent<S> bent = balance(joint, at, pressure, S(0));
        whole.angle += bent.angle, whole.strain += at.length * bent.strain;
        sum.length += at.length, sum.sleeve += at.length * at.sleeve;
    }
    whole.strain /= sum.length, sum.sleeve /= sum.length;
    const StretchLimits<S> limits = stretch_limits(joint.unit);
    const auto forces = [&](S area, S second) {
        const JointLoad<S> load = section_load(joint, {sum.length, area, second, sum.sleeve}, limits, whole.angle,
                                               whole.strain, given_pressures(pressure[0], pressure[1]));
        return Bent<S>{joint_moment(load), joint_thrust(load)};  // along angle and strain
    };
    const Bent<S> none = forces(S(0), S(0)), bending = forces(S(0), S(1));
    sum.second = -none.angle / (bending.angle - none.angle);
    const Bent<S> bent = forces(S(0), sum.second), area = forces(S(1), sum.second);
    sum.area = -bent.strain / (area.strain - bent.strain);
    return sum;
}

/// A joint for dynamics: one section, with viscosity, and the strain of the axis at the pressure that it is filled to.
template <class S>
struct Joint {
    SoftJoint<S> soft;  // without sections
    Section<S> section;
    StretchLimits<value_t<S>> limits;
    S rest;             // strain of the straight joint, filled
    S viscosity;        // N m s/rad against the angle
    S axial_viscosity;  // J s against the strain
};

/// The joint at a bend, and with its axis longer than filled and straight by a strain; `oil` as in section_load.
template <class S, class Oil>
HYPERTUNA_INLINE JointLoad<S> joint_load(const Joint<S>& joint, const S& angle, const S& strain, const Oil& oil) {
    return section_load(joint.soft, joint.section, joint.limits, angle, joint.rest + strain, oil);
}
/// With taut braids, as under a high pressure.
template <class S>
JointLoad<S> taut_load(const Joint<S>& joint, const S& angle, const S& strain) {
    const S infinite = std::numeric_limits<base_t<S>>::infinity();
    return joint_load(joint, angle, strain, given_pressures(infinite, infinite));
}

template <class D, std::floating_point S>
Joint<D> lifted(const Joint<S>& j) {
    return {lifted<D>(j.soft), lifted<D>(j.section), j.limits, D(j.rest), D(j.viscosity), D(j.axial_viscosity)};
}

/// Bend and strain, relative to the filled joint, that the oil holds under a moment of the surroundings, N m: Newton's
/// method from near.
template <std::floating_point S, class Oil>
Bent<S> joint_balance(const Joint<S>& joint, Bent<S> near, const Oil& oil, S moment = S(0)) {
    near.strain += joint.rest;
    Bent<S> bent = newton_balance(joint.soft, joint.section, joint.limits, near, oil, [&](const auto& load) {
        return Bent{joint_moment(load) + moment, joint_thrust(load)};
    });
    bent.strain -= joint.rest;
    return bent;
}

/// What holds a joint at a bend, the pressures of the two sides equally far above and below the one that it is filled
/// to, but none so low that a braid goes slack or a limit is passed.
template <class S>
struct Holding {
    S strain;       // relative to the filled joint
    S offset;       // Pa, of the pressures from the fill
    S pressure[2];  // Pa
    S volume[2];    // m^3
};
template <class S>
JointLoad<S> held_load(const Joint<S>& joint, const S& angle, const S& strain, const S& offset, base_t<S> fill,
                       base_t<S> lowest) {
    JointLoad<S> load = taut_load(joint, angle, strain);
    for (int s = 0; s < 2; ++s) {
        const S wanted = S(fill) + (s == 0 ? offset : -offset);
        load.pressure[s] = max(wanted, max(load.carried[s], S(lowest)));
    }
    return load;
}
/// Newton's method from near; a strain of NaN where it finds no pressures.
template <std::floating_point S>
Holding<S> hold(const Joint<S>& joint, S angle, S fill, S lowest, const Holding<S>& near) {
    using D = Dual<S, 2>;
    const Joint<D> dual = lifted<D>(joint);
    const auto left = [&](const D& offset, const D& strain) {
        const JointLoad<D> load = held_load(dual, D(angle), strain, offset, fill, lowest);
        return Bent<D>{joint_moment(load), joint_thrust(load)};
    };
    S found[2] = {near.offset, near.strain};
    const bool converged = newton_pair<S>(left, {S(5e4), S(0.03)}, found);
    const JointLoad<S> load = held_load(joint, angle, found[1], found[0], fill, lowest);
    return {converged ? found[1] : std::numeric_limits<S>::quiet_NaN(),
            found[0],
            {load.pressure[0], load.pressure[1]},
            {load.volume[0], load.volume[1]}};
}

/// A joint as a row of numbers, in this order: how it comes from Python.
inline constexpr const char* joint_columns[] = {
    "outer", "inner", "tan2",   "hose_c1", "hose_c2", "matrix_c1", "matrix_c2", "friction",  "units",
    "left",  "right", "length", "area",    "second",  "sleeve",    "rest",      "viscosity", "axial_viscosity",
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
                {false, {false, false}, true, true}};
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
