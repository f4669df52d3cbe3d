/// Orders: what the ground asks for, passed on to the vehicle, which decides, and its answer.
#pragma once

#include "app/radio/link_state.hpp"
#include "app/radio/mission_talk.hpp"
#include "app/radio/parameter_talk.hpp"

namespace hypertuna::firmware {

inline constexpr int stick_most = 1000;  // of a joystick's axes

/// MANUAL_CONTROL: z is thrust, r turns to starboard (as ground stations send it), x pushed forward dives. An axis of
/// INT16_MAX is none. It is not acknowledged, the next comes soon.
inline void on_manual(Link& link, Vehicle& vehicle, mavlink_manual_control_t m) {
    ++link.orders;
    bool within = true;
    if (m.x == INT16_MAX) m.x = 0;
    if (m.z == INT16_MAX) m.z = 0;
    if (m.r == INT16_MAX) m.r = 0;
    for (int axis : {int(m.x), int(m.z), int(m.r)}) within = within && -stick_most <= axis && axis <= stick_most;
    const auto part = [](int axis) { return float(axis) / float(stick_most); };
    const Refusal refusal =
        within ? ask_manual(vehicle, max(0.0f, part(m.z)), -part(m.r), -part(m.x)) : Refusal::out_of_range;
    if (refusal != Refusal::none) tell_rarely(link, snapshot(vehicle).tick, refusal);
}

inline void on_gait_set(Link& link, Vehicle& vehicle, Peer from, const mavlink_gait_set_t& m) {
    const auto angle = [](std::int16_t cdeg) { return float(cdeg) / centidegree; };
    Command<float> command{};
    command.frequency = float(m.frequency) * 1e-3f;
    for (int j = 0; j < most_joints; ++j)
        command.amplitude[j] = angle(m.amplitude[j]), command.phase[j] = angle(m.lag[j]),
        command.bias[j] = angle(m.bias[j]);
    for (int k = 0; k < 2; ++k) command.fin[k] = angle(m.fin[k]);
    acknowledge(link, from, HYPERTUNA_CMD_GAIT, ask_gait(vehicle, command));
}

inline Refusal gait_command(Vehicle& vehicle, const mavlink_command_long_t& m) {
    const float degree = float(pi / 180);
    Command<float> command{};
    command.frequency = m.param1;
    command.amplitude[0] = degree * m.param2, command.amplitude[1] = degree * m.param3;
    command.phase[1] = degree * m.param4;
    command.bias[0] = degree * m.param5, command.bias[1] = degree * m.param6;
    return ask_gait(vehicle, command);
}

/// A whole number among parameters that are floats; -1 for what is none within the range.
inline int whole_of(float value, int most) {
    if (!(0.0f <= value && value <= float(most))) return -1;
    const int number = int(value);
    return float(number) == value ? number : -1;
}

inline Refusal arm_command(Vehicle& vehicle, const mavlink_command_long_t& m) {
    const int on = whole_of(m.param1, 1);
    return on < 0 ? Refusal::out_of_range : arm(vehicle, on == 1);
}

inline Refusal mode_command(Vehicle& vehicle, const mavlink_command_long_t& m) {
    const int base = whole_of(m.param1, 255), control = whole_of(m.param2, int(Control::count) - 1);
    if (base < 0 || (base & MAV_MODE_FLAG_CUSTOM_MODE_ENABLED) == 0) return Refusal::unknown;
    return control < 0 ? Refusal::out_of_range : ask_control(vehicle, Control(control));
}

/// Interval in microseconds: 0 for what the robot boots with, -1 for never; as fast as a tick at most.
inline Refusal interval_command(Link& link, const mavlink_command_long_t& m) {
    const int id = whole_of(m.param1, 1 << 24), k = id < 0 ? -1 : stream_index(std::uint32_t(id));
    if (k < 0) return Refusal::unknown;
    const bool heart = k == 0, never = m.param2 == -1.0f;
    if (!never && m.param2 != 0.0f && !(1e4f <= m.param2 && m.param2 <= 6e7f)) return Refusal::out_of_range;
    if (heart && (never || 1e6f < m.param2)) return Refusal::out_of_range;  // clients believe it lost without
    link.telemetry.stream[k].interval = never              ? 0
                                        : m.param2 == 0.0f ? schedules[k].interval
                                                           : std::uint32_t(m.param2 * 1e-4f + 0.5f);
    return Refusal::none;
}

inline Refusal request_command(Link& link, const mavlink_command_long_t& m) {
    const int id = whole_of(m.param1, 1 << 24), k = id < 0 ? -1 : stream_index(std::uint32_t(id));
    if (k < 0) return Refusal::unknown;
    link.telemetry.stream[k].wanted = true;
    return Refusal::none;
}

inline Refusal carry_out(Link& link, Vehicle& vehicle, const mavlink_command_long_t& m) {
    switch (m.command) {
        case MAV_CMD_COMPONENT_ARM_DISARM:
            return arm_command(vehicle, m);
        case MAV_CMD_DO_SET_MODE:
            return mode_command(vehicle, m);
        case MAV_CMD_MISSION_START:
            return ask_control(vehicle, Control::mission);
        case MAV_CMD_SET_MESSAGE_INTERVAL:
            return interval_command(link, m);
        case MAV_CMD_REQUEST_MESSAGE:
            return request_command(link, m);
        case MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
            link.telemetry.stream[stream_index(MAVLINK_MSG_ID_AUTOPILOT_VERSION)].wanted = true;
            return Refusal::none;
        case HYPERTUNA_CMD_GAIT:
            return gait_command(vehicle, m);
        default:
            return Refusal::unknown;
    }
}

/// The same with whole numbers in the place of two parameters: coordinates, which no command here has.
inline mavlink_command_long_t long_of(const mavlink_command_int_t& m) {
    const auto number = [](std::int32_t x) { return x == 0 ? 0.0f : std::numeric_limits<float>::quiet_NaN(); };
    mavlink_command_long_t out{};
    out.command = m.command, out.target_system = m.target_system, out.target_component = m.target_component;
    out.param1 = m.param1, out.param2 = m.param2, out.param3 = m.param3, out.param4 = m.param4;
    out.param5 = number(m.x), out.param6 = number(m.y), out.param7 = m.z;
    return out;
}

inline bool is_command(const Frame& frame) {
    return frame.id == MAVLINK_MSG_ID_COMMAND_LONG || frame.id == MAVLINK_MSG_ID_COMMAND_INT;
}
inline mavlink_command_long_t command_of(const Frame& frame) {
    return frame.id == MAVLINK_MSG_ID_COMMAND_INT ? long_of(message_of<mavlink_command_int_t>(frame))
                                                  : message_of<mavlink_command_long_t>(frame);
}

inline bool is_disarm(const Frame& frame) {
    if (!is_command(frame)) return false;
    const mavlink_command_long_t m = command_of(frame);
    return m.command == MAV_CMD_COMPONENT_ARM_DISARM && m.param1 == 0.0f;
}

}  // namespace hypertuna::firmware
