/// Refusals: why an order is not followed. Each has a sentence that the link passes on.
#pragma once

#include <cstdint>

namespace hypertuna::firmware {

enum class Refusal : std::uint8_t {
    none,
    armed,
    disarmed,
    out_of_range,
    inconsistent,
    unknown,
    not_ready,
    faulty,
    busy,
    no_mission,
    too_many,
    replayed,
    not_signed,
    elsewhere,
    count
};
inline constexpr int refusals = int(Refusal::count);

struct RefusalText {
    const char* name;
    const char* sentence;  // fits into one STATUSTEXT, 50 characters
};
inline constexpr RefusalText refusal_texts[refusals] = {
    {"none", "done"},
    {"armed", "not while armed: disarm first"},
    {"disarmed", "not while disarmed: arm first"},
    {"out_of_range", "a value is out of range"},
    {"inconsistent", "the value does not fit to another parameter"},
    {"unknown", "no such parameter, command or mode"},
    {"not_ready", "this robot has no pilot on board"},
    {"faulty", "a fault forbids it: see the status"},
    {"busy", "the last order is still being carried out"},
    {"no_mission", "there is no mission to follow"},
    {"too_many", "more waypoints or corners than there is room"},
    {"replayed", "the order is older than the last one"},
    {"not_signed", "orders must be signed"},
    {"elsewhere", "the mission on board counts from another origin"},
};

inline const char* sentence(Refusal refusal) { return refusal_texts[int(refusal)].sentence; }

}  // namespace hypertuna::firmware
