/// Commands of the ground: passed on to the vehicle, which accepts or refuses them, and answered.
///
/// `handle` of a message's type acts on it. Whether the message is for this robot was checked before (dispatch.hpp).
#pragma once

#include "app/radio/files.hpp"
#include "app/radio/mission_protocol.hpp"
#include "app/radio/parameter_protocol.hpp"
#include "app/radio/radio_state.hpp"

namespace hypertuna::firmware {

inline constexpr int stick_max = 1000, thrust_center = 500;  // full deflection of a joystick's axis; of z, its center

/// MANUAL_CONTROL: z is thrust, from the center up (ground stations send 0 to 1000, and 500 for a centered stick), r
/// turns to starboard, x pushed forward dives. An axis of INT16_MAX is absent. There is no acknowledgement: the next
/// message follows soon.
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, mavlink_manual_control_t m) {
    bool within = true;
    if (m.x == INT16_MAX) m.x = 0;
    if (m.z == INT16_MAX) m.z = thrust_center;
    if (m.r == INT16_MAX) m.r = 0;
    for (int axis : {int(m.x), int(m.z), int(m.r)}) within = within && -stick_max <= axis && axis <= stick_max;
    const auto part = [](int axis) { return float(axis) / float(stick_max); };
    const Refusal refusal =
        within ? sticks(vehicle, from, max(-1.0f, part(2 * (m.z - thrust_center))), -part(m.r), -part(m.x))
               : Refusal::out_of_range;
    // Ground stations send the sticks in every mode: outside of manual that is no mistake.
    if (refusal != Refusal::none && refusal != Refusal::not_now) report_rarely(radio, snapshot(vehicle).tick, refusal);
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_gait_set_t& m) {
    const auto angle = [](std::int16_t cdeg) { return float(cdeg) / centidegree; };
    Command<float> command{};
    command.frequency = float(m.frequency) * 1e-3f;
    for (int j = 0; j < max_joints; ++j)
        command.amplitude[j] = angle(m.amplitude[j]), command.phase[j] = angle(m.lag[j]),
        command.bias[j] = angle(m.bias[j]);
    for (int k = 0; k < 2; ++k) command.fin[k] = angle(m.fin[k]);
    acknowledge(radio, from, HYPERTUNA_CMD_GAIT, set_gait(vehicle, from, command));
}

inline Refusal gait_command(Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    const float degree = float(pi / 180);
    Command<float> command{};
    command.frequency = m.param1;
    command.amplitude[0] = degree * m.param2, command.amplitude[1] = degree * m.param3;
    command.phase[1] = degree * m.param4;
    command.bias[0] = degree * m.param5, command.bias[1] = degree * m.param6;
    return set_gait(vehicle, from, command);
}

/// A parameter that must be a whole number from 0 to `high`; -1 if it is not.
inline int whole_of(float value, int high) {
    if (!(0.0f <= value && value <= float(high))) return -1;
    const int number = int(value);
    return float(number) == value ? number : -1;
}

inline Refusal arm_command(Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    const int on = whole_of(m.param1, 1);
    return on < 0 ? Refusal::out_of_range : give(vehicle, on == 1 ? Order::arm : Order::disarm, from);
}

/// Select a mode: the state of that number, by its order.
inline Refusal mode_command(Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    const int base = whole_of(m.param1, 255), state = whole_of(m.param2 - float(mode_base), states - 1);
    if (base < 0 || (base & MAV_MODE_FLAG_CUSTOM_MODE_ENABLED) == 0) return Refusal::unknown;
    return state < 0 ? Refusal::out_of_range : give(vehicle, state_texts[state].order, from);
}

/// Set the interval [us] of a message: 0 for the interval at boot, -1 for never, otherwise one tick to a minute.
inline Refusal interval_command(Radio& radio, const mavlink_command_long_t& m) {
    const int id = whole_of(m.param1, 1 << 24), k = id < 0 ? -1 : stream_index(std::uint32_t(id));
    if (k < 0) return Refusal::unknown;
    const bool heart = k == 0, never = m.param2 == -1.0f;
    if (!never && m.param2 != 0.0f && !(1e4f <= m.param2 && m.param2 <= 6e7f)) return Refusal::out_of_range;
    if (heart && (never || 1e6f < m.param2)) return Refusal::out_of_range;  // without it, clients report a lost link
    radio.telemetry.stream[k].interval = never              ? 0
                                         : m.param2 == 0.0f ? telemetry_messages[k].interval
                                                            : std::uint32_t(m.param2 * 1e-4f + 0.5f);
    return Refusal::none;
}

inline Refusal request_command(Radio& radio, const mavlink_command_long_t& m) {
    const int id = whole_of(m.param1, 1 << 24), k = id < 0 ? -1 : stream_index(std::uint32_t(id));
    if (k < 0) return Refusal::unknown;
    radio.telemetry.stream[k].requested = true;
    return Refusal::none;
}

/// Execute a command, and return why it is refused.
inline Refusal execute(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    switch (m.command) {
        case MAV_CMD_COMPONENT_ARM_DISARM:
            return arm_command(vehicle, from, m);
        case MAV_CMD_DO_SET_MODE:
            return mode_command(vehicle, from, m);
        case MAV_CMD_MISSION_START:
            return give(vehicle, Order::mission, from);
        case MAV_CMD_SET_MESSAGE_INTERVAL:
            return interval_command(radio, m);
        case MAV_CMD_REQUEST_MESSAGE:
            return request_command(radio, m);
        case MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
            radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_AUTOPILOT_VERSION)].requested = true;
            return Refusal::none;
        case HYPERTUNA_CMD_GAIT:
            return gait_command(vehicle, from, m);
        default:
            return Refusal::unknown;
    }
}

/// COMMAND_INT as COMMAND_LONG: NaN for coordinates, which no accepted command has.
inline mavlink_command_long_t long_of(const mavlink_command_int_t& m) {
    const auto number = [](std::int32_t x) { return x == 0 ? 0.0f : std::numeric_limits<float>::quiet_NaN(); };
    mavlink_command_long_t out{};
    out.command = m.command, out.target_system = m.target_system, out.target_component = m.target_component;
    out.param1 = m.param1, out.param2 = m.param2, out.param3 = m.param3, out.param4 = m.param4;
    out.param5 = number(m.x), out.param6 = number(m.y), out.param7 = m.z;
    return out;
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    acknowledge(radio, from, m.command, execute(radio, vehicle, from, m));
}
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_int_t& m) {
    handle(radio, vehicle, from, long_of(m));
}

inline bool is_disarm(const Frame& frame) {
    const bool is_int = frame.id == MAVLINK_MSG_ID_COMMAND_INT;
    if (!is_int && frame.id != MAVLINK_MSG_ID_COMMAND_LONG) return false;
    const mavlink_command_long_t m =
        is_int ? long_of(message_of<mavlink_command_int_t>(frame)) : message_of<mavlink_command_long_t>(frame);
    return m.command == MAV_CMD_COMPONENT_ARM_DISARM && m.param1 == 0.0f;
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_set_gps_global_origin_t& m) {
    report_refusal(radio, set_origin(vehicle, from, m.latitude, m.longitude));
}

}  // namespace hypertuna::firmware
