/// Flow: the pressure that a pump's own speed adds in its cylinder, by the model, before a sensor shows it.
///
/// With u in the drive units and w the servo's rate, p = u + G w. G is of the drop along the line, which follows the
/// oil's viscosity, and of hammer, sqrt(L / C) of the line's inertance and the compliance of the oil in the cylinder.
/// The viscosity is learned from what changes of w did to p, and begins as that of the thickest oil that flows.
#pragma once

#include "hypertuna/control/safety.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr double flow_learning = 0.003;  // weight of a reading
inline constexpr double flow_prior = 3e7;       // Pa^2: of the thickest oil, against the first readings
inline constexpr double flow_lag = 2.0;         // of what thick oil's viscosity reads too low: its pressure lags
inline constexpr double flow_held = 0.37;     // of the room from fill to soft limit: what thick oil holds in the units
inline constexpr double flow_unseen = 0.55;   // of the rate of a bend that no sensor shows
inline constexpr double flow_undamped = 0.3;  // of the rate of a bend that thin oil loses: nothing damps its hammer

/// Viscosity relative to that of the thickest oil that flows, by least squares that forget.
template <class T>
struct Viscosity {
    T product, square;  // Pa^2: of the thickest oil's change of pressure, with that read and with itself
    T value;
    T largest;  // that it may be
    T rate;     // part of a bend's rate that it leaves
};

/// Take in a change of pressure beside the one that the thickest oil would have made of the change of the servo's rate.
template <class T>
void learn(Viscosity<T>& viscosity, T thickest, T read) {
    viscosity.product += T(flow_learning) * (thickest * read - viscosity.product);
    viscosity.square += T(flow_learning) * (thickest * thickest - viscosity.square);
}

/// Once per tick. In thick oil the pressure lags behind the rate by milliseconds, so that fast beats show half of it.
template <class T>
void weigh(Viscosity<T>& viscosity, T lowest, T own) {
    const T prior = T(flow_prior), found = (viscosity.product + prior) / (viscosity.square + prior);
    viscosity.value = clamp(found, lowest, T(1));
    viscosity.largest = min(T(1), viscosity.value * (T(1) + T(flow_lag) * viscosity.value));
    const T thin = clamp(T(4) * (T(1) - viscosity.value / own), T(0), T(1));
    viscosity.rate = T(1) - T(flow_undamped) * thin;
}

/// G, Pa s/rad.
template <class T>
T pressure_per_rate(const SupervisorModel<T>& model, T viscosity) {
    const T line = model.line * viscosity;
    return sqrt(line * line + model.hammer * model.hammer);
}

/// Furthest target that keeps the change of a critically damped servo's angle over the next tick to this, rad.
template <class T>
T furthest_target(const Smoothing<T>& servo, const Follower<T>& now, T change) {
    return now.value + (change / servo.decay - now.change * (T(1) - servo.rate)) / (servo.rate * servo.rate);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
