/// Faults that the supervisor knows, and how the robot answers to each.
#pragma once

#include <cstdint>

namespace hypertuna::firmware {

enum class Fault : std::uint8_t {
    over_pressure,
    bend_sensor,
    pressure_sensor,
    current_sensor,
    imu,
    battery_sensor,
    low_battery,
    empty_battery,
    link_lost,
    link_gone,
    tilt,
    leak,
    watchdog,
    overrun,
    defaults,
    store,
    black_box,
    count
};
inline constexpr int faults = int(Fault::count);

/// Answers by rising strength: the strongest of all faults that hold is the robot's.
enum class Answer : std::uint8_t { warn, home, rest, release };

struct FaultText {
    const char* name;
    const char* sentence;  // fits into one STATUSTEXT, 50 characters
    Answer answer;
    bool latched;  // until disarmed
    bool forbids;  // arming
};

struct Faults {
    std::uint32_t flags;

    bool has(Fault f) const { return flags >> int(f) & 1; }
    void set(Fault f, bool holds) {
        const std::uint32_t bit = std::uint32_t(1) << int(f);
        flags = holds ? flags | bit : flags & ~bit;
    }
    bool operator==(const Faults&) const = default;
};

}  // namespace hypertuna::firmware
