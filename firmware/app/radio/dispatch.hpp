/// Dispatch: which messages the robot accepts, and what it does with a frame.
///
/// The radio decides nothing about a command: the vehicle accepts or refuses it (vehicle.hpp).
#pragma once

#include "app/radio/commands.hpp"

namespace hypertuna::firmware {

/// Start or stop signing, depending on key and parameter.
inline void adopt_key(Signing& signing, const Vehicle& vehicle) {
    const bool on = key(vehicle) != nullptr && limits(vehicle).sign == 1.0f;
    if (on && !signing.on) std::memcpy(signing.key, key(vehicle), key_length);
    signing.on = on || vehicle.locked, signing.locked = vehicle.locked;
}

/// Store a timestamp hours ahead of all so far, since nothing is stored while armed: after a restart or a loss of
/// power, recordings of at least two armed hours are rejected. The timestamp is stored before a command is executed,
/// and the vehicle arms only then.
inline void store_stamp(const Signing& signing, Vehicle& vehicle) {
    if (!signing.on || signing.locked || signing.stamp + stamp_reserve / 2 < vehicle.stamp) return;
    vehicle.stamp = signing.stamp + stamp_reserve;
    begin_write(vehicle.stamps);
}

/// Handle a key: it starts signing and is stored; a key of zeros stops signing. While signing, only the owner of the
/// old key may change it. Refused while armed.
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
/// Ignore the time of day: the robot does not use it.
inline void notice(Radio&, Vehicle&, Peer, const mavlink_system_time_t&) {}
inline void notice(Radio& radio, Vehicle& vehicle, Peer from, const mavlink_radio_status_t& m) {
    if (from == modem) adapt(radio.telemetry, m.txbuf, snapshot(vehicle).tick);
}

/// Kinds of accepted messages. A message that anybody may send has a `notice`: signs of life, times, the radio modem's
/// own status. A command, which has a sender and a target, has a `handle`. The robot accepts those messages of the
/// dialect that have either.
template <class Message>
concept Notice = requires(Radio& to, Vehicle& vehicle, Peer from, const Message& m) { notice(to, vehicle, from, m); };
template <class Message>
concept Directed = requires(Radio& to, Vehicle& vehicle, Peer from, const Message& m) { handle(to, vehicle, from, m); };

template <class... Messages>
constexpr auto accepted_of(MessageList<Messages...>) {
    struct {
        MessageKind kind[(0 + ... + int(Notice<Messages> || Directed<Messages>))];
    } all{};
    int k = 0;
    ((Notice<Messages> || Directed<Messages> ? void(all.kind[k++] = kind_of<Messages>) : void()), ...);
    return all;
}
inline constexpr auto accepted = accepted_of(Dialect{});

/// Call act(message) with the frame's message, if `act` takes its type. Return whether it was called.
template <class... Messages, class Act>
bool visit_message(MessageList<Messages...>, const Frame& frame, const Act& act) {
    const auto visit = [&]<class Message>() __attribute__((always_inline)) {
        if constexpr (requires(const Message& m) { act(m); })
            return frame.id == kind_of<Message>.id && (act(message_of<Message>(frame)), true);
        else
            return false;
    };
    return (visit.template operator()<Messages>() || ...);
}

/// Whether a command is executed. Disarming may be late. A command that makes the robot safer does not wait for room
/// for its answer, and the sticks have no answer; any other command waits, and its sender repeats it.
HYPERTUNA_NOINLINE inline bool admits(Radio& radio, std::uint32_t tick, bool fresh, Order order) {
    if (!fresh && order != Order::disarm) return ++radio.replayed, report_rarely(radio, tick, Refusal::replayed), false;
    if (makes_safer(order) || order == Order::sticks || has_room(radio.out, max_answers_per_command)) return true;
    return ++radio.no_room, false;
}

/// Act on a command if it is for this robot, and note the contact with the ground.
inline void command(Radio& radio, Vehicle& vehicle, const Frame& frame, bool fresh) {
    visit_message(Dialect{}, frame, [&](const Directed auto& m) {
        Order order = Order::count;
        if constexpr (requires { order_of(m); }) order = order_of(m);
        if (!admits(radio, snapshot(vehicle).tick, fresh, order) || !is_for(radio, m)) return;
        ++radio.commands;
        const Peer from{frame.system, frame.component};
        handle(radio, vehicle, from, m);
        on_ground_contact(vehicle, from);
    });
}

/// Act on a frame that is signed where it must be. A companion computer may have the robot's system id.
inline void on_frame(Radio& radio, Vehicle& vehicle, const Frame& frame) {
    const std::uint32_t tick = snapshot(vehicle).tick;
    const bool echo = frame.system == radio.out.sender.system && frame.component == own_component;
    const Peer from{frame.system, frame.component};
    // A modem does not sign its status: its frame must not count as the last one of a sender.
    const bool status = frame.id == MAVLINK_MSG_ID_RADIO_STATUS;
    const bool believed = !echo && !status && verify(radio.signing, frame);
    // A stranger may send a frame without its signature, in whose place another station's frame begins.
    if (frame.is_signed && !believed) radio.parser.used -= signature_length;
    if (echo) return;
    if (!status && !believed) return ++radio.not_signed, report_rarely(radio, tick, Refusal::not_signed);
    store_stamp(radio.signing, vehicle);
    const bool fresh = status || radio.signing.on || is_new(radio.run, frame, tick);  // signatures have their own order
    const bool noticed = visit_message(Dialect{}, frame, [&](const Notice auto& m) {
        if (fresh) notice(radio, vehicle, from, m);
    });
    if (!noticed) command(radio, vehicle, frame, fresh);
}

}  // namespace hypertuna::firmware
