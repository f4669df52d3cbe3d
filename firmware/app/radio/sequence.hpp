/// Sequence: which frames are new. Radios repeat and reorder frames, and an old command must not be followed again.
///
/// Two stations with equal ids, such as QGroundControl and a script, number their frames independently. So there may be
/// several runs of numbers under the same ids: a frame belongs to the run that it continues.
#pragma once

#include "app/radio/frames.hpp"

namespace hypertuna::firmware {

inline constexpr int max_runs = 6;
inline constexpr std::uint32_t silence = 200;   // ticks after which a sender may begin its numbers anew
inline constexpr std::uint32_t max_late = 150;  // most ticks for which a radio holds a frame back
inline constexpr int window = 64;               // numbers that a run remembers, and at most skips
inline constexpr int max_lost = 3;              // most numbers that a frame may skip that another run has, too

/// A number of a run: the tick of its frame, and the checksum that distinguishes it from another station's.
struct Received {
    std::uint32_t tick;
    std::uint16_t checksum;
    bool any;
};

/// Frames of one sender, numbered without a jump.
struct Run {
    std::uint8_t system, component, last;
    bool used;
    std::uint32_t tick;         // tick of the last frame
    Received received[window];  // the frame with a number is at index number % window
};

inline std::uint16_t checksum_of(const Frame& frame) {
    const std::uint8_t* crc = frame.bytes + head_length + frame.payload;
    return std::uint16_t(crc[0] | crc[1] << 8);
}

/// Whether the frame of a skipped number may still come: that of the next number came lately.
inline bool may_be_late(const Run& run, std::uint8_t number, std::uint32_t tick) {
    for (std::uint8_t k = std::uint8_t(number + 1); k != std::uint8_t(run.last + 1); ++k)
        if (run.received[k % window].any) return tick - run.received[k % window].tick <= max_late;
    return false;
}

/// Add a frame to a run, or begin the run with it.
inline void extend(Run& run, const Frame& frame, std::uint32_t tick, bool begins) {
    if (begins) run = {};
    const int skipped = begins ? 0 : std::uint8_t(frame.sequence - run.last) - 1;
    for (int k = 1; k <= skipped; ++k) run.received[std::uint8_t(run.last + k) % window].any = false;
    run.system = frame.system, run.component = frame.component, run.last = frame.sequence;
    run.used = true, run.tick = tick;
    run.received[frame.sequence % window] = {tick, checksum_of(frame), true};
}

/// Whether a frame is new: neither repeated nor late in the run of its sender. A new frame is remembered.
inline bool is_new(Run (&runs)[max_runs], const Frame& frame, std::uint32_t tick) {
    Run *next = nullptr, *idle = runs;
    int nearest = window + 1;
    bool late = false, repeated = false;
    for (Run& run : runs) {
        if (idle->used && (!run.used || tick - run.tick > tick - idle->tick)) idle = &run;
        const bool same = run.used && run.system == frame.system && run.component == frame.component;
        if (!same || silence < tick - run.tick) continue;
        const int behind = std::uint8_t(run.last - frame.sequence), ahead = 256 - behind;
        const Received& before = run.received[frame.sequence % window];
        if (window <= behind) {
            if (ahead < nearest) nearest = ahead, next = &run;
        } else if (before.any) {
            repeated = repeated || before.checksum == checksum_of(frame);
        } else {
            late = late || may_be_late(run, frame.sequence, tick);
        }
    }
    // Two stations may send equal frames under equal numbers: such a frame is new if it is the next of another run.
    if (repeated ? max_lost + 1 < nearest : next == nullptr && late) return false;
    extend(next != nullptr ? *next : *idle, frame, tick, next == nullptr);
    return true;
}

}  // namespace hypertuna::firmware
