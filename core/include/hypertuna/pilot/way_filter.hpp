/// Way filter: the Kalman filter of position, current and a complex factor on the velocity through the water.
///
/// In complex numbers, east + i north, the robot moves as p' = c + z u, where u is the velocity by gait and compass.
/// The size of z is the factor on the gait's speed, its angle the error of the compass. All noise is alike on both
/// axes, so a complex covariance of three states is the whole one.
#pragma once

#include "hypertuna/math/complex.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Position, current and factor z with the variances of each on one axis, and covariances E[e conj(f)] / 2.
template <class T>
struct WayFilter {
    Complex<T> position, current, factor;                          // m, m/s, 1
    T position_square, current_square, factor_square;              // variances
    Complex<T> position_current, position_factor, current_factor;  // covariances
};

/// Still water and a sound compass, with the standard deviations of each at the start.
template <class T>
WayFilter<T> init_filter(Complex<T> position, T position_error, T current_error, T factor_error) {
    WayFilter<T> f{};
    f.position = position, f.factor = {T(1), T(0)};
    f.position_square = position_error * position_error, f.current_square = current_error * current_error;
    f.factor_square = factor_error * factor_error;
    return f;
}

/// Position after the time `dt`, in which the robot swims `swum` by gait and compass.
template <class T>
Complex<T> position_after(const WayFilter<T>& f, T dt, Complex<T> swum) {
    return f.position + dt * f.current + f.factor * swum;
}

/// Carry the state on by that time and way: P <- F P F' + Q with the variances `noise` of position, current and factor;
/// F = 1 but for the row 1, dt, swum of the position.
template <class T>
void carry(WayFilter<T>& f, T dt, Complex<T> swum, const T (&noise)[3]) {
    f.position = position_after(f, dt, swum);
    const Complex<T> with_position =
        Complex<T>{f.position_square, T(0)} + dt * conj(f.position_current) + swum * conj(f.position_factor);
    f.position_current = f.position_current + Complex<T>{dt * f.current_square, T(0)} + swum * conj(f.current_factor);
    f.position_factor = f.position_factor + dt * f.current_factor + f.factor_square * swum;
    f.position_square = (with_position + dt * f.position_current + conj(swum) * f.position_factor).re + noise[0];
    f.current_square += noise[1], f.factor_square += noise[2];
}

/// Kalman update by a fix with the variance `noise` [m^2].
template <class T>
void take_fix(WayFilter<T>& f, Complex<T> fix, T noise) {
    const T share = T(1) / (f.position_square + noise), left = noise * share;
    const Complex<T> error = share * (fix - f.position);
    f.position = f.position + f.position_square * error;
    f.current = f.current + conj(f.position_current) * error;
    f.factor = f.factor + conj(f.position_factor) * error;
    f.current_square = max(f.current_square - share * square(f.position_current), T(1e-8));
    f.factor_square = max(f.factor_square - share * square(f.position_factor), T(1e-8));
    f.current_factor = f.current_factor - share * (conj(f.position_current) * f.position_factor);
    f.position_square *= left;
    f.position_current = left * f.position_current, f.position_factor = left * f.position_factor;
}

/// Begin anew at a fix: where the robot was carried, nothing is known of the way there.
template <class T>
void begin_at(WayFilter<T>& f, Complex<T> fix, T noise, T current_error) {
    f.position = fix, f.position_square = noise;
    f.position_current = f.position_factor = {T(0), T(0)};
    f.current_square += current_error * current_error;
}

/// Standard deviation of the velocity over ground [m/s], on one axis, at a velocity `u` through the water by gait and
/// compass: how fast the position error grows in a dive.
template <class T>
T drift_error(const WayFilter<T>& f, Complex<T> u) {
    const T with_both = (conj(u) * f.current_factor).re;
    return sqrt(max(T(0), f.current_square + square(u) * f.factor_square + T(2) * with_both));
}

/// Make current and factor uncertain together, by the variance `more` of the factor, so that the velocity over ground
/// at `u` stays known: their errors are -u e and e.
template <class T>
void doubt_factor(WayFilter<T>& f, Complex<T> u, T more) {
    f.current_square += more * square(u), f.factor_square += more;
    f.current_factor = f.current_factor - more * u;
}

/// Limits beyond which a compass is off: cosine and sine of the angle, 20 deg; number of standard deviations of that.
inline constexpr float off_cos = 0.93969f, off_sin = 0.34202f, off_deviations = 3;

/// Whether the factor lies outside the sector of small angles, significantly. Its distance from the sector is that from
/// the edge, or from the tip.
template <class T>
bool is_off(const WayFilter<T>& f) {
    const T a = f.factor.re, b = abs(f.factor.im);
    const T edge = T(off_cos) * b - T(off_sin) * a;
    const T distance = T(off_cos) * a + T(off_sin) * b < T(0) ? square(f.factor) : edge * edge;
    return T(0) < edge && T(off_deviations * off_deviations) * f.factor_square < distance;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
