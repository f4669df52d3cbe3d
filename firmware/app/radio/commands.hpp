/// Commands of the ground: each is passed on to the vehicle, which accepts or refuses it, and is answered.
///
/// `handle` of a message's type acts on the message. Whether the message is for this robot was checked before
/// (dispatch.hpp).
#pragma once

#include "app/radio/files.hpp"
#include "app/radio/mission_protocol.hpp"
#include "app/radio/parameter_protocol.hpp"
#include "app/radio/services.hpp"

namespace hypertuna::firmware {

inline constexpr int stick_max = 1000, thrust_center = 500;  // full deflection of a joystick's axis; center of z

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
    // Ground stations send the sticks in every mode: outside `manual` that is not an error.
    if (refusal != Refusal::none && refusal != Refusal::not_now) report_rarely(radio, snapshot(vehicle).tick, refusal);
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_gait_set_t& m) {
    const auto angle = [](std::int16_t cdeg) { return float(cdeg) / centidegree; };
    Command<float> command{};
    command.frequency = float(m.frequency) * 1e-3f;
    static_assert(sizeof m.amplitude == max_joints * sizeof *m.amplitude);
    for (int j = 0; j < max_joints; ++j)
        command.amplitude[j] = angle(m.amplitude[j]), command.phase[j] = angle(m.lag[j]),
        command.bias[j] = angle(m.bias[j]);
    for (int k = 0; k < 2; ++k) command.fin[k] = angle(m.fin[k]);
    acknowledge(radio, vehicle, from, HYPERTUNA_CMD_GAIT, set_gait(vehicle, from, command));
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

/// Order that selects a mode by its number in HEARTBEAT. Numbers of other autopilots select none: they mean something
/// else.
inline Order order_of_mode(int base, float custom) {
    const int mode = whole_of(custom, mode_base + states);
    const bool own = 0 <= base && (base & MAV_MODE_FLAG_CUSTOM_MODE_ENABLED) != 0;
    return own && 0 <= mode ? order_of_mode(std::uint32_t(mode)) : Order::count;
}

/// Order of a mode as MAVSDK names it to every autopilot, like PX4: main mode AUTO in param2, a sub-mode in param3,
/// which no other autopilot uses. Order::count for all others.
inline Order order_of_submode(const mavlink_command_long_t& m) {
    if (m.param2 != 4.0f) return Order::count;
    switch (whole_of(m.param3, 6)) {
        case 3:
            return Order::pause;
        case 4:
            return Order::mission;
        case 5:
            return Order::home;
        case 6:
            return Order::surface;
        default:
            return Order::count;
    }
}

inline Order order_of_standard_mode(float mode) {
    return mode == float(MAV_STANDARD_MODE_MISSION)         ? Order::mission
           : mode == float(MAV_STANDARD_MODE_SAFE_RECOVERY) ? Order::home
                                                            : Order::count;
}

/// `order_of` a message is the order that the message gives without data of its own; Order::count if it gives none.
inline Order order_of(const mavlink_command_long_t& m) {
    const int choice = whole_of(m.param1, 1);
    const auto either = [choice](Order no, Order yes) { return choice < 0 ? Order::count : choice == 0 ? no : yes; };
    switch (m.command) {
        case MAV_CMD_COMPONENT_ARM_DISARM:
            return either(Order::disarm, Order::arm);
        case MAV_CMD_DO_PAUSE_CONTINUE:
            return either(Order::pause, Order::go_on);
        case MAV_CMD_DO_SET_MODE:
            if (const Order order = order_of_submode(m); order != Order::count) return order;
            return order_of_mode(whole_of(m.param1, 255), m.param2);
        case MAV_CMD_DO_SET_STANDARD_MODE:
            return order_of_standard_mode(m.param1);
        case MAV_CMD_NAV_RETURN_TO_LAUNCH:
            return Order::home;
        case MAV_CMD_NAV_LAND:
            return Order::surface;
        default:
            return Order::count;
    }
}
inline Order order_of(const mavlink_set_mode_t& m) { return order_of_mode(m.base_mode, float(m.custom_mode)); }
inline Order order_of(const mavlink_manual_control_t&) { return Order::sticks; }

/// Set the waypoint at which the mission begins or resumes, by the number of its item or of an item before that
/// waypoint.
inline Refusal leg_command(Vehicle& vehicle, Peer from, float item) {
    const int number = whole_of(item, max_items);
    return number < 0 ? Refusal::out_of_range : set_leg(vehicle, from, leg_of_item(vehicle, number));
}

/// Start or resume the mission, at an item if one is named.
inline Refusal start_command(Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    const Refusal refusal = 0.0f < m.param1 ? leg_command(vehicle, from, m.param1) : Refusal::none;
    return refusal != Refusal::none ? refusal : give(vehicle, Order::mission, from);
}

/// Execute a command that changes the state, and return why it is refused.
inline Refusal execute_order(Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    if (const Order order = order_of(m); order != Order::count) return give(vehicle, order, from);
    switch (m.command) {
        case MAV_CMD_MISSION_START:
            return start_command(vehicle, from, m);
        case MAV_CMD_DO_SET_MISSION_CURRENT:
            return leg_command(vehicle, from, m.param1);
        case HYPERTUNA_CMD_GAIT:
            return gait_command(vehicle, from, m);
        case MAV_CMD_COMPONENT_ARM_DISARM:
        case MAV_CMD_DO_PAUSE_CONTINUE:
            return Refusal::out_of_range;
        default:
            return Refusal::unknown;
    }
}

inline Refusal home_command(Radio& radio, Vehicle& vehicle, Peer from, const Place& to) {
    const Refusal refusal = set_home(vehicle, from, to);
    if (refusal == Refusal::none) radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_HOME_POSITION)].requested = true;
    return refusal;
}

/// Set home to coordinates, once a fix has placed the robot in a given origin. The altitude is not used.
inline Refusal home_command(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_int_t& m) {
    Item at{};
    at.frame = m.frame, at.x = m.x, at.y = m.y;
    Place to{};
    const Refusal refusal = vehicle.unplaced ? Refusal::not_placed : place_of(vehicle, at, to);
    return refusal == Refusal::none ? home_command(radio, vehicle, from, to) : refusal;
}

/// Execute a command, and return why it is refused.
inline Refusal execute(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    switch (m.command) {
        case MAV_CMD_SET_MESSAGE_INTERVAL:
            return interval_command(radio, m);
        case MAV_CMD_GET_MESSAGE_INTERVAL:
            return get_interval_command(radio, m);
        case MAV_CMD_REQUEST_MESSAGE:
            return request_command(radio, vehicle, m);
        case MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
            radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_AUTOPILOT_VERSION)].requested = true;
            return Refusal::none;
        case MAV_CMD_RUN_PREARM_CHECKS:
            return prearm_command(radio, vehicle, from);
        case MAV_CMD_PREFLIGHT_CALIBRATION:
            return calibration_command(radio, vehicle, from, m);
        case MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN:
            return reboot_command(radio, vehicle, m);
        case MAV_CMD_DO_SET_HOME:
            return m.param1 == 1.0f ? home_command(radio, vehicle, from, here(vehicle)) : Refusal::int_only;
        case MAV_CMD_DO_START_MAG_CAL:
        case MAV_CMD_DO_ACCEPT_MAG_CAL:
        case MAV_CMD_DO_CANCEL_MAG_CAL:
            return Refusal::by_program;
        default:
            return execute_order(vehicle, from, m);
    }
}

/// COMMAND_INT as COMMAND_LONG. Coordinates become NaN, since no command that is accepted in this form has any.
inline mavlink_command_long_t long_of(const mavlink_command_int_t& m) {
    const auto number = [](std::int32_t x) { return x == 0 ? 0.0f : std::numeric_limits<float>::quiet_NaN(); };
    mavlink_command_long_t out{};
    out.command = m.command, out.target_system = m.target_system, out.target_component = m.target_component;
    out.param1 = m.param1, out.param2 = m.param2, out.param3 = m.param3, out.param4 = m.param4;
    out.param5 = number(m.x), out.param6 = number(m.y), out.param7 = m.z;
    return out;
}
inline Order order_of(const mavlink_command_int_t& m) { return order_of(long_of(m)); }

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_long_t& m) {
    acknowledge(radio, vehicle, from, m.command, execute(radio, vehicle, from, m));
}
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_command_int_t& m) {
    if (m.command == MAV_CMD_DO_SET_HOME && m.param1 == 0.0f)
        return acknowledge(radio, vehicle, from, m.command, home_command(radio, vehicle, from, m));
    handle(radio, vehicle, from, long_of(m));
}

/// Older messages of the same orders, without an acknowledgement.
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_set_mode_t& m) {
    report_refusal(radio, vehicle, give(vehicle, order_of(m), from));
}
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_mission_set_current_t& m) {
    report_refusal(radio, vehicle, leg_command(vehicle, from, m.seq));
    radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_MISSION_CURRENT)].requested = true;
}

inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_set_gps_global_origin_t& m) {
    report_refusal(radio, vehicle, set_origin(vehicle, from, m.latitude, m.longitude));
}

}  // namespace hypertuna::firmware
