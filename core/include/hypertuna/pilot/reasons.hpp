/// Modes of the pilot, and why it does what it does.
#pragma once

#include <cstdint>

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

enum class Mode : std::uint8_t { idle, transit, hold, surface, home, done, ended, count };
inline constexpr int modes = int(Mode::count);
struct NamedText {
    const char *name, *sentence;
};
inline constexpr NamedText mode_texts[modes] = {
    {"idle", "no mission to fly"},
    {"transit", "on a leg to a waypoint"},
    {"hold", "the beat is stopped"},
    {"surface", "ascending for a fix, or waiting for it at the surface"},
    {"home", "on the way home"},
    {"done", "the mission is done: all waypoints are reached, and home"},
    {"ended", "the mission has ended without being done: the reasons say why"},
};

inline bool has_ended(Mode mode) { return mode == Mode::done || mode == Mode::ended; }

/// Reasons of the pilot's decisions. Those before `all_reached` end the mission and are latched.
enum class Reason : std::uint8_t {
    low_battery,
    battery_lost,
    time_up,
    depth_lost,
    imu_lost,
    compass_lost,
    compass_off,
    port_fin_lost,
    starboard_fin_lost,
    no_answer,
    stranded,
    tail_lost,
    recalled,
    swept,
    all_reached,
    no_fix,
    uncertain,
    fix_due,
    fence,
    outside,
    depth_limit,
    skipped,
    passed,
    adrift,
    fixes_refused,
    count
};
inline constexpr int reasons = int(Reason::count);
inline constexpr int ending_reasons = int(Reason::all_reached);  // the reasons before `all_reached` end the mission

inline constexpr NamedText reason_texts[reasons] = {
    {"low_battery", "the charge is what the way home and the reserve need"},
    {"battery_lost", "the battery's voltage cannot be read"},
    {"time_up", "the time left is what the way home needs"},
    {"depth_lost", "the depth cannot be read: home at the surface, nose up"},
    {"imu_lost", "rates and gravity cannot be read: up with fixed fins, then hold"},
    {"compass_lost", "the magnetic field cannot be read: home by the gyroscope, hold when that takes too long"},
    {"compass_off", "the compass disagrees with the course over ground: home at the surface, calibrate it"},
    {"port_fin_lost", "the port fin does not follow its command: level the fin, home at the surface with the other"},
    {"starboard_fin_lost",
     "the starboard fin does not follow its command: level the fin, home at the surface with the other"},
    {"no_answer", "the depth does not answer to the fins: home at the surface"},
    {"stranded", "the depth does not answer on the way up either: the beat stops and the robot floats"},
    {"tail_lost", "a joint was released, by its pressure or because it does not follow: home with the other"},
    {"recalled", "the ground or the supervisor on board called the robot home"},
    {"swept", "the current carries the robot away: home at the surface as long as the charge lasts, then hold"},
    {"all_reached", "all waypoints are reached"},
    {"no_fix", "no fix came at the surface in good time"},
    {"uncertain", "the position is too uncertain: up for a fix"},
    {"fix_due", "the last fix is old: up for the next"},
    {"fence", "the fence is near: its inside comes first"},
    {"outside", "the robot is outside the fence"},
    {"depth_limit", "the depth is at its limit"},
    {"skipped", "a waypoint was left out: too near the fence or beyond it, or by order"},
    {"passed", "a waypoint was passed without being reached: position or depth were not right in time"},
    {"adrift", "the position is too uncertain to tell whether this is home"},
    {"fixes_refused", "fixes are where the robot cannot have come: none is used until they agree for half a minute"},
};

/// A set of reasons, one bit each.
struct Reasons {
    std::uint32_t flags;

    bool has(Reason r) const { return flags >> int(r) & 1; }
    void set(Reason r, bool holds = true) { flags |= std::uint32_t(holds) << int(r); }
    void clear(Reason r) { flags &= ~(std::uint32_t(1) << int(r)); }
    bool end() const { return (flags & ((std::uint32_t(1) << ending_reasons) - 1)) != 0; }
};

/// How a flight ends; `none` while it goes on.
enum class Ending : std::uint8_t { none, done, home, adrift, hold, given_up, diverged, count };
inline constexpr NamedText ending_texts[int(Ending::count)] = {
    {"none", "The mission goes on"},
    {"done", "The mission is done: all waypoints reached, and home"},
    {"home", "The robot is home, but the mission is not done"},
    {"adrift", "The robot cannot tell whether it is home: its position is too uncertain"},
    {"hold", "The robot holds: it cannot go home"},
    {"given up", "The mission was given up"},
    {"diverged", "The run diverged: the state of the twin is no longer that of a robot"},
};

/// How a flight has ended that stops in this mode.
inline Ending ending_of(Mode mode, const Reasons& why) {
    if (mode == Mode::done) return Ending::done;
    if (mode == Mode::hold) return Ending::hold;
    if (why.has(Reason::adrift)) return Ending::adrift;
    return mode == Mode::ended ? Ending::home : Ending::given_up;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
