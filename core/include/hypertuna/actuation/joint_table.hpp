/// Joint table: all that the rest of a robot needs to know of a soft joint, tabulated over its angle.
///
/// The segments share each angle as they do where the pressure of one side alone holds the joint there. What is left of
/// the joint is one energy, one volume of each side and their friction; under pressure on one side it bends exactly as
/// its segments do, since all of them are then in balance. Between the points energy and volumes are cubic, so that the
/// moment, their derivative, does exactly the work that they say. Tables may come from elsewhere, finite elements say.
#pragma once

#include "hypertuna/actuation/joint.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// One point of a table. Side 0 is left: under pressure it bends the joint to positive angles.
template <class S>
struct JointPoint {
    S energy, energy_slope;        // J and N m: of matrix and walls, and its derivative
    S volume[2], volume_slope[2];  // m^3 and m^3/rad: oil in the muscles of each side, and its derivative
    S friction[2];                 // N m per Pa of contact pressure, of each side
    S carried[2];                  // Pa: what the walls of each side carry, so that contact = pressure - carried
};

template <class S>
struct JointTable {
    const JointPoint<S>* point;
    int points;
    S first, step;  // rad, angle of the first point and from point to point
    S viscosity;    // N m s/rad
    S stop;         // N m/rad, stiffness beyond the table's ends
};

/// A joint at one angle.
template <class S>
struct JointLoad {
    S elastic;      // N m, -dU/dangle
    S energy;       // J
    S volume[2];    // m^3
    S slope[2];     // m^3/rad, dV/dangle: the moment that a unit of pressure makes
    S friction[2];  // N m per Pa of contact pressure
    S carried[2];   // Pa
};

/// Cubic that has the values a, b and slopes da, db (per interval) at t = 0 and 1: its value and slope at t.
template <class S>
struct Cubic {
    S value, slope;
};
template <class S>
HYPERTUNA_INLINE Cubic<S> cubic(const S& a, const S& b, const S& da, const S& db, const S& t) {
    const S rise = b - a, square = da + db - rise - rise, bend = rise - da - square;
    return {a + t * (da + t * (bend + t * square)), da + t * (bend + bend + S(3) * t * square)};
}

/// The joint at an angle. Beyond the table's ends volumes and energy go on with the slope that they have there, and
/// the stop's stiffness comes in addition.
template <class S>
JointLoad<S> joint_load(const JointTable<S>& table, const S& angle) {
    const S last(static_cast<base_t<S>>(table.points - 1));
    const S place = (angle - table.first) / table.step;
    const S inside = min(max(S(0), place), last), beyond = (place - inside) * table.step;
    const int cell = static_cast<int>(inside), k = cell < table.points - 1 ? cell : table.points - 2;
    const S t = inside - S(static_cast<base_t<S>>(k));
    const JointPoint<S>&a = table.point[k], &b = table.point[k + 1];
    const auto at = [&](const S& va, const S& vb, const S& da, const S& db) {
        const auto [value, slope] = cubic(va, vb, da * table.step, db * table.step, t);
        return Cubic<S>{value + beyond * (slope / table.step), slope / table.step};
    };
    const auto [U, dU] = at(a.energy, b.energy, a.energy_slope, b.energy_slope);
    JointLoad<S> load;
    load.elastic = -(dU + table.stop * beyond);
    load.energy = U + S(base_t<S>(0.5)) * table.stop * beyond * beyond;
    for (int s = 0; s < 2; ++s) {
        const auto [V, dV] = at(a.volume[s], b.volume[s], a.volume_slope[s], b.volume_slope[s]);
        load.volume[s] = V;
        load.slope[s] = dV;
        load.friction[s] = a.friction[s] + t * (b.friction[s] - a.friction[s]);
        load.carried[s] = a.carried[s] + t * (b.carried[s] - a.carried[s]);
    }
    return load;
}

/// Moment of oil and silicone at rest, N m, without friction.
template <class S>
S joint_moment(const JointLoad<S>& load, const S* pressure) {
    return load.elastic + pressure[0] * load.slope[0] + pressure[1] * load.slope[1];
}
/// Largest moment that friction can hold, N m.
template <class S>
S joint_friction(const JointLoad<S>& load, const S* pressure) {
    return load.friction[0] * max(S(0), pressure[0] - load.carried[0]) +
           load.friction[1] * max(S(0), pressure[1] - load.carried[1]);
}

/// How much a segment's angle grows with the pressure of a side, rad/Pa, where its moments balance.
template <std::floating_point S>
S segment_response(const SoftJoint<S>& joint, int i, int side, const S* pressure, S angle) {
    const S zero(0), h = S(base_t<S>(3e-5)) * segment_reach(joint, i, zero);  // rad: for nine digits of the slope
    const S softening =
        segment_moment(joint, i, pressure, angle - h, zero) - segment_moment(joint, i, pressure, angle + h, zero);
    const S per_pascal =
        -joint.units * joint.lever[side] * lumen_slope(joint.unit, side_stretch(joint, i, side, angle));
    return (side == 0 ? per_pascal : -per_pascal) * (h + h) / softening;
}

/// Pressure of one side that holds the joint at an angle, Pa; `guess` is one that holds it at a smaller one.
///
/// Newton: the angle grows ever more slowly with the pressure, so the steps approach from below.
template <std::floating_point S>
S holding_pressure(const SoftJoint<S>& joint, int side, S angle, S guess) {
    S pressure[2] = {S(0), S(0)};
    pressure[side] = guess;
    for (int k = 0; k < 30; ++k) {
        S sum(0), slope(0);
        for (int i = 0; i < joint.segments; ++i) {
            const S bend = balance(joint, i, pressure, S(0));
            sum += bend;
            slope += segment_response(joint, i, side, pressure, bend);
        }
        const S step = (angle - sum) / slope;
        pressure[side] += step;
        if (abs(step) <= S(base_t<S>(1e-12)) * abs(pressure[side])) break;
    }
    return pressure[side];
}

/// Largest angle toward a side, rad, at which every segment keeps this part of the lumen on its stretched side, under a
/// pressure up to the highest.
template <std::floating_point S>
S joint_reach(const SoftJoint<S>& joint, int side, S left, S highest) {
    S low(0), high = highest, reach(0);
    for (int k = 0; k < 60; ++k) {
        S pressure[2] = {S(0), S(0)}, sum(0);
        pressure[side] = k == 0 ? highest : S(base_t<S>(0.5)) * (low + high);
        bool open = true;
        for (int i = 0; i < joint.segments; ++i) {
            const S bend = abs(balance(joint, i, pressure, S(0)));
            open = open && bend <= segment_reach(joint, i, left);
            sum += bend;
        }
        (open ? low : high) = pressure[side];
        if (open) reach = sum;
        if (open && k == 0) break;
    }
    return reach;
}

/// The joint's point where the pressure of one side alone holds it.
template <std::floating_point S>
JointPoint<S> tabulated(const SoftJoint<S>& joint, int side, S pressure) {
    S pressures[2] = {S(0), S(0)}, slope(0);
    pressures[side] = pressure;
    for (int i = 0; i < joint.segments; ++i)
        slope += segment_response(joint, i, side, pressures, balance(joint, i, pressures, S(0)));
    JointPoint<S> out{};
    S weight[2] = {S(0), S(0)};
    for (int i = 0; i < joint.segments; ++i) {
        const Segment<S>& segment = joint.segment[i];
        const S bend = balance(joint, i, pressures, S(0)), stiffness = segment.stiffness / segment.length;
        const S share = segment_response(joint, i, side, pressures, bend) / slope;  // dbend/dangle
        const S length = joint.units * segment.length;
        out.energy += S(base_t<S>(0.5)) * stiffness * bend * bend;
        out.energy_slope += share * stiffness * bend;
        for (int s = 0; s < 2; ++s) {
            const S stretch = side_stretch(joint, i, s, bend);
            const S rate = (s == 0 ? -share : share) * joint.lever[s] / segment.length;  // dstretch/dangle
            const S area = joint.units * joint.lever[s] * share * contact(joint.unit, stretch);
            out.energy += length * energy(joint.unit, stretch);
            out.energy_slope += length * rate * energy_slope(joint.unit, stretch);
            out.volume[s] += length * lumen(joint.unit, stretch);
            out.volume_slope[s] += length * rate * lumen_slope(joint.unit, stretch);
            out.friction[s] += joint.unit.friction * area;
            out.carried[s] += area * carried(joint.unit, stretch);
            weight[s] += area;
        }
    }
    for (int s = 0; s < 2; ++s) out.carried[s] = out.carried[s] / weight[s];
    return out;
}

/// Fill a table from -reach to reach, an odd number of points so that one is at rest.
template <std::floating_point S>
void tabulate(const SoftJoint<S>& joint, S reach, int points, JointPoint<S>* out) {
    const int rest = points / 2;
    const S step = reach / S(static_cast<base_t<S>>(rest));
    for (int side = 0; side < 2; ++side) {
        S pressure(0);
        const int sign = side == 0 ? 1 : -1;
        for (int k = 0; k <= rest; ++k) {
            const S angle = S(static_cast<base_t<S>>(sign * k)) * step;
            if (k > 0) pressure = holding_pressure(joint, side, angle, pressure);
            out[rest + sign * k] = tabulated(joint, side, pressure);
        }
    }
}

/// Stiffness of the joint at rest against its angle, N m/rad: of the matrix alone, and of the walls.
template <class S>
struct JointStiffness {
    S matrix, walls;
};
template <std::floating_point S>
JointStiffness<S> stiffness_at_rest(const SoftJoint<S>& joint) {
    const S none[2] = {S(0), S(0)}, zero(0);
    S sum(0), matrix(0);
    for (int pass = 0; pass < 2; ++pass)
        for (int i = 0; i < joint.segments; ++i) {
            const S h = S(base_t<S>(3e-5)) * segment_reach(joint, i, zero);
            const S whole =
                (segment_moment(joint, i, none, -h, zero) - segment_moment(joint, i, none, h, zero)) / (h + h);
            const S share = S(1) / (whole * sum);  // in the second pass: equal moments, so angles as the compliances
            if (pass == 0)
                sum += S(1) / whole;
            else
                matrix += share * share * joint.segment[i].stiffness / joint.segment[i].length;
        }
    return {matrix, S(1) / sum - matrix};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
