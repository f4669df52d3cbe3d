/// Pump: one cylinder of the piston pump, driven by a slider-crank.
///
/// The crank stands at `neutral` from full retraction when its servo is at zero; positive servo angles push oil out.
#pragma once

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Pump {
    S area;     // m^2 of the piston
    S crank;    // m
    S rod;      // m, longer than the crank
    S neutral;  // rad of the crank from full retraction, servo at zero
    S start;    // m, the piston's travel from full retraction, servo at zero
    S chamber;  // m^3 in the cylinder, servo at zero
    S seal;     // N, friction of the piston's seals in motion, and the most that they hold at rest
};
#define HYPERTUNA_PUMP_COLUMNS "area", "crank", "rod", "neutral", "start", "chamber", "seal"

/// Travel of the piston from full retraction, and its derivative with respect to the crank's angle.
template <class S>
struct Travel {
    S travel;  // m
    S slope;   // m/rad
};

/// Exact slider-crank: crank (1 - cos) minus the length that the rod loses by leaning.
template <class S>
HYPERTUNA_INLINE Travel<S> travel(const Pump<S>& pump, const S& angle) {
    const auto [s, c] = sincos(pump.neutral + angle);
    const S lean = pump.crank * s, upright = sqrt(pump.rod * pump.rod - lean * lean);
    const S lost = lean * lean / (pump.rod + upright);
    return {pump.crank * (S(1) - c) - lost, lean - lean * pump.crank * c / upright};
}

/// Volume pushed out when the servo turns from zero to an angle, m^3.
template <class S>
HYPERTUNA_INLINE S displaced(const Pump<S>& pump, const S& angle) {
    return pump.area * (travel(pump, angle).travel - pump.start);
}

/// Derivative of the displaced volume with respect to the angle, m^3/rad; it is also the servo's torque per pressure.
template <class S>
HYPERTUNA_INLINE S displaced_slope(const Pump<S>& pump, const S& angle) {
    return pump.area * travel(pump, angle).slope;
}

/// Torque of the seals' friction on the servo, N m; `slope` is the piston's travel per angle.
template <class S>
HYPERTUNA_INLINE S sealing(const Pump<S>& pump, const S& slope) {
    return pump.seal * abs(slope);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
