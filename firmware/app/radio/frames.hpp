/// Frames of MAVLink 2: found in a stream of bytes, and written. mavlink.io/en/guide/serialization.html
///
/// A frame that fails its checksum loses its first byte alone: a good one that begins inside of it is found. What the
/// robot does not listen to is no frame at all, so that no noise can make it wait for more than its own messages have.
#pragma once

#include <cstring>

#include "app/radio/wire.hpp"

namespace hypertuna::firmware {

inline constexpr int head_length = 10, crc_length = 2, signature_length = 13;
inline constexpr int longest_payload = 255;
inline constexpr int longest_frame = head_length + longest_payload + crc_length + signature_length;
inline constexpr std::uint8_t frame_mark = 0xFD, signed_flag = 1;

/// A whole frame, where it lies among the parser's bytes: good until the next is taken.
struct Frame {
    std::uint32_t id;
    std::uint8_t system, component, sequence;  // of the sender
    bool is_signed;
    const std::uint8_t* bytes;
    int length, payload;  // of all bytes, and of the message among them
};

/// CRC-16/MCRF4XX, polynomial 0x1021 reflected, begun with all ones.
inline std::uint16_t crc_step(std::uint16_t crc, std::uint8_t byte) {
    std::uint8_t x = std::uint8_t(byte ^ (crc & 0xFF));
    x = std::uint8_t(x ^ (x << 4));
    return std::uint16_t((crc >> 8) ^ (x << 8) ^ (x << 3) ^ (x >> 4));
}

/// Checksum of a frame: all but its mark, then what stands for the message's definition.
inline std::uint16_t frame_crc(const std::uint8_t* bytes, int length, std::uint8_t crc_extra) {
    std::uint16_t crc = 0xFFFF;
    for (int k = 1; k < length; ++k) crc = crc_step(crc, bytes[k]);
    return crc_step(crc, crc_extra);
}

/// Bytes that wait for the rest of their frame, and what became of those before.
struct Parser {
    std::uint8_t bytes[longest_frame];
    int fill, taken;                     // taken: of the frame that was found last
    std::uint32_t frames, bad, skipped;  // good ones; checksums that failed; bytes of no frame
};

inline void drop(Parser& parser, int count) {
    parser.fill -= count;
    std::memmove(parser.bytes, parser.bytes + count, std::size_t(parser.fill));
}

/// Take as many bytes as there is room for, and say how many.
inline int feed(Parser& parser, const std::uint8_t* bytes, int count) {
    const int room = longest_frame - parser.fill, taken = count < room ? count : room;
    std::memcpy(parser.bytes + parser.fill, bytes, std::size_t(taken));
    parser.fill += taken;
    return taken;
}

inline std::uint32_t id_of(const std::uint8_t* frame) {
    return frame[7] | std::uint32_t(frame[8]) << 8 | std::uint32_t(frame[9]) << 16;
}

enum class Look : std::uint8_t { none, more, good };

/// What the first bytes are: no frame, one that lacks bytes, or a good one.
inline Look look(const std::uint8_t* bytes, int fill, int& length, std::uint32_t& failed) {
    if (bytes[0] != frame_mark) return Look::none;
    if (fill < head_length) return Look::more;
    const MessageKind* kind = heard_kind(id_of(bytes));
    if (kind == nullptr || bytes[1] > kind->most || bytes[1] < 1 || (bytes[2] & ~signed_flag) != 0) return Look::none;
    const int crc_at = head_length + bytes[1];
    length = crc_at + crc_length + (bytes[2] & signed_flag ? signature_length : 0);
    if (fill < length) return Look::more;
    const std::uint16_t crc = frame_crc(bytes, crc_at, kind->crc_extra);
    if (bytes[crc_at] == (crc & 0xFF) && bytes[crc_at + 1] == crc >> 8) return Look::good;
    ++failed;
    return Look::none;
}

/// Find the next frame among the bytes, if there is a whole one. Bytes that begin none are dropped.
inline bool next(Parser& parser, Frame& frame) {
    drop(parser, parser.taken);
    int at = 0, length = 0;
    Look found = Look::none;
    while (at < parser.fill) {
        found = look(parser.bytes + at, parser.fill - at, length, parser.bad);
        if (found != Look::none) break;
        ++at, ++parser.skipped;
    }
    drop(parser, at);
    parser.taken = found == Look::good ? length : 0;
    if (found != Look::good) return false;
    ++parser.frames;
    const std::uint8_t* b = parser.bytes;
    frame = {id_of(b), b[5], b[6], b[4], (b[2] & signed_flag) != 0, b, length, b[1]};
    return true;
}

/// The message that a frame of its kind has; what was left out of it is zero.
template <class Message>
Message message_of(const Frame& frame) {
    Message message{};
    std::memcpy(static_cast<void*>(&message), frame.bytes + head_length, std::size_t(frame.payload));
    return message;
}

/// Who speaks, and how many frames it has sent.
struct Sender {
    std::uint8_t system, component, sequence;
};

/// Write a frame of a payload, trailing zeros left out, and return its length. With room for a signature it says so in
/// its head; `sign` adds it.
inline int write_frame(std::uint8_t* out, const MessageKind& kind, const std::uint8_t* payload, Sender& sender,
                       bool to_sign) {
    int length = kind.most;
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
