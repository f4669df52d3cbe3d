/// Compass: the angle by which it is off, from fixes alone.
///
/// The filter of the way begins with a sound compass, so it takes an error for a current for long. This one begins with
/// any angle of the compass and a strong current. In complex numbers, east + i north, the way is p' = c + z u, where u
/// is the velocity by gait and compass: z has the angle of the error, and the factor on the speed as its size. All
/// noise is alike on both axes, so a complex covariance of three states is the whole one.
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct Complex {
    T re, im;
};

template <class T>
Complex<T> operator+(Complex<T> a, Complex<T> b) {
    return {a.re + b.re, a.im + b.im};
}
template <class T>
Complex<T> operator*(T a, Complex<T> b) {
    return {a * b.re, a * b.im};
}
template <class T>
Complex<T> operator*(Complex<T> a, Complex<T> b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
template <class T>
Complex<T> conj(Complex<T> a) {
    return {a.re, -a.im};
}
template <class T>
T square(Complex<T> a) {
    return a.re * a.re + a.im * a.im;
}

/// Position, current and factor z with the variances of each on one axis, and covariances E[e conj(f)] / 2.
template <class T>
struct CompassState {
    Complex<T> position, current, factor;                          // m, m/s, 1
    T position_square, current_square, factor_square;              // variances
    Complex<T> position_current, position_factor, current_factor;  // covariances
};

/// Standard deviation of the factor at the start, in which any angle has room; the same of the current, over the usual.
inline constexpr float any_factor = 1.5f, any_current = 3;

template <class T>
CompassState<T> init_compass(Complex<T> position, T position_error, T current_error) {
    const T current = T(any_current) * current_error;
    CompassState<T> compass{};
    compass.position = position, compass.factor = {T(1), T(0)};
    compass.position_square = position_error * position_error, compass.current_square = current * current;
    compass.factor_square = T(any_factor * any_factor);
    return compass;
}

/// Carry the state on over the time `dt`, in which it swam `swum` by gait and compass: P <- F P F' + Q with the
/// variances `noise` of position, current and factor, F = 1 but for the row 1, dt, swum of the position.
template <class T>
void carry(CompassState<T>& c, T dt, Complex<T> swum, const T (&noise)[3]) {
    c.position = c.position + dt * c.current + swum * c.factor;
    const Complex<T> with_position =
        Complex<T>{c.position_square, T(0)} + dt * conj(c.position_current) + swum * conj(c.position_factor);
    c.position_current = c.position_current + Complex<T>{dt * c.current_square, T(0)} + swum * conj(c.current_factor);
    c.position_factor = c.position_factor + dt * c.current_factor + c.factor_square * swum;
    c.position_square = (with_position + dt * c.position_current + conj(swum) * c.position_factor).re + noise[0];
    c.current_square += noise[1], c.factor_square += noise[2];
}

/// Kalman update by a fix with the variance `noise` [m^2].
template <class T>
void take_fix(CompassState<T>& c, Complex<T> fix, T noise) {
    const T share = T(1) / (c.position_square + noise);
    const Complex<T> error = share * (fix + T(-1) * c.position);
    c.position = c.position + c.position_square * error;
    c.current = c.current + conj(c.position_current) * error;
    c.factor = c.factor + conj(c.position_factor) * error;
    c.current_square = max(c.current_square - share * square(c.position_current), T(1e-8));
    c.factor_square = max(c.factor_square - share * square(c.position_factor), T(1e-8));
    c.current_factor = c.current_factor + (-share) * (conj(c.position_current) * c.position_factor);
    const T left = noise * share;
    c.position_square *= left;
    c.position_current = left * c.position_current, c.position_factor = left * c.position_factor;
}

/// Begin anew at a fix: where the robot was carried, nothing is known of the way there.
template <class T>
void begin_at(CompassState<T>& c, Complex<T> fix, T noise, T current_error) {
    c.position = fix, c.position_square = noise;
    c.position_current = c.position_factor = {T(0), T(0)};
    c.current_square += current_error * current_error;
}

/// Limits beyond which a compass is off: cosine and sine of the angle, 20 deg; number of standard deviations of that.
inline constexpr float off_cos = 0.93969f, off_sin = 0.34202f, off_deviations = 3;

inline constexpr float swims_freely = 0.5f;  // smallest factor on the speed whose angle counts

/// Whether the factor lies outside the sector of small angles, significantly. Its distance from the sector is that from
/// the edge, or from the tip. The factor of a robot that is held is near zero, and has no angle.
template <class T>
bool is_off(const CompassState<T>& c) {
    const T a = c.factor.re, b = abs(c.factor.im);
    const T edge = T(off_cos) * b - T(off_sin) * a;
    const T distance = T(off_cos) * a + T(off_sin) * b < T(0) ? square(c.factor) : edge * edge;
    return T(swims_freely * swims_freely) < square(c.factor) && T(0) < edge &&
           T(off_deviations * off_deviations) * c.factor_square < distance;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
