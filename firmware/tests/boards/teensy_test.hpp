/// Board teensy41 on a stand-in for the Arduino API, for the tests: a floating robot, and the bytes of its sensors.
#pragma once

#include <algorithm>
#include <cmath>
#include <new>

#include "../../../core/tests/check.hpp"
#include "../../boards/teensy41/main.cpp"

using namespace hypertuna;

inline constexpr Station ground{255, 190};

inline std::uint32_t noise_state = 1;
inline std::uint8_t noise() { return std::uint8_t((noise_state = noise_state * 1664525u + 1013904223u) >> 24); }

inline void put_imu(HardwareSerialIMXRT& line, std::uint8_t kind, const int (&value)[3]) {
    std::uint8_t bytes[11] = {0x55, kind}, sum = 0;
    for (int k = 0; k < 3; ++k)
        bytes[2 + 2 * k] = std::uint8_t(value[k]), bytes[3 + 2 * k] = std::uint8_t(value[k] >> 8);
    for (int k = 0; k < 10; ++k) sum = std::uint8_t(sum + bytes[k]);
    bytes[10] = sum;
    line.come(bytes, 11);
}

inline void put_fix(HardwareSerialIMXRT& line, std::int32_t latitude, std::int32_t longitude, int type = 3,
                    int valid = 1, int invalid = 0) {
    std::uint8_t bytes[100] = {0xb5, 0x62, 1, 7, 92, 0}, sum[2];
    const std::int32_t accuracy = 2500;
    bytes[6 + 20] = std::uint8_t(type), bytes[6 + 21] = std::uint8_t(valid), bytes[6 + 23] = 9;
    bytes[6 + 78] = std::uint8_t(invalid);
    std::memcpy(bytes + 30, &longitude, 4), std::memcpy(bytes + 34, &latitude, 4);
    std::memcpy(bytes + 46, &accuracy, 4);
    sum_message(bytes, 100, sum);
    bytes[98] = sum[0], bytes[99] = sum[1];
    line.come(bytes, 100);
}

/// The bytes and voltages of the sensors of a robot that floats upright, with a little noise.
inline void float_on(int ticks) {
    const Calibration& c = app.vehicle.model.calibration;
    for (int t = 0; t < ticks; ++t) {
        const auto show = [&](int channel, int pin, float value) {
            stand_in::analog[pin] = int((value / c.scale[channel] + c.zero[channel]) / 16) + noise() % 4;
        };
        const int* pin = robot::wiring.analog;
        for (int j = 0; j < 2; ++j) show(first_channel("bend") + j, *pin++, 0);
        for (int k = 0; k < 4; ++k) show(first_channel("pressure") + k, *pin++, 60e3f);
        for (int k = 0; k < 4; ++k) show(first_channel("current") + k, *pin++, 0.3f);
        show(first_channel("voltage"), *pin++, 15);
        const int small = noise() % 8;
        put_imu(Serial1, 0x51, {small, -small, int(9.81f / c.scale[first_channel("acceleration")])});
        put_imu(Serial1, 0x52, {small, small, -small});
        put_imu(Serial1, 0x54, {small, 11468 + small, -11468});
        if (t % 100 == 0) put_fix(Serial8, 300000000 + t, 1200000000);
        loop();
    }
}

/// Reset the board to its state at the start of its program.
inline void boot_board() {
    new (&board) Teensy<decltype(robot::wiring)>{robot::wiring, robot::description.joints};
    setup();
}

/// Run for some ticks; return the longest time from one to the next [us].
inline std::uint64_t longest_tick(int ticks) {
    std::uint64_t most = 0;
    for (int k = 0; k < ticks; ++k) {
        const std::uint64_t before = stand_in::now_us;
        float_on(1);
        most = std::max(most, stand_in::now_us - before);
    }
    return most;
}
