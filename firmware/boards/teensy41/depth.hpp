/// Depth sensor MS5837-30BA on I2C: two conversions in turn, pressure mostly, temperature now and then; first-order
/// compensation of its data sheet, in integers.
#pragma once

#include <cstdint>

namespace hypertuna::firmware {

/// Coefficients of the sensor's memory, C1 to C6, and the last temperature.
struct DepthSensor {
    std::uint16_t c[7];
    std::int64_t dt;  // of the temperature from its reference

    void temperature(std::uint32_t d2) { dt = std::int64_t(d2) - (std::int64_t(c[5]) << 8); }

    /// Pressure in 0.1 mbar = 10 Pa: what the firmware counts in.
    std::int32_t pressure(std::uint32_t d1) const {
        const std::int64_t offset = (std::int64_t(c[2]) << 16) + ((c[4] * dt) >> 7);
        const std::int64_t slope = (std::int64_t(c[1]) << 15) + ((c[3] * dt) >> 8);
        return std::int32_t((((std::int64_t(d1) * slope) >> 21) - offset) >> 13);
    }
};

}  // namespace hypertuna::firmware
