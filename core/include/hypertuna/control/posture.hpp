/// Posture: once per beat a PID turns the error of a joint's peak bends into amplitude and bias of the next beat.
#pragma once

#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Gains per beat (proportional, integral, derivative in beats), and what keeps noise out of the peaks.
template <class T>
struct PostureModel {
    T proportional, integral, derivative;
    T smoothing;      // time constant of the low-pass before the peaks, in beats
    T missing;        // part of a beat's readings that may be missing before the beat is void
    T limited;        // part of a beat in which a limit may act before the integrator must not grow
    T moving;         // smallest fraction of the set amplitude that a working bend sensor shows
    T amplitude_min;  // rad: smallest set amplitude at which `moving` is checked
};

/// Extremes of a signal over the beat so far, behind a median of three (a spike never reaches them) and a low-pass.
template <class T>
struct Peaks {
    T before, last, level, low, high;
};

/// Half range and middle of a beat.
template <class T>
struct BeatShape {
    T amplitude, bias;
};

/// State of one PID; `output` is what it adds to the set value.
template <class T>
struct Pid {
    T sum, error, output;
};

template <class T>
struct PostureState {
    Peaks<T> measured, wanted;
    Pid<T> amplitude, bias;
    BeatShape<T> seen, set;  // of the last whole beat
    int ticks, missing, limited, dull;
};

template <class T>
T median(T a, T b, T c) {
    return max(min(a, b), min(max(a, b), c));
}

/// The constant of the low-pass where a beat takes 1 / `turns` ticks, and what it leaves of the beat's first harmonic.
template <class T>
struct LowPass {
    T weight, gain;
};
template <class T>
LowPass<T> low_pass(const PostureModel<T>& model, T turns, const SinCos<T>& turn) {
    const T weight = turns / (turns + model.smoothing), rest = T(1) - weight;
    return {weight, weight / sqrt(T(1) - T(2) * rest * turn.cos + rest * rest)};
}

template <class T>
void update(Peaks<T>& peaks, T weight, T value) {
    const T middle = median(peaks.before, peaks.last, value);
    peaks.before = peaks.last, peaks.last = value;
    peaks.level += weight * (middle - peaks.level);
    peaks.low = min(peaks.low, peaks.level), peaks.high = max(peaks.high, peaks.level);
}

/// Half range and middle of the beat that ends here; the next one begins at the level reached.
template <class T>
BeatShape<T> close_beat(Peaks<T>& peaks, T gain) {
    const BeatShape<T> shape{(peaks.high - peaks.low) / (T(2) * gain), (peaks.high + peaks.low) / T(2)};
    peaks.low = peaks.high = peaks.level;
    return shape;
}

/// One beat of the PID. Where a limit acted (`held`), the sum does not grow; it never exceeds what `limit` asks for.
template <class T>
Pid<T> correct(const PostureModel<T>& model, const Pid<T>& now, T error, bool held, T limit) {
    const bool grows = T(0) < error * now.sum || now.sum == T(0);
    const T sum = held && grows ? now.sum : max(-limit, min(limit, now.sum + model.integral * error));
    const T output = model.proportional * error + sum + model.derivative * (error - now.error);
    return {sum, error, max(-limit, min(limit, output))};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
