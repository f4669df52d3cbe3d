/// Fields of messages: numbers of the vehicle as whole numbers of a message's units.
#pragma once

#include <limits>

#include "app/radio/frames.hpp"
#include "app/vehicle/requests.hpp"

namespace hypertuna::firmware {

inline constexpr float centidegree = 18000.0f / float(pi);  // centidegrees per radian
inline constexpr float ticks_per_second = 100.0f;

/// Convert a number to steps of 1/factor, rounded and clamped to the type; the largest number of the type for NaN and
/// infinity.
template <class Whole>
Whole whole(float value, float factor) {
    constexpr float high = float(std::numeric_limits<Whole>::max()), low = float(std::numeric_limits<Whole>::min());
    const float scaled = value * factor;
    if (!is_finite(scaled)) return std::numeric_limits<Whole>::max();
    if (scaled >= high) return std::numeric_limits<Whole>::max();
    if (scaled <= low) return std::numeric_limits<Whole>::min();
    return Whole(scaled < 0.0f ? scaled - 0.5f : scaled + 0.5f);
}

/// atan2(y, x) within 2e-5 rad: a minimax polynomial for ratios up to 1.
inline float angle_of(float y, float x) {
    const float up = abs(y), along = abs(x), big = max(up, along);
    if (!(0.0f < big)) return 0.0f;
    const float t = min(up, along) / big, z = t * t;
    float angle = -0.0117212f;
    for (float term : {0.05265332f, -0.11643287f, 0.19354346f, -0.33262347f, 0.99997726f}) angle = angle * z + term;
    angle *= t;
    if (along < up) angle = float(pi / 2) - angle;
    if (x < 0.0f) angle = float(pi) - angle;
    return y < 0.0f ? -angle : angle;
}

inline std::uint32_t milliseconds(const Snapshot& now) { return now.tick * 10; }

}  // namespace hypertuna::firmware
