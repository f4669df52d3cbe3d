/// Wire: what the link must know of each message of the dialect, from the headers that mavgen makes of hypertuna.xml.
///
/// A generated struct has its fields in the order of the wire, and both sides are little-endian: payload and struct
/// are the same bytes.
#pragma once

#include <hypertuna/mavlink.h>

#include <bit>
#include <cstdint>

namespace hypertuna::firmware {

static_assert(std::endian::native == std::endian::little);

struct MessageKind {
    std::uint32_t id;
    std::uint8_t crc_extra;    // of its fields' names and types: two dialects that differ do not understand each other
    std::uint8_t least, most;  // bytes of payload without and with extensions; trailing zeros may be left out
};

template <class Message>
inline constexpr MessageKind kind_of{};

#define HYPERTUNA_MESSAGE(type, NAME)                                                                            \
    template <>                                                                                                  \
    inline constexpr MessageKind kind_of<mavlink_##type##_t>{MAVLINK_MSG_ID_##NAME, MAVLINK_MSG_ID_##NAME##_CRC, \
                                                             MAVLINK_MSG_ID_##NAME##_MIN_LEN,                    \
                                                             MAVLINK_MSG_ID_##NAME##_LEN};

// What the robot hears,
HYPERTUNA_MESSAGE(heartbeat, HEARTBEAT)
HYPERTUNA_MESSAGE(ping, PING)
HYPERTUNA_MESSAGE(param_request_read, PARAM_REQUEST_READ)
HYPERTUNA_MESSAGE(param_request_list, PARAM_REQUEST_LIST)
HYPERTUNA_MESSAGE(param_set, PARAM_SET)
HYPERTUNA_MESSAGE(mission_request, MISSION_REQUEST)
HYPERTUNA_MESSAGE(mission_request_int, MISSION_REQUEST_INT)
HYPERTUNA_MESSAGE(mission_request_list, MISSION_REQUEST_LIST)
HYPERTUNA_MESSAGE(mission_count, MISSION_COUNT)
HYPERTUNA_MESSAGE(mission_item_int, MISSION_ITEM_INT)
HYPERTUNA_MESSAGE(mission_clear_all, MISSION_CLEAR_ALL)
HYPERTUNA_MESSAGE(mission_ack, MISSION_ACK)
HYPERTUNA_MESSAGE(set_gps_global_origin, SET_GPS_GLOBAL_ORIGIN)
HYPERTUNA_MESSAGE(manual_control, MANUAL_CONTROL)
HYPERTUNA_MESSAGE(command_long, COMMAND_LONG)
HYPERTUNA_MESSAGE(command_int, COMMAND_INT)
HYPERTUNA_MESSAGE(radio_status, RADIO_STATUS)
HYPERTUNA_MESSAGE(setup_signing, SETUP_SIGNING)
HYPERTUNA_MESSAGE(gait_set, GAIT_SET)
inline constexpr MessageKind heard_kinds[] = {
    kind_of<mavlink_heartbeat_t>,
    kind_of<mavlink_ping_t>,
    kind_of<mavlink_param_request_read_t>,
    kind_of<mavlink_param_request_list_t>,
    kind_of<mavlink_param_set_t>,
    kind_of<mavlink_mission_request_t>,
    kind_of<mavlink_mission_request_int_t>,
    kind_of<mavlink_mission_request_list_t>,
    kind_of<mavlink_mission_count_t>,
    kind_of<mavlink_mission_item_int_t>,
    kind_of<mavlink_mission_clear_all_t>,
    kind_of<mavlink_mission_ack_t>,
    kind_of<mavlink_manual_control_t>,
    kind_of<mavlink_command_long_t>,
    kind_of<mavlink_command_int_t>,
    kind_of<mavlink_radio_status_t>,
    kind_of<mavlink_setup_signing_t>,
    kind_of<mavlink_gait_set_t>,
    kind_of<mavlink_set_gps_global_origin_t>,
};

// and what it alone says.
HYPERTUNA_MESSAGE(sys_status, SYS_STATUS)
HYPERTUNA_MESSAGE(attitude, ATTITUDE)
HYPERTUNA_MESSAGE(local_position_ned, LOCAL_POSITION_NED)
HYPERTUNA_MESSAGE(servo_output_raw, SERVO_OUTPUT_RAW)
HYPERTUNA_MESSAGE(battery_status, BATTERY_STATUS)
HYPERTUNA_MESSAGE(param_value, PARAM_VALUE)
HYPERTUNA_MESSAGE(param_error, PARAM_ERROR)
HYPERTUNA_MESSAGE(mission_current, MISSION_CURRENT)
HYPERTUNA_MESSAGE(command_ack, COMMAND_ACK)
HYPERTUNA_MESSAGE(message_interval, MESSAGE_INTERVAL)
HYPERTUNA_MESSAGE(autopilot_version, AUTOPILOT_VERSION)
HYPERTUNA_MESSAGE(statustext, STATUSTEXT)
HYPERTUNA_MESSAGE(gps_global_origin, GPS_GLOBAL_ORIGIN)
HYPERTUNA_MESSAGE(hydraulics, HYDRAULICS)
HYPERTUNA_MESSAGE(gait, GAIT)
HYPERTUNA_MESSAGE(pilot, PILOT)
#undef HYPERTUNA_MESSAGE

/// The kind of message that the robot hears under an id; nullptr for one that it does not listen to.
inline const MessageKind* heard_kind(std::uint32_t id) {
    for (const MessageKind& kind : heard_kinds)
        if (kind.id == id) return &kind;
    return nullptr;
}

}  // namespace hypertuna::firmware
