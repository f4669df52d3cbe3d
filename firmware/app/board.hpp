/// Board: what the app needs of a machine. A microcontroller, an emulated one and a PC all look like this.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "hypertuna/simulation/sensors.hpp"

namespace hypertuna::firmware {

/// What is read as counts has its place among all channels of core readings.hpp.
inline constexpr int channels = sensor_channels;

/// Samples of a channel since the last tick. None at all is a sensor that does not answer.
struct Samples {
    std::int32_t sum, least, most;
    std::uint16_t count;

    void add(std::int32_t sample) {
        least = count == 0 || sample < least ? sample : least;
        most = count == 0 || most < sample ? sample : most;
        sum += sample;
        ++count;
    }
};

/// What a board read since the last tick.
struct Raw {
    Samples channel[channels];
    std::int32_t fix[2];  // latitude and longitude of the satellite receiver, 1e-7 deg
    bool fixed;           // one came
    bool leak;            // water in the hull
};

template <class B>
concept Board = requires(B& board, Raw& raw, const float (&pulse)[most_servos], const std::uint8_t* from,
                         std::uint8_t* to, int count) {
    { board.wait() } -> std::same_as<bool>;  // until the next tick is due; false at the end of a simulated run
    { board.read(raw) };                     // adds what was sampled since the last tick
    { board.drive(pulse, count) };           // servo pulses in s; 0 for none
    { board.feed() };                        // the watchdog
    { board.clock() } -> std::same_as<std::uint32_t>;     // counts up, wraps
    { board.per_tick() } -> std::same_as<std::uint32_t>;  // counts of that clock in a control tick
    { board.woken() } -> std::same_as<bool>;              // the watchdog caused this boot
    { board.load(count) } -> std::same_as<std::uint8_t>;  // a byte of non-volatile memory
    { board.save(count, *from) };                         // lasts when it returns
    { board.log(from, count) } -> std::same_as<int>;      // black box: how many of the bytes it took
    { board.receive(to, count) } -> std::same_as<int>;    // radio: how many bytes came, without waiting
    { board.send(from, count) } -> std::same_as<int>;     // radio: how many of them there was room for
};

}  // namespace hypertuna::firmware
