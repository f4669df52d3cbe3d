/// Flow: the pressure that a pump's own speed adds in its cylinder, by the model, before a sensor shows it.
///
/// With the pressure u in the drive units and the servo's rate w, the pressure in the cylinder is p = u + G w. G
/// combines the drop along the line, which follows the oil's viscosity, with hammer, sqrt(L / C) of the line's
/// inertance and the compliance of the oil in the cylinder. The viscosity is learned from the changes of p that changes
/// of w caused, and begins as that of the thickest oil that flows.
#pragma once

#include "hypertuna/control/safety.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr double flow_learning = 0.003;  // weight of a new reading
inline constexpr double flow_prior = 3e7;  // Pa^2: weight of the thickest oil as the prior, against the first readings
inline constexpr double flow_lag =
    2.0;  // relative error of thick oil's viscosity, which reads too low because its pressure lags
inline constexpr double flow_held =
    0.37;  // part of the way from fill to soft limit that thick oil may hold in the units
inline constexpr double flow_unseen =
    0.5 * governor_swing;  // part of the rate of a bend that no sensor shows: it may swing twice as wide as it is sent
inline constexpr double flow_undamped =
    0.3;  // part of the rate of a bend that thin oil takes away: nothing damps its hammer

/// Viscosity relative to that of the thickest oil that flows, by least squares with forgetting.
template <class T>
struct Viscosity {
    T product, square;  // Pa^2: means of the thickest oil's change of pressure times the change read, and of its square
    T value;
    T largest;  // largest value to allow for
    T rate;     // part of a bend's rate that the viscosity allows
};

/// Take in a change of pressure: `read` by the sensor, and `thickest` as the thickest oil would have shown for the same
/// change of the servo's rate.
template <class T>
void learn(Viscosity<T>& viscosity, T thickest, T read) {
    viscosity.product += T(flow_learning) * (thickest * read - viscosity.product);
    viscosity.square += T(flow_learning) * (thickest * thickest - viscosity.square);
}

/// Compute the viscosity, once per tick. In thick oil the pressure lags behind the servo's rate by milliseconds, so
/// that fast beats show only half of the viscosity.
template <class T>
void weigh(Viscosity<T>& viscosity, T lowest, T own) {
    const T prior = T(flow_prior), found = (viscosity.product + prior) / (viscosity.square + prior);
    viscosity.value = clamp(found, lowest, T(1));
    viscosity.largest = min(T(1), viscosity.value * (T(1) + T(flow_lag) * viscosity.value));
    const T thin = clamp(T(4) * (T(1) - viscosity.value / own), T(0), T(1));
    viscosity.rate = T(1) - T(flow_undamped) * thin;
}

/// G, the pressure in the cylinder per rate of the servo, Pa s/rad.
template <class T>
T pressure_per_rate(const SupervisorModel<T>& model, T viscosity) {
    const T line = model.line * viscosity;
    return sqrt(line * line + model.hammer * model.hammer);
}

/// Target at which the angle of a critically damped servo changes by `change` over the next tick, rad.
template <class T>
T furthest_target(const Smoothing<T>& servo, const Follower<T>& now, T change) {
    return now.value + (change / servo.decay - now.change * (T(1) - servo.rate)) / (servo.rate * servo.rate);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
