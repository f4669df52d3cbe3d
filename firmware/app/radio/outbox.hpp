/// Outbox: what the board is to send next, within what the radio carries.
///
/// Telemetry is made when there is room for it, so it never waits; answers wait in a few places of fixed size, and an
/// order that finds none is not carried out but asked for again by its sender.
#pragma once

#include "app/radio/signing.hpp"

namespace hypertuna::firmware {

/// Bytes that a frame costs beside its own: the radio sends it as a packet, with preamble and header and a pause behind
/// it. These are 12 bytes and 10 ms of a LoRa module at 4.8 kbit/s.
inline constexpr int packet_cost = 18;
inline constexpr int most_answers = 8, longest_answer = 80, outbox_size = 2 * longest_frame;

struct Reply {
    const MessageKind* kind;
    std::uint8_t payload[longest_answer];
};

struct Outbox {
    std::uint8_t bytes[outbox_size];
    int fill;
    Sender sender;
    float allowance;  // bytes that may be sent now
    float rate;       // bytes a tick
    Reply reply[most_answers];
    int first, answers;
    int most_waiting;            // answers that ever waited at once
    std::uint32_t frames, sent;  // so far; bytes
};

/// A tick's share of the radio. What is not used is kept for one frame of the longest kind.
inline void allow(Outbox& out) {
    const float most = out.rate > float(longest_frame) ? out.rate : float(longest_frame);
    out.allowance = out.allowance + out.rate < most ? out.allowance + out.rate : most;
}

/// Whether one more frame may be made now: the radio has paid for those before, and the board took them.
inline bool may_send(const Outbox& out) { return 0.0f < out.allowance && out.fill + longest_frame <= outbox_size; }

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

inline bool has_room(const Outbox& out, int places = 1) { return out.answers + places <= most_answers; }

/// Put an answer behind those that wait. Whoever calls has asked for a place.
template <class Message>
void reply(Outbox& out, const Message& message) {
    static_assert(kind_of<Message>.most <= longest_answer);
    if (!has_room(out)) return;
    Reply& place = out.reply[(out.first + out.answers++) % most_answers];
    place.kind = &kind_of<Message>;
    std::memcpy(place.payload, &message, kind_of<Message>.most);
    if (out.most_waiting < out.answers) out.most_waiting = out.answers;
}

/// Send the answer that has waited longest.
inline bool send_answer(Outbox& out, Signing& signing) {
    if (out.answers == 0) return false;
    const Reply& place = out.reply[out.first];
    send_payload(out, signing, *place.kind, place.payload);
    out.first = (out.first + 1) % most_answers, --out.answers;
    return true;
}

/// The board has taken so many bytes.
inline void taken(Outbox& out, int count) {
    out.fill -= count;
    std::memmove(out.bytes, out.bytes + count, std::size_t(out.fill));
}

}  // namespace hypertuna::firmware
