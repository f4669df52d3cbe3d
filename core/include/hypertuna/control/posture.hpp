/// Posture control: once per beat, harmonics fitted to the bend readings give a joint's peak bends, which correct
/// amplitude and bias of the next beats.
///
/// With the mean amplitude and bias (a, m) that were sent in a beat and the peak and bias (a', m') that were read, the
/// factor F of the next beats' amplitude and the offset c of their bias are
///     F <- F + K (a / a' - F),   c <- c + K (m - m' - c).
/// The reading is compared with what was sent, not with what was commanded: neither delay nor a governed amplitude
/// winds a correction up.
#pragma once

#include "hypertuna/control/cpg.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Weight of a new beat, and which beats count.
template <class T>
struct PostureModel {
    T learning;       // K
    T missing;        // part of a beat's readings that may be missing before the beat is void
    T limited;        // part of a beat in which a limit may act; beyond it the corrections must not grow
    T moving;         // smallest fraction of the sent amplitude that a working bend sensor shows
    T amplitude_min;  // rad: smallest sent amplitude that is judged
};

inline constexpr double factor_max = 2.0;  // F stays within this and its inverse
inline constexpr double beat_length =
    0.1;  // largest relative error of a beat's length; a beat that is longer or shorter is void

/// Mean, first and third harmonic of a signal: mean + Re(conj(first) z + conj(third) z^3), z the oscillator. Muscles
/// alike on both sides make odd harmonics, and the third raises or lowers the peaks.
template <class T>
struct Harmonics {
    T mean;
    Oscillator<T> first, third;
};

/// Amplitude and bias of a beat, rad.
template <class T>
struct BeatShape {
    T amplitude, bias;
};

template <class T>
struct PostureState {
    Harmonics<T> seen, error;     // fit of the readings; sums of its errors over the beat so far
    BeatShape<T> sent;            // sums over the beat so far
    T more, aside;                // F - 1, and c in rad
    int ticks, missing, limited;  // of the beat so far: ticks, those without a reading, those with a limit acting
    int dull;                     // beats in a row without a swing, 2 at most
    bool ended;                   // the beat ends in this tick
};

template <class T>
T median(T a, T b, T c) {
    return max(min(a, b), min(max(a, b), c));
}

template <class T>
Oscillator<T> cubed(const Oscillator<T>& z) {
    const T x = z.x * z.x, y = z.y * z.y;
    return {z.x * (x - T(3) * y), z.y * (T(3) * x - y)};
}

/// Add a valid reading's deviation from the fit of the beats before to the sums.
template <class T>
void add_reading(PostureState<T>& posture, const Oscillator<T>& z, T reading) {
    const Oscillator<T> z3 = cubed(z);
    const Harmonics<T>& fit = posture.seen;
    const T error =
        reading - (fit.mean + fit.first.x * z.x + fit.first.y * z.y + fit.third.x * z3.x + fit.third.y * z3.y);
    Harmonics<T>& sum = posture.error;
    sum.mean += error;
    sum.first.x += error * z.x, sum.first.y += error * z.y;
    sum.third.x += error * z3.x, sum.third.y += error * z3.y;
}

/// Update the fit at the end of a beat by one step of least squares. Over a whole beat the normal equations are
/// diagonal, but for the cut of its last tick. The sums are divided by all ticks, so that a beat with gaps only learns
/// less.
template <class T>
Harmonics<T> refit(const Harmonics<T>& fit, const Harmonics<T>& sum, T ticks) {
    const T mean = T(1) / ticks, twice = T(2) / ticks;
    return {fit.mean + mean * sum.mean,
            {fit.first.x + twice * sum.first.x, fit.first.y + twice * sum.first.y},
            {fit.third.x + twice * sum.third.x, fit.third.y + twice * sum.third.y}};
}

/// Amplitude and bias of the peak bends; the third harmonic counts by its value at the peak of the first.
template <class T>
BeatShape<T> shape(const Harmonics<T>& fit) {
    const T amplitude = sqrt(fit.first.x * fit.first.x + fit.first.y * fit.first.y);
    if (!(T(0) < amplitude)) return {T(0), fit.mean};
    const Oscillator<T> top = cubed(Oscillator<T>{fit.first.x / amplitude, fit.first.y / amplitude});
    return {amplitude + fit.third.x * top.x + fit.third.y * top.y, fit.mean};
}

/// Sum of the amplitudes of both harmonics, independent of their phases: 0 for a sensor that does not follow.
template <class T>
T swing(const Harmonics<T>& fit) {
    return sqrt(fit.first.x * fit.first.x + fit.first.y * fit.first.y) +
           sqrt(fit.third.x * fit.third.x + fit.third.y * fit.third.y);
}

/// Move a correction a part of the way to the beat's value; where a limit acted (`held`), not further away from zero.
template <class T>
T learn(T now, T target, T learning, bool held) {
    const T next = now + learning * (target - now);
    return held && abs(now) < abs(next) ? now : next;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
