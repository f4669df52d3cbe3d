/// Central pattern generator: coupled Hopf oscillators that drive the pumps, and the filters of all commanded values.
///
/// Eq. 37, with corrected signs and divided by the amplitude, becomes on the unit circle
///     r' = k r (1 - r^2),   phi_i' = omega + h sin(phi_ref - Phi_i - phi_i),   (x, y) = r (cos phi, sin phi),
/// and the output is b + A x. Coupling turns the phase alone, so it cannot change an amplitude, and A may be zero.
/// All three parts have closed solutions, which commute: a tick of any length is exact while omega and Phi hold.
#pragma once

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Constants of a critically damped second-order filter at one tick: rate times tick, and exp of minus that.
template <class T>
struct Smoothing {
    T rate, decay;
};

/// A smoothed commanded value, and its change per tick.
template <class T>
struct Follower {
    T value, change;
};

/// One tick of y'' = rate^2 (target - y) - 2 rate y', exact for a target that holds.
template <class T>
Follower<T> follow(const Smoothing<T>& filter, const Follower<T>& now, T target) {
    const T error = now.value - target, w = now.change + filter.rate * error;
    return {target + (error + w) * filter.decay, (now.change - filter.rate * w) * filter.decay};
}

/// State of one oscillator, on the unit circle once it has settled; the output is bias + amplitude x.
template <class T>
struct Oscillator {
    T x, y;
};

/// Constants of the network at one tick: exp(-2 k tick) and exp(-h tick).
template <class T>
struct Network {
    T relax, couple;
};

/// The oscillator at phase 0 of a sine: x = sin(0), rising.
template <class T>
Oscillator<T> at_rest() {
    return {T(0), T(-1)};
}

template <class T>
Oscillator<T> turned(const Oscillator<T>& z, const SinCos<T>& angle) {
    return {z.x * angle.cos - z.y * angle.sin, z.x * angle.sin + z.y * angle.cos};
}

/// One tick of an uncoupled oscillator: back to the unit circle, r^2 -> r^2 / (r^2 + (1 - r^2) exp(-2 k tick)), and on
/// by `turn` = omega tick.
template <class T>
Oscillator<T> oscillate(const Network<T>& network, const Oscillator<T>& now, const SinCos<T>& turn) {
    const T square = now.x * now.x + now.y * now.y;
    const T scale = T(1) / sqrt(square + (T(1) - square) * network.relax);
    const Oscillator<T> z = turned(now, turn);
    return {z.x * scale, z.y * scale};
}

/// One tick of the coupling that makes `now` lag `reference` by an angle.
///
/// With psi = phi_ref - lag - phi the coupling is psi' = -h sin psi, solved by tan(psi / 2) -> tan(psi / 2) exp(-h
/// tick): here in sine and cosine, so that no angle is ever computed. At psi = pi exactly it is at rest, but not
/// stable.
template <class T>
Oscillator<T> couple(const Network<T>& network, const Oscillator<T>& now, const Oscillator<T>& reference,
                     const SinCos<T>& lag) {
    const Oscillator<T> wanted = turned(reference, {-lag.sin, lag.cos});
    const T c = wanted.x * now.x + wanted.y * now.y, s = wanted.y * now.x - wanted.x * now.y;
    const T length = T(1) / sqrt(c * c + s * s), cosine = c * length, sine = s * length;
    const T e = network.couple, ahead = T(1) + cosine, behind = e * e * (T(1) - cosine);
    const T scale = T(1) / (ahead + behind);
    const T cosine_left = (ahead - behind) * scale, sine_left = T(2) * e * sine * scale;
    return turned(now, {sine * cosine_left - cosine * sine_left, cosine * cosine_left + sine * sine_left});
}

/// Whether the oscillator's sine has begun again: its beat ends where x comes up through zero.
template <class T>
bool beat_ends(const Oscillator<T>& before, const Oscillator<T>& now) {
    return before.x < T(0) && T(0) <= now.x;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
