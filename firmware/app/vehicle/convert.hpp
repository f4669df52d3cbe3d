/// Conversion of counts to SI units. The samples of a tick are averaged without their extremes; nothing is
/// filtered over ticks, so that the controller sees a sensor that is stuck or jumps.
#pragma once

#include "app/board.hpp"
#include "hypertuna/pilot/mission.hpp"

namespace hypertuna::firmware {

/// reading = scale (counts - zero) of each channel.
struct Calibration {
    float zero[channels], scale[channels];
    float trim[max_servos];  // s added to a servo's pulse
};

/// Origin of local coordinates.
struct Origin {
    std::int32_t latitude, longitude;  // 1e-7 deg
    float east, north;                 // m per 1e-7 deg there
    bool known;
};

/// Whether a latitude and longitude can be an origin: a pole has no east.
inline bool is_place(std::int32_t latitude, std::int32_t longitude) {
    return -900000000 < latitude && latitude < 900000000 && -1800000000 <= longitude && longitude <= 1800000000;
}

/// Origin on the WGS 84 ellipsoid; its radii of curvature follow from the series of the meridian's and the parallel's
/// arc.
inline Origin origin_at(std::int32_t latitude, std::int32_t longitude) {
    const SinCos<float> at = sincos(float(latitude) * 1.745329252e-9f);
    const float twice = at.cos * at.cos - at.sin * at.sin;  // cosine of 2 latitude
    return {latitude, longitude, 1e-7f * at.cos * (111412.84f + 93.5f * (1.0f - 2.0f * twice)),
            1e-7f * (111132.95f - 559.82f * twice), true};
}

inline Corner<float> local(const Origin& origin, std::int32_t latitude, std::int32_t longitude) {
    std::int64_t east = std::int64_t(longitude) - origin.longitude;
    const std::int64_t turn = 3600000000, half = turn / 2;
    east += east < -half ? turn : half < east ? -turn : 0;
    const std::int32_t north = std::int32_t(std::uint32_t(latitude) - std::uint32_t(origin.latitude));
    return {origin.east * float(std::int32_t(east)), origin.north * float(north)};
}

/// Mean of the samples, without the smallest and the largest where there are three or more; NaN where there are none.
inline float mean(const Samples& samples) {
    if (samples.count == 0) return std::bit_cast<float>(0x7fc00000u);
    if (samples.count < 3) return float(samples.sum) / float(samples.count);
    return float(samples.sum - samples.min - samples.max) / float(samples.count - 2);
}

inline PilotReadings<float> convert(const Calibration& calibration, int joints, const Raw& raw, const Origin& origin) {
    PilotReadings<float> out{};
    visit_channels([&](const auto& channel, int first) {
        if (channel.converter == Converter::none) return;
        for (int k = 0; k < channel.count(joints); ++k) {
            const int at = first + k;
            channel.of(out)[k] = calibration.scale[at] * (mean(raw.channel[at]) - calibration.zero[at]);
        }
    });
    out.fixed = raw.fixed && origin.known;
    if (out.fixed) {
        const Corner<float> at = local(origin, raw.fix[0], raw.fix[1]);
        out.fix[0] = at.x, out.fix[1] = at.y;
        out.accuracy = 1e-3f * float(raw.accuracy);
    }
    return out;
}

/// Call visit(name, index, field) for every number of the calibration: the zeros of a channel, then its scales.
template <class Visit>
void visit_fields(Calibration& c, int joints, const Visit& visit) {
    visit_channels([&](const auto& channel, int first) {
        if (channel.converter == Converter::none) return;
        for (int k = 0; k < channel.count(joints); ++k) visit(channel.name, k, c.zero[first + k]);
        for (int k = 0; k < channel.count(joints); ++k) visit(channel.name, k, c.scale[first + k]);
    });
    for (int k = 0; k < servos_of(joints); ++k) visit("servo_trim", k, c.trim[k]);
}

}  // namespace hypertuna::firmware
