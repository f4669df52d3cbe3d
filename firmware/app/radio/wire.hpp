/// Wire: what the radio must know about each message of the dialect, from the headers that generate.py makes from the
/// XML.
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
    std::uint8_t crc_extra;  // checksum of the fields' names and types: different dialects reject each other's frames
    std::uint8_t min_length, max_length;  // payload [bytes] without and with extensions; trailing zeros may be omitted
};

template <class Message>
inline constexpr MessageKind kind_of{};

#define HYPERTUNA_MESSAGE(type, NAME)                                                                            \
    template <>                                                                                                  \
    inline constexpr MessageKind kind_of<mavlink_##type##_t>{MAVLINK_MSG_ID_##NAME, MAVLINK_MSG_ID_##NAME##_CRC, \
                                                             MAVLINK_MSG_ID_##NAME##_MIN_LEN,                    \
                                                             MAVLINK_MSG_ID_##NAME##_LEN};
#include <hypertuna/messages.inc>  // every message of the dialect
#undef HYPERTUNA_MESSAGE

template <class... Messages>
struct MessageList {};
#define HYPERTUNA_MESSAGE(type, NAME) mavlink_##type##_t,
using Dialect = MessageList<
#include <hypertuna/messages.inc>
    void>;
#undef HYPERTUNA_MESSAGE

}  // namespace hypertuna::firmware
