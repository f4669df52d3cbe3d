/// Refusals: why a command is not executed. The radio sends the sentence to the ground.
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
    bad_fence,
    outside_fence,
    leaves_fence,
    robot_outside,
    too_deep,
    not_now,
    other_pilot,
    no_depth,
    not_centered,
    not_placed,
    by_program,
    one_fence,
    no_rally,
    too_fast,
    not_taken,
    way_home,
    too_small,
    int_only,
    submerged,
    far_origin,
    bad_frame,
    count
};
inline constexpr int refusals = int(Refusal::count);

struct RefusalText {
    const char* name;
    const char* sentence;  // text to send, at most the 50 characters of a STATUSTEXT
};
inline constexpr RefusalText refusal_texts[refusals] = {
    {"none", "accepted"},
    {"armed", "not while armed: disarm first"},
    {"disarmed", "not while disarmed: arm first"},
    {"out_of_range", "a value is out of range"},
    {"inconsistent", "the value conflicts with another parameter"},
    {"unknown", "no such parameter, command or mode"},
    {"not_ready", "the attitude is not known yet"},
    {"faulty", "a fault forbids it: see the faults"},
    {"busy", "the memory is being written: try again"},
    {"no_mission", "there is no mission on board"},
    {"too_many", "too many waypoints or fence corners"},
    {"replayed", "the command is older than the last one"},
    {"not_signed", "messages must be signed: give the station the key"},
    {"elsewhere", "the mission on board has another origin"},
    {"bad_fence", "sides of the fence cross, or it holds no area"},
    {"outside_fence", "home or a waypoint is outside or near the fence"},
    {"leaves_fence", "a straight course would leave the fence"},
    {"robot_outside", "the robot is outside the mission's fence"},
    {"too_deep", "too deep, or too near the depth limit"},
    {"not_now", "not in this mode"},
    {"other_pilot", "another station has control"},
    {"no_depth", "the depth is unknown or implausible: zero it"},
    {"not_centered", "center the sticks first"},
    {"not_placed", "the position is unknown: no fix yet"},
    {"by_program", "use hypertuna radio calibrate for that"},
    {"one_fence", "one polygon or circle to stay inside of"},
    {"no_rally", "rally points are not supported"},
    {"too_fast", "far above the speed of the fastest gait"},
    {"not_taken", "unsupported: use waypoints"},
    {"way_home", "the way home must be the mission's last item"},
    {"too_small", "a radius is below the error of satellite fixes"},
    {"int_only", "send the coordinates by COMMAND_INT"},
    {"submerged", "under water: zero the depth at the surface"},
    {"far_origin", "the origin is more than 20 km from the robot"},
    {"bad_frame", "unsupported frame: degrees or local NED"},
};

inline const char* sentence(Refusal refusal) { return refusal_texts[int(refusal)].sentence; }

}  // namespace hypertuna::firmware
