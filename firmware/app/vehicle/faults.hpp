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
    memory,
    black_box,
    count
};
inline constexpr int faults = int(Fault::count);

/// Answers by rising strength: the strongest of all faults that hold is the robot's.
///
/// warn tells; home follows the mission's way home, and rests where there is no mission; rest lets the tail come to
/// rest and levels the fins; disarm does that for good.
enum class Answer : std::uint8_t { warn, home, rest, disarm, count };
inline constexpr const char* answer_names[int(Answer::count)] = {"warn", "home", "rest", "disarm"};

struct FaultText {
    const char* name;
    const char* sentence;  // fits into one STATUSTEXT, 50 characters
    Answer answer;
    bool latched;  // until it is armed anew
    bool forbids;  // arming, while its cause lasts
};
inline constexpr FaultText fault_texts[faults] = {
    {"over_pressure", "a joint was released: pressure over its limit", Answer::warn, true, false},
    {"bend_sensor", "a bend sensor fails: that joint goes uncorrected", Answer::warn, false, true},
    {"pressure_sensor", "a pressure sensor fails: that joint beats less", Answer::warn, false, true},
    {"current_sensor", "a current sensor fails", Answer::warn, false, false},
    {"imu", "the IMU fails", Answer::warn, false, true},
    {"battery_sensor", "the battery voltage cannot be read", Answer::warn, false, true},
    {"low_battery", "the battery is low", Answer::home, true, true},
    {"empty_battery", "the battery is empty", Answer::disarm, true, true},
    {"link_lost", "the ground is not heard", Answer::warn, false, false},
    {"link_gone", "the ground was not heard for long", Answer::home, true, false},
    {"tilt", "the robot lies on its side or stands on end", Answer::rest, false, true},
    {"leak", "water in the hull", Answer::home, true, true},
    {"watchdog", "the watchdog restarted the firmware", Answer::warn, true, false},
    {"overrun", "a tick took longer than there is time", Answer::warn, false, false},
    {"defaults", "no stored parameters: the description's are used", Answer::warn, false, false},
    {"memory", "what should last could not be stored", Answer::warn, false, false},
    {"black_box", "the black box lost records", Answer::warn, true, false},
};

/// A set of faults, one bit each.
struct Faults {
    std::uint32_t flags;

    bool has(Fault f) const { return flags >> int(f) & 1; }
    void set(Fault f, bool holds) {
        const std::uint32_t bit = std::uint32_t(1) << int(f);
        flags = holds ? flags | bit : flags & ~bit;
    }
    bool operator==(const Faults&) const = default;
};

/// Strongest answer to the faults of a set.
inline Answer answer_to(const Faults& set) {
    Answer strongest = Answer::warn;
    for (int f = 0; f < faults; ++f)
        if (set.has(Fault(f)) && strongest < fault_texts[f].answer) strongest = fault_texts[f].answer;
    return strongest;
}

/// Whether a fault of a set forbids arming.
inline bool forbid(const Faults& set) {
    for (int f = 0; f < faults; ++f)
        if (set.has(Fault(f)) && fault_texts[f].forbids) return true;
    return false;
}

}  // namespace hypertuna::firmware
