/// Dispatch: which messages the robot accepts, and what it does with a frame.
///
/// The radio decides nothing about a command: the vehicle accepts or refuses it (vehicle.hpp).
#pragma once

#include "app/radio/commands.hpp"

namespace hypertuna::firmware {

template <class... Messages>
struct MessageList {};

/// Messages that anybody may send: signs of life, times, the radio modem's own status.
using Notices =
    MessageList<mavlink_heartbeat_t, mavlink_ping_t, mavlink_timesync_t, mavlink_system_time_t, mavlink_radio_status_t>;

/// Commands: each has a sender, a target, and a `handle`.
using Commands =
    MessageList<mavlink_param_request_read_t, mavlink_param_request_list_t, mavlink_param_set_t,
                mavlink_mission_request_t, mavlink_mission_request_int_t, mavlink_mission_request_list_t,
                mavlink_mission_count_t, mavlink_mission_item_int_t, mavlink_mission_clear_all_t, mavlink_mission_ack_t,
                mavlink_manual_control_t, mavlink_command_long_t, mavlink_command_int_t, mavlink_setup_signing_t,
                mavlink_gait_set_t, mavlink_set_gps_global_origin_t, mavlink_file_transfer_protocol_t,
                mavlink_set_mode_t, mavlink_mission_set_current_t>;

template <class... N, class... C>
constexpr auto kinds_of(MessageList<N...>, MessageList<C...>) {
    struct {
        MessageKind kind[sizeof...(N) + sizeof...(C)];
    } all{{kind_of<N>..., kind_of<C>...}};
    return all;
}
inline constexpr auto accepted = kinds_of(Notices{}, Commands{});

/// Call act(message) if the frame's message is one of a list; return whether it is.
template <class... Messages, class Act>
bool visit_message(MessageList<Messages...>, const Frame& frame, const Act& act) {
    return ((frame.id == kind_of<Messages>.id && (act(message_of<Messages>(frame)), true)) || ...);
}

/// Start or stop signing, as key and parameter say.
inline void adopt_key(Signing& signing, const Vehicle& vehicle) {
    const bool on = key(vehicle) != nullptr && limits(vehicle).sign == 1.0f;
    if (on && !signing.on) std::memcpy(signing.key, key(vehicle), key_length);
    signing.on = on || vehicle.locked, signing.locked = vehicle.locked;
}

/// The stored timestamp is hours ahead of all so far, since nothing is stored while armed: after a restart or a loss of
/// power, the recordings of two armed hours at least are rejected. It is stored before a command is executed, and the
/// vehicle arms only then.
inline void store_stamp(const Signing& signing, Vehicle& vehicle) {
    if (!signing.on || signing.locked || signing.stamp + stamp_reserve / 2 < vehicle.stamp) return;
    vehicle.stamp = signing.stamp + stamp_reserve;
    begin_write(vehicle.stamps);
}

/// A key received over the radio starts signing, a key of zeros stops it; while signing, only the owner of the old key
/// may change it. The key is stored. Refused while armed.
inline void handle(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_setup_signing_t& m) {
    std::uint8_t any = 0, secret[key_size];
    std::memcpy(secret, m.secret_key, key_size);
    for (std::uint8_t byte : secret) any = std::uint8_t(any | byte);
    const bool long_stamp = (m.initial_timestamp >> stamp_bits) != 0;
    Refusal refusal = long_stamp ? Refusal::out_of_range : set_key(vehicle, from, secret);
    if (refusal == Refusal::none)
        refusal = set_parameter(vehicle, from, parameter_named(vehicle, "sign"), any != 0 ? 1.0f : 0.0f);
    report_refusal(radio, vehicle, refusal);
    if (refusal != Refusal::none) return;
    radio.signing = {};
    radio.signing.stamp = m.initial_timestamp;
    vehicle.stamp = 0;  // nothing was recorded with the new key
    adopt_key(radio.signing, vehicle);
}

inline void notice(Radio&, Vehicle& vehicle, Peer from, const mavlink_heartbeat_t& m) {
    if (m.type == MAV_TYPE_GCS) on_ground_contact(vehicle, from);
}
inline void notice(Radio& radio, Vehicle&, Peer from, mavlink_ping_t m) {
    if (m.target_system != 0 || !has_room(radio.out)) return;
    m.target_system = from.system, m.target_component = from.component;
    reply(radio.out, m);
}
/// Answer with the time since boot [ns].
inline void notice(Radio& radio, Vehicle& vehicle, Peer, mavlink_timesync_t m) {
    if (m.tc1 != 0 || !has_room(radio.out)) return;
    m.tc1 = std::int64_t(snapshot(vehicle).tick) * 10000000 + 1;
    reply(radio.out, m);
}
/// The robot has no use for the time of day.
inline void notice(Radio&, Vehicle&, Peer, const mavlink_system_time_t&) {}
inline void notice(Radio& radio, Vehicle& vehicle, Peer, const mavlink_radio_status_t& m) {
    adapt(radio.telemetry, m.txbuf, snapshot(vehicle).tick);
}

/// Act on a command that is for this robot: then the ground is in contact.
inline void command(Radio& radio, Vehicle& vehicle, const Frame& frame) {
    visit_message(Commands{}, frame, [&](const auto& m) {
        if (!is_for(radio, m)) return;
        ++radio.commands;
        const Peer from{frame.system, frame.component};
        handle(radio, vehicle, from, m);
        on_ground_contact(vehicle, from);
    });
}

/// Act on a frame that is signed where it must be, new, and whose answers have room. Disarming needs neither order nor
/// room. A companion computer may have the robot's system id.
inline void on_frame(Radio& radio, Vehicle& vehicle, const Frame& frame) {
    const std::uint32_t tick = snapshot(vehicle).tick;
    if (frame.system == radio.out.sender.system && frame.component == own_component) return;  // an echo
    // A modem does not sign its status: the frame must not count as its sender's last.
    const bool modem = frame.id == MAVLINK_MSG_ID_RADIO_STATUS;
    if (!modem && !verify(radio.signing, frame))
        return ++radio.not_signed, report_rarely(radio, tick, Refusal::not_signed);
    store_stamp(radio.signing, vehicle);
    const bool fresh = modem || radio.signing.on || is_new(radio.run, frame, tick);  // signatures have their own order
    const bool noticed = visit_message(Notices{}, frame, [&](const auto& m) {
        if (fresh) notice(radio, vehicle, Peer{frame.system, frame.component}, m);
    });
    if (noticed) return;
    if (!is_disarm(frame)) {
        if (!fresh) return ++radio.replayed, report_rarely(radio, tick, Refusal::replayed);
        // A command whose answers have no room is not executed: its sender repeats it.
        if (!has_room(radio.out, max_answers_per_command)) return void(++radio.no_room);
    }
    command(radio, vehicle, frame);
}

}  // namespace hypertuna::firmware
