/// Balance of soft joints: where moment and axial force of a section or a joint vanish.
#pragma once

#include "hypertuna/actuation/joint.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Root of a falling function between two bounds, by Newton's method from `at`; bisection replaces a step that leaves
/// the bounds. `function` takes and returns a Dual.
template <std::floating_point S, class F>
S falling_root(F function, S low, S high, S at) {
    for (int k = 0; k < 80; ++k) {
        Dual<S, 1> x(at);
        x.d[0] = S(1);
        const Dual<S, 1> y = function(x);
        if (!(y.v != S(0))) return at;
        (S(0) < y.v ? low : high) = at;
        S next = at - y.v / y.d[0];
        if (abs(next - at) <= S(1e-15) * (S(1) + abs(at))) return next;
        if (!(low < next && next < high)) next = S(0.5) * (low + high);
        at = next;
    }
    return at;
}

/// The same joint or section with dual numbers, for derivatives.
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
            j.law,
            {D(j.axis.stiffness), D(j.axis.buckling)}};
}
template <class D, std::floating_point S>
Section<D> lifted(const Section<S>& at) {
    return {D(at.length), D(at.area), D(at.second), D(at.sleeve)};
}

/// Bend and strain of a section.
template <class S>
struct Bent {
    S angle;   // rad
    S strain;  // strain of the axis
};

/// Root of two functions of two variables, by Newton's method from `at` in steps of at most `most`; `at` becomes the
/// root. `functions` takes and returns two duals. Returns whether the method converged.
template <std::floating_point S, class F>
bool newton_pair(F functions, const S (&most)[2], S (&at)[2]) {
    using D = Dual<S, 2>;
    for (int k = 0; k < 60; ++k) {
        D x(at[0]), y(at[1]);
        x.d[0] = y.d[1] = S(1);
        const auto [f, g] = functions(x, y);
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

/// Bend and strain where moment and axial force of a section vanish, by Newton's method from `near`; NaN where it does
/// not converge. `forces` returns both for a load in duals.
template <std::floating_point S, class Oil, class F>
Bent<S> newton_balance(const SoftJoint<S>& joint, const Section<S>& at, const StretchLimits<S>& limits, Bent<S> near,
                       const Oil& oil, F forces) {
    using D = Dual<S, 2>;
    const SoftJoint<D> soft = lifted<D>(joint);
    const Section<D> section = lifted<D>(at);
    S bent[2] = {near.angle, near.strain};
    const auto residual = [&](const D& angle, const D& strain) {
        return forces(section_load(soft, section, limits, angle, strain, oil));
    };
    if (newton_pair<S>(residual, {S(0.1), S(0.03)}, bent)) return {bent[0], bent[1]};
    return {std::numeric_limits<S>::quiet_NaN(), S(0)};
}

/// Strain of a section's axis at which its axial force vanishes at a given bend; the search begins at `near`.
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

/// Moment that bends a section whose axis keeps its length, N m: by the printed equations, or by partly corrected ones.
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

/// Moment that bends a section, N m, with its axis free where the law lets it shorten, plus `hold` (-1 to 1) times the
/// largest moment of friction. `strain` is a guess of the axis' strain and becomes that strain.
template <std::floating_point S>
S section_moment(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S angle, S hold, S& strain) {
    if (joint.law.printed || !joint.law.passive) return held_moment(joint, at, pressure, angle);
    strain = strain_under(joint, at, pressure, angle, strain);
    const JointLoad<S> load =
        section_load(joint, at, stretch_limits(joint.unit), angle, strain, given_pressures(pressure[0], pressure[1]));
    return joint_moment(load) + hold * joint_friction(load);
}

/// Bend and strain where the moments of a section balance. Friction holds against bending to the left (hold -1), to the
/// right (1), or not at all (0).
///
/// The search is Newton's method. Where that fails, or the law holds the axis, it is bisection, because the moment
/// falls as the angle grows. Bisection is bounded by the bends that use up 95 % of a muscle's length.
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
    const bool one_sided =
        joint.law.printed ||
        !joint.law.passive;  // the passive side does not resist: the joint bends only toward the higher pressure
    S high = one_sided && !(pressure[1] < pressure[0]) ? zero : used / joint.lever[0], strain(0);
    S low = one_sided && !(pressure[0] < pressure[1]) ? zero : -used / joint.lever[1];
    for (int k = 0; k < 8 * int(sizeof(S)); ++k) {
        const S middle = S(0.5) * (low + high), moment = section_moment(joint, at, pressure, middle, hold, strain);
        if (moment == zero) return {middle, strain};  // exactly straight at rest
        (zero < moment ? low : high) = middle;
    }
    return {S(0.5) * (low + high), strain};
}

/// Bend of a section after the pressures change from values at which it stood at the bend `before`: it stays there
/// where friction holds it.
template <std::floating_point S>
Bent<S> bend_from(const SoftJoint<S>& joint, const Section<S>& at, const S* pressure, S before) {
    const Bent<S> up = balance(joint, at, pressure, S(-1)), down = balance(joint, at, pressure, S(1));
    if (before <= up.angle) return up;
    if (down.angle <= before) return down;
    return {before, strain_under(joint, at, pressure, before, up.strain)};
}

/// One section equivalent to all of a joint's: its area and second moment make it bend and shorten under these
/// pressures as the sections do together. Moment and axial force are linear in area and second moment.
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
        return Bent<S>{joint_moment(load), joint_thrust(load)};  // moment and thrust, in the places of angle and strain
    };
    const Bent<S> none = forces(S(0), S(0)), bending = forces(S(0), S(1));
    sum.second = -none.angle / (bending.angle - none.angle);
    const Bent<S> bent = forces(S(0), sum.second), area = forces(S(1), sum.second);
    sum.area = -bent.strain / (area.strain - bent.strain);
    return sum;
}

template <class D, std::floating_point S>
Joint<D> lifted(const Joint<S>& j) {
    return {lifted<D>(j.soft), lifted<D>(j.section), j.limits, D(j.rest), D(j.viscosity), D(j.axial_viscosity)};
}

/// Bend, and strain relative to the filled joint, where the oil balances an external moment [N m], by Newton's method
/// from `near`.
template <std::floating_point S, class Oil>
Bent<S> joint_balance(const Joint<S>& joint, Bent<S> near, const Oil& oil, S moment = S(0)) {
    near.strain += joint.rest;
    Bent<S> bent = newton_balance(joint.soft, joint.section, joint.limits, near, oil, [&](const auto& load) {
        return Bent{joint_moment(load) + moment, joint_thrust(load)};
    });
    bent.strain -= joint.rest;
    return bent;
}

/// Pressures that hold a joint at a bend. Those of the two sides are equally far above and below the fill pressure, but
/// never so low that a braid goes slack, and never below a limit.
template <class S>
struct Holding {
    S strain;       // relative to the filled joint
    S offset;       // Pa: distance of both pressures from the fill pressure
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
/// Find the pressures that hold a joint at a bend, by Newton's method from `near`; the strain is NaN where none are
/// found.
template <std::floating_point S>
Holding<S> hold(const Joint<S>& joint, S angle, S fill, S lowest, const Holding<S>& near) {
    using D = Dual<S, 2>;
    const Joint<D> dual = lifted<D>(joint);
    const auto residual = [&](const D& offset, const D& strain) {
        const JointLoad<D> load = held_load(dual, D(angle), strain, offset, fill, lowest);
        return Bent<D>{joint_moment(load), joint_thrust(load)};
    };
    S found[2] = {near.offset, near.strain};
    const bool converged = newton_pair<S>(residual, {S(5e4), S(0.03)}, found);
    const JointLoad<S> load = held_load(joint, angle, found[1], found[0], fill, lowest);
    return {converged ? found[1] : std::numeric_limits<S>::quiet_NaN(),
            found[0],
            {load.pressure[0], load.pressure[1]},
            {load.volume[0], load.volume[1]}};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
