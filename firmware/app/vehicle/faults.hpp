/// Faults that the supervisor detects, and the robot's response to each.
#pragma once

#include "app/vehicle/parameters.hpp"

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
    depth_sensor,
    too_deep,
    no_progress,
    no_stroke,
    unguarded,
    sinks,
    count
};
inline constexpr int faults = int(Fault::count);

/// Responses; the last of all present faults applies.
///
/// warn: report only. home: swim home; without a way home ascend, and rest. stop: rest here. surface: ascend, and rest.
/// disarm: ascend, and disarm at the surface. rest: keep the tail at rest until upright.
enum class Answer : std::uint8_t { warn, home, stop, surface, disarm, rest, count };
inline constexpr const char* answer_names[int(Answer::count)] = {"warn", "home", "stop", "surface", "disarm", "rest"};
inline constexpr Answer max_choice = Answer::surface;  // last of the responses that a parameter may choose

/// How a fault is reported, as MAVLink's MAV_SEVERITY.
enum class Severity : std::uint8_t { critical = 2, warning = 4, notice = 5 };
inline constexpr const char* severity_name(Severity severity) {
    return severity == Severity::critical ? "critical" : severity == Severity::warning ? "warning" : "notice";
}

struct FaultText {
    const char* name;
    const char* sentence;  // text to send, at most the 50 characters of a STATUSTEXT
    Answer answer;
    Severity severity;
    bool latched;                      // whether the fault lasts until the robot is armed again
    bool forbids_arming;               // while the cause lasts
    float Limits::* choice = nullptr;  // parameter with the response, of which `answer` is the default
};
inline constexpr FaultText fault_texts[faults] = {
    {"over_pressure", "a joint was released: pressure above its limit", Answer::warn, Severity::critical, true, false},
    {"bend_sensor", "a bend sensor failed: that joint is uncorrected", Answer::warn, Severity::warning, false, true},
    {"pressure_sensor", "a pressure sensor failed: that joint beats less", Answer::warn, Severity::warning, false,
     true},
    {"current_sensor", "a current sensor failed", Answer::warn, Severity::notice, false, false},
    {"imu", "the IMU failed", Answer::warn, Severity::critical, false, true},
    {"battery_sensor", "the battery voltage cannot be read", Answer::warn, Severity::warning, false, true},
    {"low_battery", "the battery is low", Answer::home, Severity::warning, true, true},
    {"empty_battery", "the battery is empty", Answer::disarm, Severity::critical, true, true},
    {"link_lost", "no contact with the ground station", Answer::warn, Severity::notice, false, false},
    {"link_gone", "no contact with the ground station for long", Answer::home, Severity::warning, true, false},
    {"tilt", "roll or pitch is above its limit", Answer::rest, Severity::warning, false, true},
    {"leak", "there is water in the hull", Answer::surface, Severity::critical, true, true, &Limits::leak_answer},
    {"watchdog", "the watchdog restarted the firmware", Answer::warn, Severity::warning, true, false},
    {"overrun", "control ticks come late", Answer::warn, Severity::warning, false, false},
    {"defaults", "no stored parameters: the defaults are used", Answer::warn, Severity::notice, false, false},
    {"memory", "the non-volatile memory could not be written", Answer::warn, Severity::warning, false, false},
    {"black_box", "the black box lost records", Answer::warn, Severity::notice, true, false},
    {"key_lost", "the signing key cannot be read: locked", Answer::warn, Severity::critical, false, true},
    {"depth_sensor", "the depth sensor failed", Answer::warn, Severity::critical, false, true},
    {"too_deep", "deeper than the depth limit", Answer::surface, Severity::critical, false, false},
    {"no_progress", "no way is made: entangled, or aground", Answer::surface, Severity::critical, true, false,
     &Limits::snag_answer},
    {"no_stroke", "a joint does not bend: no oil, or its servo stands", Answer::warn, Severity::critical, true, false,
     &Limits::stroke_answer},
    {"unguarded", "sticks or gait without IMU or battery voltage", Answer::home, Severity::warning, true, false,
     &Limits::guard_answer},
    {"sinks", "it sinks at rest: trim it", Answer::surface, Severity::critical, false, true},
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

/// Response to a fault: the table's, or that of its parameter.
inline Answer answer_to(const FaultText& text, const Limits& limits) {
    return text.choice == nullptr ? text.answer : Answer(int(limits.*text.choice));
}

/// Most severe response to the faults of a set.
inline Answer answer_to(const Faults& set, const Limits& limits) {
    Answer strongest = Answer::warn;
    for (int f = 0; f < faults; ++f) {
        const Answer answer = answer_to(fault_texts[f], limits);
        if (set.has(Fault(f)) && strongest < answer) strongest = answer;
    }
    return strongest;
}

/// First fault of a set for which `holds` is true; Fault::count if there is none.
template <class Holds>
Fault first_fault(const Faults& set, const Holds& holds) {
    for (int f = 0; f < faults; ++f)
        if (set.has(Fault(f)) && holds(fault_texts[f])) return Fault(f);
    return Fault::count;
}

/// First fault of a set that forbids arming.
inline Fault forbidding(const Faults& set) {
    return first_fault(set, [](const FaultText& text) { return text.forbids_arming; });
}

/// Whether a fault of a set is critical.
inline bool is_critical(const Faults& set) {
    return first_fault(set, [](const FaultText& text) { return text.severity == Severity::critical; }) != Fault::count;
}

}  // namespace hypertuna::firmware
