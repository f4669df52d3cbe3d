/// Modes of the robot as ground stations list and select them: the states that can be ordered.
#pragma once

#include "app/radio/fields.hpp"

namespace hypertuna::firmware {

constexpr int mode_count() {
    int count = 0;
    for (const StateText& text : state_texts) count += text.order != Order::count;
    return count;
}
inline constexpr int selectable_modes = mode_count();

/// State of a mode, by its number from 0.
constexpr State state_of_mode(int k) {
    for (int state = 0; state < states; ++state)
        if (state_texts[state].order != Order::count && k-- == 0) return State(state);
    return State::count;
}

/// MAVLink's standard mode of a state.
constexpr std::uint8_t standard_mode(State state) {
    return std::uint8_t(state == State::mission ? MAV_STANDARD_MODE_MISSION
                        : state == State::home  ? MAV_STANDARD_MODE_SAFE_RECOVERY
                                                : MAV_STANDARD_MODE_NON_STANDARD);
}

/// Order of a custom mode of HEARTBEAT; Order::count for the numbers of other autopilots, which mean something else.
constexpr Order order_of_mode(std::uint32_t custom) {
    const std::uint32_t state = custom - std::uint32_t(mode_base);
    return state < std::uint32_t(states) ? state_texts[state].order : Order::count;
}

inline mavlink_available_modes_t available_mode(int k) {
    const State state = state_of_mode(k);
    mavlink_available_modes_t m{};
    m.number_modes = std::uint8_t(selectable_modes), m.mode_index = std::uint8_t(k + 1),
    m.standard_mode = standard_mode(state);
    m.custom_mode = std::uint32_t(mode_base + int(state));
    const char* name = state_texts[int(state)].name;
    for (int c = 0; name[c] != 0; ++c) m.mode_name[c] = name[c];
    return m;
}

/// Custom mode of the present state: `disarmed` is `rest` without the armed flag.
inline std::uint32_t custom_mode(const Snapshot& now) {
    return std::uint32_t(mode_base + int(now.armed() ? now.state : State::rest));
}

inline mavlink_current_mode_t current_mode(const Snapshot& now) {
    mavlink_current_mode_t m{};
    m.custom_mode = m.intended_custom_mode = custom_mode(now);
    m.standard_mode = standard_mode(now.state);
    return m;
}

/// Message for a list of modes that never changes.
inline mavlink_available_modes_monitor_t modes_monitor(const Snapshot&) { return {}; }

}  // namespace hypertuna::firmware
