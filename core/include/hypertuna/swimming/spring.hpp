/// Spring, damper and stops of a hinge that yields, and the moment that drives it.
#pragma once

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// What gives a hinge its moment: a spring that pulls toward an angle of rest and may harden, a damper, and stops on
/// either side of the straight tail. Beyond a stop a stiff spring is added whose damping grows with its compression
/// (Hunt and Crossley, J. Appl. Mech. 42, 1975): no moment jumps there. Functions take angles from rest. A motor, a
/// muscle or a magnet adds a moment at the beat's frequency.
template <class S>
struct Spring {
    S stiffness, damping, rest;                // N m/rad, N m s/rad, rad
    S cubic;                                   // N m/rad^3
    S stop, stop_stiffness, stop_dissipation;  // rad, N m/rad, N m s/rad^2; all zero without stops
    S moment, moment_phase;                    // N m, rad: moment sin(2 pi f t - moment_phase) drives the hinge

    /// Angle beyond the stops, zero between them.
    template <class V>
    HYPERTUNA_INLINE V beyond(const V& angle) const {
        const V none(S(0)), bend = angle + rest;
        return max(bend - stop, none) + min(bend + stop, none);
    }
    /// Moment of the springs.
    template <class V>
    HYPERTUNA_INLINE V elastic(const V& angle) const {
        return -((stiffness + cubic * angle * angle) * angle + stop_stiffness * beyond(angle));
    }
    /// Damping coefficient at an angle, N m s/rad: the dampers' moment over the rate, reversed.
    template <class V>
    HYPERTUNA_INLINE V drag(const V& angle) const {
        return damping + stop_dissipation * abs(beyond(angle));
    }
    /// Moment of springs and dampers.
    template <class V>
    HYPERTUNA_INLINE V passive(const V& angle, const V& rate) const {
        const V give = stiffness + cubic * angle * angle;
        return -(give * angle + drag(angle) * rate) - stop_stiffness * beyond(angle);
    }
    /// Moment that drives the hinge, by sine and cosine of the gait's clock 2 pi f t.
    HYPERTUNA_INLINE S active(const SinCos<S>& clock) const {
        const auto [s, c] = sincos(moment_phase);
        return moment * (clock.sin * c - clock.cos * s);
    }
};

/// Numbers of a spring, in the order of its members.
inline constexpr const char* spring_columns[] = {"stiffness",      "damping",          "rest",   "cubic",       "stop",
                                                 "stop_stiffness", "stop_dissipation", "moment", "moment_phase"};
inline constexpr int spring_numbers = sizeof(spring_columns) / sizeof(spring_columns[0]);
static_assert(sizeof(Spring<double>) == spring_numbers * sizeof(double));

template <class S>
HYPERTUNA_INLINE S& component(Spring<S>& spring, int k) {
    S* const all[] = {
        &spring.stiffness,      &spring.damping,          &spring.rest,   &spring.cubic,       &spring.stop,
        &spring.stop_stiffness, &spring.stop_dissipation, &spring.moment, &spring.moment_phase};
    return *all[k];
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
