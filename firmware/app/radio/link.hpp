/// Link: the radio's side of the robot. A tick takes what bytes came, passes orders on to the vehicle, and fills the
/// outbox with answers and telemetry as the radio allows.
///
/// Neither of it decides anything: what is done with an order is the vehicle's (vehicle.hpp).
#pragma once

#include "app/radio/orders.hpp"

namespace hypertuna::firmware {

inline constexpr int most_bytes = 512;         // that a tick takes: 50 kB/s
inline constexpr int most_frames = 8;          // that a tick makes
inline constexpr int most_answers_of_one = 3;  // order

/// Sign from now on, or not any more, as the parameters say.
inline void adopt_key(Signing& signing, const Vehicle& vehicle) {
    const bool wanted = key(vehicle) != nullptr && limits(vehicle).sign == 1.0f;
    if (wanted && !signing.on) std::memcpy(signing.key, key(vehicle), key_length);
    signing.on = wanted;
}

/// What lasts is a minute ahead of all stamps so far: one write a minute, and no recording is believed after a restart.
inline void keep_ahead(const Signing& signing, Vehicle& vehicle) {
    if (!signing.on || signing.stamp < vehicle.stamp) return;
    vehicle.stamp = signing.stamp + stamp_minute;
    keep(vehicle.stamps);
}

/// As the robot boots.
inline void boot(Link& link, const Vehicle& vehicle) {
    std::memset(static_cast<void*>(&link), 0, sizeof link);  // a temporary one would not fit onto the stack
    begin(link.telemetry);
    link.told = link.told_refusal = 0u - 1000u;  // long ago
    link.out.sender = {std::uint8_t(limits(vehicle).system_id), own_component, 0};
    link.signing.stamp = link.signing.floor = vehicle.stamp;
    adopt_key(link.signing, vehicle);
}

/// A key that comes over the radio begins signing, one of zeros ends it; once signing, only the old key's owner is
/// heard. The store keeps it. Never while armed.
inline void on_setup_signing(Link& link, Vehicle& vehicle, const mavlink_setup_signing_t& m) {
    std::uint8_t any = 0, secret[key_size];
    std::memcpy(secret, m.secret_key, key_size);
    for (std::uint8_t byte : secret) any = std::uint8_t(any | byte);
    const bool long_stamp = (m.initial_timestamp >> stamp_bits) != 0;
    Refusal refusal = long_stamp ? Refusal::out_of_range : set_key(vehicle, secret);
    if (refusal == Refusal::none)
        refusal = set_parameter(vehicle, parameter_named(vehicle, "sign"), any != 0 ? 1.0f : 0.0f);
    tell_refusal(link, refusal);
    if (refusal != Refusal::none) return;
    link.signing = {};
    link.signing.stamp = m.initial_timestamp;
    vehicle.stamp = 0;  // another key: nothing was recorded with it
    adopt_key(link.signing, vehicle);
}

/// What everybody may send: signs of life, questions for the time of the way, and the radio's own report.
inline void on_notice(Link& link, Vehicle& vehicle, const Frame& frame) {
    if (frame.id == MAVLINK_MSG_ID_RADIO_STATUS)
        return adapt(link.telemetry, message_of<mavlink_radio_status_t>(frame).txbuf, snapshot(vehicle).tick);
    if (frame.id == MAVLINK_MSG_ID_HEARTBEAT) {
        if (message_of<mavlink_heartbeat_t>(frame).type == MAV_TYPE_GCS) heard(vehicle);
        return;
    }
    auto m = message_of<mavlink_ping_t>(frame);
    if (m.target_system != 0 || !has_room(link.out)) return;
    m.target_system = frame.system, m.target_component = frame.component;
    reply(link.out, m);
}

inline bool is_notice(std::uint32_t id) {
    return id == MAVLINK_MSG_ID_RADIO_STATUS || id == MAVLINK_MSG_ID_HEARTBEAT || id == MAVLINK_MSG_ID_PING;
}

inline void on_origin(Link& link, Vehicle& vehicle, const mavlink_set_gps_global_origin_t& m) {
    if (m.target_system != link.out.sender.system && m.target_system != 0) return;
    ++link.orders;
    tell_refusal(link, set_origin(vehicle, m.latitude, m.longitude));
}

inline void on_order(Link& link, Vehicle& vehicle, const Frame& frame) {
    const Peer from{frame.system, frame.component};
    switch (frame.id) {
        case MAVLINK_MSG_ID_COMMAND_LONG:
        case MAVLINK_MSG_ID_COMMAND_INT:
            return follow_message(link, command_of(frame), [&](const auto& m) {
                acknowledge(link, from, m.command, carry_out(link, vehicle, m));
            });
        case MAVLINK_MSG_ID_GAIT_SET:
            return follow_order<mavlink_gait_set_t>(link, frame,
                                                    [&](const auto& m) { on_gait_set(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_PARAM_SET:
            return follow_order<mavlink_param_set_t>(link, frame,
                                                     [&](const auto& m) { on_param_set(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_PARAM_REQUEST_READ:
            return follow_order<mavlink_param_request_read_t>(
                link, frame, [&](const auto& m) { on_param_request_read(link, vehicle, from, m); });
        case MAVLINK_MSG_ID_PARAM_REQUEST_LIST:
            return follow_order<mavlink_param_request_list_t>(
                link, frame, [&](const auto&) { on_param_request_list(link, vehicle); });
        case MAVLINK_MSG_ID_SETUP_SIGNING:
            return follow_order<mavlink_setup_signing_t>(link, frame,
                                                         [&](const auto& m) { on_setup_signing(link, vehicle, m); });
        case MAVLINK_MSG_ID_MANUAL_CONTROL: {
            const auto m = message_of<mavlink_manual_control_t>(frame);
            return m.target == link.out.sender.system ? on_manual(link, vehicle, m) : void();
        }
        case MAVLINK_MSG_ID_SET_GPS_GLOBAL_ORIGIN:
            return on_origin(link, vehicle, message_of<mavlink_set_gps_global_origin_t>(frame));
        default:
            return on_mission_order(link, vehicle, frame);
    }
}

/// One frame: is it signed where it must be, newer than the last, and is there a place for the answers?
inline void on_frame(Link& link, Vehicle& vehicle, const Frame& frame) {
    const std::uint32_t tick = snapshot(vehicle).tick;
    if (frame.system == link.out.sender.system) return;  // an echo
    const bool radio = frame.id == MAVLINK_MSG_ID_RADIO_STATUS;
    if (!radio && !believe(link.signing, frame)) return ++link.not_signed, tell_rarely(link, tick, Refusal::not_signed);
    const bool fresh = is_fresh(link, frame, tick);
    if (is_notice(frame.id)) return fresh || radio ? on_notice(link, vehicle, frame) : void();
    if (!fresh) return ++link.replayed, tell_rarely(link, tick, Refusal::replayed);
    // An order without a place for its answers is not followed: its sender asks again. Disarming never waits.
    if (!has_room(link.out, most_answers_of_one) && !is_disarm(frame)) return void(++link.no_place);
    const std::uint32_t orders = link.orders;
    on_order(link, vehicle, frame);
    if (link.orders != orders) heard(vehicle);  // it was for this robot
}

/// Tell what the supervisor newly found, one fault a second.
inline void tell_faults(Link& link, const Snapshot& now) {
    link.told_faults.flags &= now.faults.flags;
    const std::uint32_t fresh = now.faults.flags & ~link.told_faults.flags;
    if (fresh == 0 || now.tick - link.told < 100 || !has_room(link.out, most_answers_of_one)) return;
    for (int f = 0; f < faults; ++f)
        if (fresh >> f & 1) {
            link.told_faults.set(Fault(f), true), link.told = now.tick;
            const bool warn = fault_texts[f].answer == Answer::warn;
            return tell(link, std::uint8_t(warn ? MAV_SEVERITY_WARNING : MAV_SEVERITY_CRITICAL),
                        fault_texts[f].sentence);
        }
}

/// Fill the outbox: answers first, then parameters and telemetry in turn.
inline void speak(Link& link, const Vehicle& vehicle) {
    Outbox& out = link.out;
    const Limits& limit = limits(vehicle);
    if (report_lasts < snapshot(vehicle).tick - link.telemetry.reported) link.telemetry.slow = 100;
    out.rate = limit.link_rate / 8.0f / ticks_per_second * limit.link_share * float(link.telemetry.slow) / 100.0f;
    out.sender.system = std::uint8_t(limit.system_id);
    allow(out);
    for (int k = 0; k < most_frames && may_send(out); ++k) {
        if (send_answer(out, link.signing)) continue;
        const bool listed = (out.frames & 1) != 0 && send_listed(link, vehicle);
        if (listed || telemeter(link.telemetry, out, link.signing, vehicle, link.parser)) continue;
        if (!send_listed(link, vehicle)) break;
    }
}

/// One tick. The bytes are those that came since the last; link.out has what is to go.
inline void tick(Link& link, Vehicle& vehicle, const std::uint8_t* bytes, int count) {
    const std::uint32_t now = snapshot(vehicle).tick;
    adopt_key(link.signing, vehicle);
    link.signing.stamp += std::uint64_t(1e5f / ticks_per_second);
    const int most = count < most_bytes ? count : most_bytes;
    Frame frame;
    for (int at = 0; at < most;) {
        at += feed(link.parser, bytes + at, most - at);
        while (next(link.parser, frame)) on_frame(link, vehicle, frame);
    }
    keep_ahead(link.signing, vehicle);
    wait_for_item(link, now);
    tell_faults(link, snapshot(vehicle));
    speak(link, vehicle);
}

}  // namespace hypertuna::firmware
