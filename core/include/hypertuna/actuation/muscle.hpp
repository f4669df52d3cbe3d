/// Muscle: a McKibben drive unit, a silicone hose in a braid that does not stretch, and the matrix that swells with it.
///
/// Everything follows from two functions of the stretch lambda = L / L0, both per length at rest: the energy of the
/// walls and the volume of the lumen. A wall's points keep their volume, r^2 = (R^2 + B) / lambda, and the braid sets
/// B. The pull is dU/dlambda - P dV/dlambda (virtual work); the radial balance of Cauchy stresses gives the same.
/// The braid can only pull. Where the pressure is too low to widen the walls to the braid's diameter, the braid is
/// slack, and B is such that the walls carry the whole pressure.
#pragma once

#include "hypertuna/math/log.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Two-term Mooney-Rivlin solid: W = C1 (I1 - 3) + C2 (I2 - 3), incompressible (Eq. 7).
template <class S>
struct Mooney {
    S c1, c2;  // Pa
};

/// A bar of a Mooney-Rivlin solid in uniaxial tension: energy per volume, nominal stress, and the first and second
/// derivative of the stress with respect to the stretch, all in Pa.
template <class S>
struct Stretched {
    S energy, stress, modulus, change;
};
template <class S>
HYPERTUNA_INLINE Stretched<S> stretched(const Mooney<S>& solid, const S& l) {
    const S one(1), two(2), i = one / l, i2 = i * i, i3 = i2 * i;
    return {solid.c1 * (l * l + two * i - S(3)) + solid.c2 * (i2 + two * l - S(3)),
            two * (solid.c1 * (l - i2) + solid.c2 * (one - i3)),
            two * solid.c1 * (one + two * i3) + S(6) * solid.c2 * i2 * i2,
            S(-12) * i2 * i2 * (solid.c1 + two * solid.c2 * i)};
}

template <class S>
struct DriveUnit {
    S outer, inner;  // m, diameters of the hose at rest
    S tan2;          // squared tangent of the braid's angle from the axis, snug on the hose at rest
    S sleeve;  // m, thickness of the matrix around the hose that swells with the braid; its stretching counts with the
               // joint
    Mooney<S> hose, matrix;
    S friction;  // coefficient between braid and hose
};

/// Energy of a wall at the stretch lambda and the swelling B, per length at rest, and its derivatives.
template <class S>
struct Wall {
    S energy;       // J/m
    S along;        // N, dU/dlambda at fixed B
    S across;       // Pa, dU/dB at fixed lambda: pi times the pressure that the wall carries
    S rigid;        // Pa/m^2, d across/dB
    S change;       // Pa/m^4, d rigid/dB
    S mixed;        // Pa, d along/dB
    S mixed_slope;  // Pa/m^2, d mixed/dB
};

/// Shape of a muscle with a taut braid at a stretch.
template <class S>
struct MuscleShape {
    S braid2;    // m^2, squared diameter of the braid
    S swelling;  // m^2, B
    S slope;     // m^2, dB/dlambda
};

/// Squared diameter of the braid, D^2 = d_o^2 (1/cos^2 theta0 - lambda^2) / tan^2 theta0, and the swelling it enforces;
/// written so that both are exact at rest.
template <class S>
HYPERTUNA_INLINE MuscleShape<S> muscle_shape(const DriveUnit<S>& unit, const S& stretch) {
    const S one(1), rest2 = unit.outer * unit.outer, quarter(base_t<S>(0.25));
    const S shortened = (one - stretch) * (one + stretch);
    const S braid2 = rest2 * (one + shortened / unit.tan2);
    return {braid2, quarter * (stretch * braid2 - rest2),
            quarter * rest2 * (one + (one - S(3) * stretch * stretch) / unit.tan2)};
}

/// Wall of silicone between the squared radii x1 and x2 at rest; its integrals over the thickness are in closed form.
/// `swelling_wall` is only what the swelling adds to the stretch, `wall` is both.
template <class S>
HYPERTUNA_INLINE Wall<S> swelling_wall(const Mooney<S>& solid, const S& x1, const S& x2, const S& stretch, const S& B) {
    const S dx = x2 - x1, inverse = S(1) / stretch, Pi = S(base_t<S>(pi));
    const S within = x1 + B, rim = x2 + B, over = S(1) / (within * rim), grown = B * dx, thinned = grown * over;
    const S logarithm = log_quotient(x2 * within, x1 * rim, grown);
    const S both = Pi * (solid.c1 * inverse + solid.c2 * stretch);
    const S by_stretch = Pi * (solid.c2 - solid.c1 * inverse * inverse);
    const S carried = logarithm + thinned, scale = dx * (over * over), sum = x1 + x2;
    const S rigid = scale * (S(2) * x1 * x2 + B * sum);
    return {both * B * logarithm,
            by_stretch * B * logarithm,
            both * carried,
            both * rigid,
            both * (scale * sum - S(2) * over * (sum + S(2) * B) * rigid),
            by_stretch * carried,
            by_stretch * rigid};
}
template <class S>
HYPERTUNA_INLINE Wall<S> wall(const Mooney<S>& solid, const S& x1, const S& x2, const S& stretch, const S& swelling) {
    const S section = S(base_t<S>(pi)) * (x2 - x1);
    const Wall<S> swollen = swelling_wall(solid, x1, x2, stretch, swelling);
    const Stretched<S> bar = stretched(solid, stretch);
    return {section * bar.energy + swollen.energy,
            section * bar.stress + swollen.along,
            swollen.across,
            swollen.rigid,
            swollen.change,
            swollen.mixed,
            swollen.mixed_slope};
}

/// The wall of the hose.
template <class S>
HYPERTUNA_INLINE Wall<S> hose_wall(const DriveUnit<S>& unit, const S& stretch, const S& swelling) {
    const S quarter(base_t<S>(0.25));
    return wall(unit.hose, quarter * unit.inner * unit.inner, quarter * unit.outer * unit.outer, stretch, swelling);
}
/// The swelling of the sleeve, the matrix around the hose.
template <class S>
HYPERTUNA_INLINE Wall<S> sleeve_wall(const DriveUnit<S>& unit, const S& stretch, const S& swelling) {
    const S radius = S(base_t<S>(0.5)) * unit.outer, rim = radius + unit.sleeve;
    return swelling_wall(unit.matrix, radius * radius, rim * rim, stretch, swelling);
}

/// Sum of the hose's wall and the sleeve's swelling.
template <class S>
HYPERTUNA_INLINE Wall<S> walls(const DriveUnit<S>& unit, const S& stretch, const S& swelling) {
    const Wall<S> hose = hose_wall(unit, stretch, swelling), sleeve = sleeve_wall(unit, stretch, swelling);
    return {hose.energy + sleeve.energy,          hose.along + sleeve.along,
            hose.across + sleeve.across,          hose.rigid + sleeve.rigid,
            hose.change + sleeve.change,          hose.mixed + sleeve.mixed,
            hose.mixed_slope + sleeve.mixed_slope};
}

/// Volume of the lumen per length at rest, m^2, at a swelling; 0 where the wall closes it.
template <class S>
HYPERTUNA_INLINE S swollen_lumen(const DriveUnit<S>& unit, const S& swelling) {
    return S(base_t<S>(pi)) * (S(base_t<S>(0.25)) * unit.inner * unit.inner + swelling);
}
/// Swelling B at which the lumen has this volume per length at rest, m^2.
template <class S>
S swelling_of(const DriveUnit<S>& unit, const S& lumen) {
    return lumen / S(base_t<S>(pi)) - S(base_t<S>(0.25)) * unit.inner * unit.inner;
}
/// Volume of the lumen per length at rest, m^2, under a taut braid (Eq. 6).
template <class S>
S lumen(const DriveUnit<S>& unit, const S& stretch) {
    return swollen_lumen(unit, muscle_shape(unit, stretch).swelling);
}
template <class S>
S lumen_slope(const DriveUnit<S>& unit, const S& stretch) {
    return S(base_t<S>(pi)) * muscle_shape(unit, stretch).slope;
}

/// Elastic energy of hose and sleeve per length at rest, J/m.
template <class S>
S energy(const DriveUnit<S>& unit, const S& stretch) {
    return walls(unit, stretch, muscle_shape(unit, stretch).swelling).energy;
}
/// Elastic pull of the walls under a taut braid, dU/dlambda, N.
template <class S>
S energy_slope(const DriveUnit<S>& unit, const S& stretch) {
    const MuscleShape<S> shape = muscle_shape(unit, stretch);
    const Wall<S> wall = walls(unit, stretch, shape.swelling);
    return wall.along + wall.across * shape.slope;
}

/// Pull of the muscle, N: contraction positive, without friction. Linear in the pressure.
template <class S>
S pull(const DriveUnit<S>& unit, const S& pressure, const S& stretch) {
    return energy_slope(unit, stretch) - pressure * lumen_slope(unit, stretch);
}

/// Pressure that hose and sleeve carry, Pa; the braid bears the rest of the oil's pressure.
template <class S>
S carried(const DriveUnit<S>& unit, const S& stretch) {
    return walls(unit, stretch, muscle_shape(unit, stretch).swelling).across / S(base_t<S>(pi));
}
/// Area that friction acts on, m^2: the section inside the braid. The paper gives none, and its C_f P_b is no force.
template <class S>
S contact(const DriveUnit<S>& unit, const S& stretch) {
    return S(base_t<S>(pi / 4)) * muscle_shape(unit, stretch).braid2;
}

/// Stretch of a lengthened muscle at which its lumen has only the fraction `left` of its volume at rest.
template <class S>
S closing_stretch(const DriveUnit<S>& unit, const S& left) {
    const S wanted = left * lumen(unit, S(1));
    S low(1), high = sqrt(S(1) + unit.tan2);
    // Beyond 54.7 degrees the lumen first grows with the stretch; it falls from lambda^2 = secant^2 / 3 on.
    low = max(low, high / sqrt(S(3)));
    for (int k = 0; k < 64; ++k) {
        const S middle = S(base_t<S>(0.5)) * (low + high);
        const auto open = wanted < lumen(unit, middle);
        low = select(open, middle, low);
        high = select(open, high, middle);
    }
    return low;
}

/// Pressure of the oil in the muscles of a side, and its derivatives with respect to their volume.
template <class S>
struct OilAt {
    S pressure;  // Pa
    S slope;     // Pa/m^3, not positive
    S change;    // Pa/m^6
};

/// First guess of slack_muscle: the swelling at which the oil has the pressure that the walls carry. The walls'
/// pressure is their second-order series about the braid's swelling `high`, at the swelling where the oil is at
/// atmosphere. `volume` returns the lumen at a pressure.
template <class S, class Volume>
HYPERTUNA_INLINE S near_swelling(const DriveUnit<S>& unit, const S& high, const Wall<S>& wall, const Volume& volume) {
    const S inverse = S(base_t<S>(1 / pi)), half = S(base_t<S>(0.5));
    const S narrow = S(base_t<S>(0.01)) * swollen_lumen(unit, S(0));
    const auto swelling = [&](const S& pressure) {
        return min(high, swelling_of(unit, max(narrow, volume(pressure))));
    };
    const S back = swelling(S(0)) - high;
    return swelling((wall.across + back * (wall.rigid + half * wall.change * back)) * inverse);
}

/// A slack muscle: its swelling, and what its walls store, pull and carry there.
template <class S>
struct SlackMuscle {
    S swelling;  // m^2
    S energy;    // J/m
    S along;     // N
    S across;    // Pa
};

/// Walls after a little more swelling, by their second-order series.
template <class S>
HYPERTUNA_INLINE SlackMuscle<S> swollen_by(const Wall<S>& wall, const S& swelling, const S& more) {
    const S half = S(base_t<S>(0.5)), third = S(base_t<S>(1.0 / 3));
    return {swelling + more,
            wall.energy + more * (wall.across + half * more * (wall.rigid + third * wall.change * more)),
            wall.along + more * (wall.mixed + half * wall.mixed_slope * more),
            wall.across + more * (wall.rigid + half * wall.change * more)};
}

/// Find the swelling at which the walls of a slack muscle carry the pressure of the oil; `high` is that of a taut
/// braid.
///
/// Halley's method from `near`, in steps of at most twice Newton's; bisection replaces a step that leaves the bracket,
/// because the walls' pressure minus the oil's rises with the swelling. `oil` returns the pressure at a lumen. Lanes
/// that are not slack get a meaningless result.
template <class S, class Slack, class Oil>
HYPERTUNA_INLINE SlackMuscle<S> slack_muscle(const DriveUnit<S>& unit, const S& stretch, const S& near, S high,
                                             Slack slack, const Oil& oil) {
    const S Pi = S(base_t<S>(pi)), inverse = S(base_t<S>(1 / pi)), two(2), half = S(base_t<S>(0.5));
    const S closed = S(base_t<S>(0.25)) * unit.inner * unit.inner;
    S low = -closed, swelling = near;
    SlackMuscle<S> found{near, S(0), S(0), S(0)};
    for (int k = 0; k < 60 && any(slack); ++k) {
        const Wall<S> wall = walls(unit, stretch, swelling);
        const OilAt<S> at = oil(swollen_lumen(unit, swelling));
        const S left = wall.across * inverse - at.pressure, slope = wall.rigid * inverse - Pi * at.slope;
        const S change = wall.change * inverse - Pi * Pi * at.change, square = slope * slope;
        const S step = two * left * slope / max(two * square - left * change, square), bent = step * change;
        const auto above = S(0) < left;
        low = select(above, low, swelling), high = select(above, swelling, high);
        const S next = swelling - step;
        // Done: the error that the step leaves is (step change / slope)^2 times the step; in the derivatives of a dual
        // it is of the order of the step squared.
        const auto done = (abs(step) <= S(base_t<S>(std::same_as<S, value_t<S>> ? 1e-5 : 1e-8)) * closed) &
                          (bent * bent * abs(step) <= S(base_t<S>(1e-15)) * closed * square);
        const auto inside = (low < next) & (next < high);
        const SlackMuscle<S> solution = swollen_by(wall, swelling, S(0) - step);
        found = {select(slack, solution.swelling, found.swelling), select(slack, solution.energy, found.energy),
                 select(slack, solution.along, found.along), select(slack, solution.across, found.across)};
        swelling = select(done | inside, next, half * (low + high));
        slack = slack & !done;
    }
    return found;
}

/// Which of the paper's misprints the printed equations keep.
struct Misprints {
    bool nominal_stress;  // Eqs 10-11: the deviatoric stress times the section's stretch, yet on the deformed section
    bool inner_balance;   // Eqs 12-13: hoop balance on the inner diameter, with the thickness at rest
};

/// Axial force of a wall by the paper's equations, and the pressure that is left outside the wall.
template <class S>
struct PrintedWall {
    S force;    // N
    S outside;  // Pa
};

/// A wall by Eqs 8-13 and 17: one stress for its whole thickness, sigma_33 = -P. D_o is the deformed outer diameter.
template <class S>
PrintedWall<S> printed_wall(const Mooney<S>& solid, const S& d_i, const S& d_o, const S& D_o, const S& stretch,
                            const S& pressure, Misprints misprints) {
    const S one(1), two(2), quarter_pi(base_t<S>(pi / 4));
    const S section = quarter_pi * (d_o * d_o - d_i * d_i) / stretch;  // V_t / L
    const S D_i = sqrt(D_o * D_o - section / quarter_pi);
    const S l1 = stretch, l2 = D_i / d_i, l3 = one / (l1 * l2);
    const auto deviator = [&](const S& l) {
        return two * (solid.c1 * (l * l - l3 * l3) - solid.c2 * (one / (l * l) - one / (l3 * l3)));
    };
    const S along = deviator(l1) * (misprints.nominal_stress ? l2 * l3 : one) - pressure;
    const S hoop = deviator(l2) * (misprints.nominal_stress ? l1 * l3 : one) - pressure;
    const S balance = (pressure * D_i - hoop * (D_o - D_i)) / D_o;
    return {along * section, misprints.inner_balance ? pressure - hoop * (d_o - d_i) / D_i : balance};
}

/// Pull of the muscle by the paper's Eqs 4-17, without friction: C_f P_b is no force as long as it lacks an area.
///
/// P_s of Eq. 14 is the pressure inside the sleeve that leaves none outside it; no equation contains the sleeve's axial
/// force. cos^2 theta = L^2 / b^2 is read as L^2 / c^2.
template <class S>
S printed_pull(const DriveUnit<S>& unit, const S& pressure, const S& stretch, Misprints misprints) {
    const S zero(0), one(1), two(2), half_pi = S(base_t<S>(pi / 2)), quarter_pi(base_t<S>(pi / 4));
    const S braid2 = muscle_shape(unit, stretch).braid2, D_o = sqrt(braid2);
    const auto hose = printed_wall(unit.hose, unit.inner, unit.outer, D_o, stretch, pressure, misprints);
    S braid = hose.outside;
    if (zero < unit.sleeve) {
        const S rim = unit.outer + two * unit.sleeve;
        const S D_rim = sqrt(braid2 + (rim * rim - unit.outer * unit.outer) / stretch);
        const auto outside = [&](const S& P) {
            return printed_wall(unit.matrix, unit.outer, rim, D_rim, stretch, P, misprints).outside;
        };
        const S none = outside(zero);
        braid = braid + none / (outside(one) - none);  // P_b = P_t - P_s; the pressure outside is linear in P_s
    }
    const S tan2 = unit.tan2 * braid2 / (unit.outer * unit.outer * stretch * stretch);
    const S inside = quarter_pi * (braid2 - (unit.outer * unit.outer - unit.inner * unit.inner) / stretch);  // V_f / L
    return half_pi * braid2 * braid / tan2 - inside * pressure + hose.force;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
