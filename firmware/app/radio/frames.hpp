/// Parse and write frames of MAVLink 2. mavlink.io/en/guide/serialization.html
///
/// Of a frame that fails its checksum only the first byte is dropped: so a valid frame that begins inside it is found
/// without waiting. A message that the robot does not accept is no frame.
#pragma once

#include <cstring>

#include "app/radio/wire.hpp"

namespace hypertuna::firmware {

inline constexpr int head_length = 10, crc_length = 2, signature_length = 13;
inline constexpr int max_payload = 255;
inline constexpr int max_frame = head_length + max_payload + crc_length + signature_length;
inline constexpr int newer_fields = 16;  // bytes of extensions that a newer dialect may append to a message
inline constexpr std::uint8_t frame_mark = 0xFD, signed_flag = 1;

/// A complete frame in the parser's buffer: valid until the next call of next().
struct Frame {
    std::uint32_t id;
    std::uint8_t system, component, sequence;  // ids and sequence number of the sender
    bool is_signed;
    const std::uint8_t* bytes;
    int length, payload;  // bytes of the frame, and of the message in it
};

/// CRC-16/MCRF4XX: polynomial 0x1021 reflected, initial value 0xFFFF.
inline std::uint16_t crc_step(std::uint16_t crc, std::uint8_t byte) {
    std::uint8_t x = std::uint8_t(byte ^ (crc & 0xFF));
    x = std::uint8_t(x ^ (x << 4));
    return std::uint16_t((crc >> 8) ^ (x << 8) ^ (x << 3) ^ (x >> 4));
}

/// Checksum of a frame: all bytes but the mark, then the CRC_EXTRA of the message's definition.
inline std::uint16_t frame_crc(const std::uint8_t* bytes, int length, std::uint8_t crc_extra) {
    std::uint16_t crc = 0xFFFF;
    for (int k = 1; k < length; ++k) crc = crc_step(crc, bytes[k]);
    return crc_step(crc, crc_extra);
}

/// Buffer for one frame, and counters.
struct Parser {
    std::uint8_t bytes[max_frame];
    int fill, used;                      // bytes in the buffer; how many of them are of the last frame returned
    std::uint32_t frames, bad, skipped;  // valid frames; failed checksums; bytes that belong to no frame
};

inline void drop(Parser& parser, int count) {
    parser.fill -= count;
    std::memmove(parser.bytes, parser.bytes + count, std::size_t(parser.fill));
}

/// Append bytes as far as there is room; return their number.
inline int feed(Parser& parser, const std::uint8_t* bytes, int count) {
    const int room = max_frame - parser.fill, accepted = count < room ? count : room;
    std::memcpy(parser.bytes + parser.fill, bytes, std::size_t(accepted));
    parser.fill += accepted;
    return accepted;
}

inline std::uint32_t id_of(const std::uint8_t* frame) {
    return frame[7] | std::uint32_t(frame[8]) << 8 | std::uint32_t(frame[9]) << 16;
}

/// Kind of message that the robot accepts under an id; nullptr for all others (radio.cpp).
const MessageKind* accepted_kind(std::uint32_t id);

enum class Check : std::uint8_t { no_frame, incomplete, valid };

/// Check whether the first bytes are a frame, and compute its length.
inline Check check_frame(const std::uint8_t* bytes, int fill, int& length, std::uint32_t& failed) {
    if (bytes[0] != frame_mark) return Check::no_frame;
    if (fill < head_length) return Check::incomplete;
    const MessageKind* kind = accepted_kind(id_of(bytes));
    if (kind == nullptr || bytes[1] < 1 || kind->max_length + newer_fields < bytes[1]) return Check::no_frame;
    if ((bytes[2] & ~signed_flag) != 0) return Check::no_frame;
    const int crc_at = head_length + bytes[1];
    length = crc_at + crc_length + (bytes[2] & signed_flag ? signature_length : 0);
    if (fill < length) return Check::incomplete;
    const std::uint16_t crc = frame_crc(bytes, crc_at, kind->crc_extra);
    if (bytes[crc_at] == (crc & 0xFF) && bytes[crc_at + 1] == crc >> 8) return Check::valid;
    ++failed;
    return Check::no_frame;
}

/// Find the next complete frame in the buffer. Bytes that begin no frame are dropped. Those of an incomplete frame are
/// dropped once a complete one follows, so that the beginning of a frame cannot hold up another sender's.
inline bool next(Parser& parser, Frame& frame) {
    drop(parser, parser.used);
    int at = 0, begun = 0, length = 0;  // bytes that begin no frame; how many of them are before an incomplete one
    bool waits = false;
    Check check = Check::no_frame;
    for (std::uint32_t ignored = 0; at < parser.fill; ++at) {
        check = check_frame(parser.bytes + at, parser.fill - at, length, waits ? ignored : parser.bad);
        if (check == Check::valid) break;
        waits = waits || check == Check::incomplete;
        begun += !waits;
    }
    const bool found = at < parser.fill;
    parser.skipped += std::uint32_t(found ? at : begun);
    drop(parser, found ? at : begun);
    parser.used = found ? length : 0;
    if (!found) return false;
    ++parser.frames;
    const std::uint8_t* b = parser.bytes;
    frame = {id_of(b), b[5], b[6], b[4], (b[2] & signed_flag) != 0, b, length, b[1]};
    return true;
}

/// Message of a frame; omitted trailing bytes are zero, unknown extensions are dropped.
template <class Message>
Message message_of(const Frame& frame) {
    constexpr int known = kind_of<Message>.max_length;
    Message message{};
    std::memcpy(static_cast<void*>(&message), frame.bytes + head_length,
                std::size_t(frame.payload < known ? frame.payload : known));
    return message;
}

/// Identity of a sender, and the sequence number of its next frame.
struct Sender {
    std::uint8_t system, component, sequence;
};

/// Write a frame without the payload's trailing zeros; return its length. With `to_sign`, the header announces the
/// signature that sign() appends.
inline int write_frame(std::uint8_t* out, const MessageKind& kind, const std::uint8_t* payload, Sender& sender,
                       bool to_sign) {
    int length = kind.max_length;
    while (length > 1 && payload[length - 1] == 0) --length;
    const std::uint8_t head[head_length] = {frame_mark,
                                            std::uint8_t(length),
                                            to_sign ? signed_flag : std::uint8_t(0),
                                            0,
                                            sender.sequence++,
                                            sender.system,
                                            sender.component,
                                            std::uint8_t(kind.id),
                                            std::uint8_t(kind.id >> 8),
                                            std::uint8_t(kind.id >> 16)};
    std::memcpy(out, head, head_length);
    std::memcpy(out + head_length, payload, std::size_t(length));
    const int end = head_length + length;
    const std::uint16_t crc = frame_crc(out, end, kind.crc_extra);
    out[end] = std::uint8_t(crc), out[end + 1] = std::uint8_t(crc >> 8);
    return end + crc_length;
}

}  // namespace hypertuna::firmware
