/// Faults that the supervisor detects, and the robot's response to each.
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
    key_lost,
    count
};
inline constexpr int faults = int(Fault::count);

/// Responses in rising severity: the most severe of all present faults applies.
///
/// warn: report only. home: follow the mission's way home, or rest without a mission. rest: bring the tail to rest and
/// level the fins. disarm: rest for good.
enum class Answer : std::uint8_t { warn, home, rest, disarm, count };
inline constexpr const char* answer_names[int(Answer::count)] = {"warn", "home", "rest", "disarm"};

struct FaultText {
    const char* name;
    const char* sentence;  // at most the 50 characters of a STATUSTEXT
    Answer answer;
    bool latched;         // until the robot is armed again
    bool forbids_arming;  // while the cause lasts
};
inline constexpr FaultText fault_texts[faults] = {
    {"over_pressure", "a joint was released: pressure above its limit", Answer::warn, true, false},
    {"bend_sensor", "a bend sensor failed: that joint is uncorrected", Answer::warn, false, true},
    {"pressure_sensor", "a pressure sensor failed: that joint beats less", Answer::warn, false, true},
    {"current_sensor", "a current sensor failed", Answer::warn, false, false},
    {"imu", "the IMU failed", Answer::warn, false, true},
    {"battery_sensor", "the battery voltage cannot be read", Answer::warn, false, true},
    {"low_battery", "the battery is low", Answer::home, true, true},
    {"empty_battery", "the battery is empty", Answer::disarm, true, true},
    {"link_lost", "no contact with the ground station", Answer::warn, false, false},
    {"link_gone", "no contact with the ground station for long", Answer::home, true, false},
    {"tilt", "roll or pitch is above its limit", Answer::rest, false, true},
    {"leak", "there is water in the hull", Answer::home, true, true},
    {"watchdog", "the watchdog restarted the firmware", Answer::warn, true, false},
    {"overrun", "a control tick overran its time", Answer::warn, false, false},
    {"defaults", "no stored parameters: the defaults are used", Answer::warn, false, false},
    {"memory", "the non-volatile memory could not be written", Answer::warn, false, false},
    {"black_box", "the black box lost records", Answer::warn, true, false},
    {"key_lost", "the signing key cannot be read: locked", Answer::warn, false, true},
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

/// Most severe response to the faults of a set.
inline Answer answer_to(const Faults& set) {
    Answer strongest = Answer::warn;
    for (int f = 0; f < faults; ++f)
        if (set.has(Fault(f)) && strongest < fault_texts[f].answer) strongest = fault_texts[f].answer;
    return strongest;
}

/// Whether a fault of a set forbids arming.
inline bool forbids_arming(const Faults& set) {
    for (int f = 0; f < faults; ++f)
        if (set.has(Fault(f)) && fault_texts[f].forbids_arming) return true;
    return false;
}

}  // namespace hypertuna::firmware
