/// Message signing. mavlink.io/en/guide/message_signing.html
///
/// A signature is the first six bytes of SHA-256 over key, frame, channel and timestamp. A sender's timestamps
/// increase, so that a recorded frame is rejected.
#pragma once

#include "app/radio/frames.hpp"
#include "app/radio/sha256.hpp"

namespace hypertuna::firmware {

inline constexpr int key_length = 32, max_streams = 8, digest_length = 6;
inline constexpr int stamp_bits = 48;
inline constexpr std::uint64_t stamp_minute = 6'000'000,
                               stamp_reserve =
                                   240 *
                                   stamp_minute;  // a minute and the reserve of the stored stamp, in units of 10 us

/// A sender on one channel, and its last timestamp [10 us].
struct Stream {
    std::uint8_t system, component, channel;
    bool used;
    std::uint64_t stamp;
};

struct Signing {
    bool on, locked;  // the key is lost, so that no signature is accepted
    std::uint8_t key[key_length];
    std::uint64_t stamp;  // own clock [10 us since 2015], never behind a verified timestamp
    std::uint64_t floor;  // timestamp stored before boot, or of a sender that was forgotten: older ones are rejected
    Stream stream[max_streams];
    std::uint32_t refused;
};

/// Sign every frame from now on, and reject unsigned ones.
inline void begin_signing(Signing& signing, const std::uint8_t* key, std::uint64_t stamp) {
    signing = {};
    signing.on = true, signing.stamp = stamp;
    std::memcpy(signing.key, key, key_length);
}

inline void digest_of(const Signing& signing, const std::uint8_t* frame, int length, std::uint8_t* digest) {
    Sha256 hash;
    add(hash, signing.key, key_length);
    add(hash, frame, length);
    finish(hash, digest, digest_length);
}

/// Append channel, timestamp and signature to a frame; return its new length.
inline int sign(Signing& signing, std::uint8_t* frame, int length) {
    frame[length] = 0;  // the robot has one channel
    ++signing.stamp;
    for (int k = 0; k < 6; ++k) frame[length + 1 + k] = std::uint8_t(signing.stamp >> (8 * k));
    digest_of(signing, frame, length + 7, frame + length + 7);
    return length + signature_length;
}

/// Stream of a sender if its timestamp is acceptable, else nullptr. A new stream needs a timestamp at most a minute
/// old. Without a free slot it replaces the stream with the oldest timestamp; frames of that sender cannot be replayed
/// as another's.
inline Stream* stream_of(Signing& signing, const Frame& frame, std::uint8_t channel, std::uint64_t stamp) {
    Stream* place = signing.stream;
    for (Stream& stream : signing.stream) {
        if (stream.used && stream.system == frame.system && stream.component == frame.component &&
            stream.channel == channel)
            return stamp > stream.stamp ? &stream : nullptr;
        if (place->used && (!stream.used || stream.stamp < place->stamp)) place = &stream;
    }
    if (stamp + stamp_minute < signing.stamp || stamp < signing.floor) return nullptr;
    if (place->used && stamp <= place->stamp) return nullptr;
    if (place->used) signing.floor = place->stamp + 1;
    return place;
}

/// Whether a frame has the right key, and a timestamp later than its sender's last.
inline bool verify(Signing& signing, const Frame& frame) {
    if (!signing.on) return true;
    bool good = false;
    if (frame.is_signed && !signing.locked) {
        const int at = frame.length - signature_length;
        std::uint8_t digest[digest_length], differs = 0;
        digest_of(signing, frame.bytes, at + 7, digest);
        for (int k = 0; k < digest_length; ++k) differs = std::uint8_t(differs | (digest[k] ^ frame.bytes[at + 7 + k]));
        std::uint64_t stamp = 0;
        for (int k = 0; k < 6; ++k) stamp |= std::uint64_t(frame.bytes[at + 1 + k]) << (8 * k);
        Stream* stream = differs == 0 ? stream_of(signing, frame, frame.bytes[at], stamp) : nullptr;
        good = stream != nullptr;
        if (good) *stream = {frame.system, frame.component, frame.bytes[at], true, stamp};
        if (good && signing.stamp < stamp) signing.stamp = stamp;
    }
    signing.refused += !good;
    return good;
}

}  // namespace hypertuna::firmware
