/// Outbox: bytes for the board to send, within the radio's data rate.
///
/// Telemetry is made only when there is room for it, and never waits. Answers wait in a short queue.
#pragma once

#include "app/radio/signing.hpp"

namespace hypertuna::firmware {

/// Overhead of a frame [bytes]: the radio sends it as a packet with preamble, header and a pause. For a LoRa module at
/// 4.8 kbit/s these are 12 bytes and 10 ms.
inline constexpr int packet_cost = 18;
inline constexpr int max_answers_per_command = 3;
inline constexpr int max_answers = 8, max_answer = 80, outbox_size = 2 * max_frame;

struct Reply {
    MessageKind kind;
    std::uint8_t payload[max_answer];
};

struct Outbox {
    std::uint8_t bytes[outbox_size];
    int fill;
    Sender sender;
    float allowance;  // bytes that may be sent now
    float rate;       // bytes per tick
    Reply reply[max_answers];
    int first, answers;
    int max_waiting;             // largest number of answers that waited at once
    std::uint32_t frames, sent;  // since boot: frames, bytes
};

/// Add a tick's share of a data rate to an allowance, which is limited to the longest frame.
inline void allow(float& allowance, float rate) {
    const float limit = rate > float(max_frame) ? rate : float(max_frame);
    allowance = allowance + rate < limit ? allowance + rate : limit;
}

/// Bytes of the data rate that the longest frame of a message takes.
template <class Message>
inline constexpr int cost_of = head_length + kind_of<Message>.max_length + crc_length + signature_length + packet_cost;

/// Least data rate: a heartbeat and the answer to a command per second [bytes/s].
inline constexpr int least_rate = cost_of<mavlink_heartbeat_t> + cost_of<mavlink_command_ack_t>;

/// Whether one more frame may be made: the allowance is positive, and the buffer has room.
inline bool may_send(const Outbox& out) { return 0.0f < out.allowance && out.fill + max_frame <= outbox_size; }

inline void send_payload(Outbox& out, Signing& signing, const MessageKind& kind, const std::uint8_t* payload) {
    int length = write_frame(out.bytes + out.fill, kind, payload, out.sender, signing.on);
    if (signing.on) length = sign(signing, out.bytes + out.fill, length);
    out.fill += length, out.allowance -= float(length + packet_cost);
    ++out.frames, out.sent += std::uint32_t(length);
}

template <class Message>
void send(Outbox& out, Signing& signing, const Message& message) {
    send_payload(out, signing, kind_of<Message>, reinterpret_cast<const std::uint8_t*>(&message));
}

inline bool has_room(const Outbox& out, int places = 1) { return out.answers + places <= max_answers; }

/// Queue an answer, cut to max_answer bytes; the caller has checked has_room().
template <class Message>
void reply(Outbox& out, const Message& message) {
    if (!has_room(out)) return;
    Reply& place = out.reply[(out.first + out.answers++) % max_answers];
    place.kind = kind_of<Message>;
    if (max_answer < place.kind.max_length) place.kind.max_length = max_answer;
    std::memcpy(place.payload, &message, place.kind.max_length);
    if (out.max_waiting < out.answers) out.max_waiting = out.answers;
}

/// Send the oldest answer.
inline bool send_answer(Outbox& out, Signing& signing) {
    if (out.answers == 0) return false;
    const Reply& place = out.reply[out.first];
    send_payload(out, signing, place.kind, place.payload);
    out.first = (out.first + 1) % max_answers, --out.answers;
    return true;
}

/// Drop the bytes that the board has sent.
inline void drop_sent(Outbox& out, int count) {
    out.fill -= count;
    std::memmove(out.bytes, out.bytes + count, std::size_t(out.fill));
}

}  // namespace hypertuna::firmware
