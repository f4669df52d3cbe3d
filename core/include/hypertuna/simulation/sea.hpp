/// Sea: the robot's surroundings, in the world's axes: surface, bottom and current, and the quantities that the
/// navigation sensors measure.
#pragma once

#include "hypertuna/math/spatial.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A line from the nose to a fixed place, which pulls where it is taut. A line of length 0 holds the robot as a net or
/// the ground does.
template <class S>
struct Snag {
    S stiffness;      // N/m; 0 for none
    S length;         // m
    Vector<S> place;  // m
};

template <class S>
struct Sea {
    S density;        // kg/m^3
    S current[2];     // m/s toward east and north, at the surface
    S shear[2];       // 1/s: change of the current per depth, down to the bottom
    S bottom;         // m, depth
    S stiffness;      // N/m of the bottom
    Vector<S> field;  // direction of the Earth's magnetic field, as a unit vector
    S air;            // Pa, air pressure at the surface
    S gust[2];        // m/s toward east and north, current that the wind adds at the surface
    S gust_fade;      // 1/m: part of the gust's current that is lost per depth, down to none
    Snag<S> snag;     // what the robot is entangled in
};

/// Order of a sea's numbers in a row from Python.
inline constexpr const char* sea_columns[] = {"density", "current_east", "current_north", "shear_east",  "shear_north",
                                              "bottom",  "stiffness",    "field_east",    "field_north", "field_up",
                                              "air"};

template <class S, class T>
Sea<S> read_sea(const T* row) {
    const auto at = [row](int k) { return S(base_t<S>(row[k])); };
    return {at(0), {at(1), at(2)}, {at(3), at(4)}, at(5), at(6), {at(7), at(8), at(9)}, at(10), {S(0), S(0)}, S(0), {}};
}

inline constexpr double snag_stiffness = 200;  // N/m: the robot's thrust stretches the line by a centimeter
inline constexpr double snag_damping = 20;     // N s/m

/// Damping of the bottom, s/m: the bottom pushes (1 - damping rise) times as hard on what rises from it, and never
/// pulls.
inline constexpr double bottom_damping = 4;

/// Pressure at which a depth sensor shows zero, Pa: the standard atmosphere (ISO 2533).
inline constexpr double standard_air = 101325;

/// Depth that a sensor of absolute pressure shows at a height z, calibrated at the standard atmosphere. In the air it
/// shows the air's pressure.
template <class S>
HYPERTUNA_INLINE S depth_shown(const Sea<S>& sea, const S& z) {
    const S excess = sea.air - S(base_t<S>(standard_air));
    return max(S(0), S(0) - z) + excess / (sea.density * S(base_t<S>(gravity)));
}

/// Share of a body of this height that is below the surface, smooth; z is the height of its middle above the surface,
/// m.
template <class S>
HYPERTUNA_INLINE S submerged(const S& z, const S& height) {
    const S below = max(S(0), min(S(1), S(base_t<S>(0.5)) - z / height));
    return below * below * (S(3) - S(2) * below);
}

/// Velocity of the current at a height z, negative below the surface, m/s.
template <class S>
HYPERTUNA_INLINE Vector<S> current(const Sea<S>& sea, const S& z) {
    const S depth = max(S(0), min(sea.bottom, S(0) - z));
    const S windy = max(S(0), S(1) - sea.gust_fade * depth);
    return {sea.current[0] + sea.shear[0] * depth + windy * sea.gust[0],
            sea.current[1] + sea.shear[1] * depth + windy * sea.gust[1], S(0)};
}

/// Acceleration of the frame that moves with the current, for a body that rises: the current changes with the depth.
template <class S>
HYPERTUNA_INLINE Vector<S> current_rate(const Sea<S>& sea, const S& z, const S& rise) {
    const S depth = S(0) - z, sinking = select(S(0) < depth && depth < sea.bottom, S(0) - rise, S(0));
    const S fading = select(sea.gust_fade * depth < S(1), sea.gust_fade, S(0));
    return {(sea.shear[0] - fading * sea.gust[0]) * sinking, (sea.shear[1] - fading * sea.gust[1]) * sinking, S(0)};
}

/// Force of the bottom, upward, on a point at a height z that rises at a rate: stiff, without friction.
template <class S>
HYPERTUNA_INLINE S bottom_force(const Sea<S>& sea, const S& z, const S& rise) {
    const S dip = S(0) - z - sea.bottom;
    if (!(S(0) < dip)) return S(0);
    return sea.stiffness * dip * max(S(0), S(1) - S(base_t<S>(bottom_damping)) * rise);
}

/// Pull of a taut line on the nose, N; place and velocity are those of the nose in the world. Damping resists only what
/// stretches the line.
template <class S>
HYPERTUNA_INLINE Vector<S> snag_force(const Snag<S>& snag, const Vector<S>& place, const Vector<S>& velocity) {
    const Vector<S> off = place - snag.place;
    const S away = sqrt(dot(off, off)), stretch = away - snag.length;
    if (!(S(0) < stretch)) return {S(0), S(0), S(0)};
    const Vector<S> out = (S(1) / away) * off;
    const S pull = snag.stiffness * stretch + S(base_t<S>(snag_damping)) * dot(out, velocity);
    return (S(0) - max(S(0), pull)) * out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
