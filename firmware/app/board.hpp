/// Board: the hardware interface of the app, for a microcontroller, an emulated one and a PC.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "hypertuna/simulation/sensors.hpp"

namespace hypertuna::firmware {

/// Flash memory: sectors are erased to ones, pages programmed to zeros. [bytes]
inline constexpr int flash_sector = 4096, flash_page = 256;

/// Number of channels that are read as counts, in the order of the core's readings.hpp.
inline constexpr int channels = sensor_channels;

/// Samples of a channel since the last tick. A sensor without samples does not answer.
struct Samples {
    std::int32_t sum, min, max;
    std::uint16_t count;

    void add(std::int32_t sample) {
        min = count == 0 || sample < min ? sample : min;
        max = count == 0 || max < sample ? sample : max;
        sum += sample;
        ++count;
    }
};

/// Inputs of a board since the last tick.
struct Raw {
    Samples channel[channels];
    std::int32_t fix[2];      // latitude and longitude of the satellite receiver, 1e-7 deg
    std::int32_t accuracy;    // standard deviation of the fix by the receiver [mm]; 0 unknown
    std::uint8_t satellites;  // used for the fix; 0 unknown
    bool fixed;               // there is a new fix
    bool leak;                // water in the hull
};

template <class B>
concept Board = requires(B& board, Raw& raw, const float (&pulse)[max_servos], const std::uint8_t* from,
                         std::uint8_t* to, int count, std::uint32_t word) {
    { board.wait() } -> std::same_as<bool>;  // wait until the next tick is due; false at the end of a simulated run
    { board.read(raw) };                     // adds the samples since the last tick
    { board.drive(pulse, count) };           // servo pulses [s]; 0 for none
    { board.feed() };                        // resets the watchdog
    { board.clock() } -> std::same_as<std::uint32_t>;     // clock that counts up and wraps
    { board.per_tick() } -> std::same_as<std::uint32_t>;  // counts of that clock in a control tick
    { board.watchdog_reset() } -> std::same_as<bool>;     // whether the watchdog caused this boot
    { board.keep(word) };                                 // keeps a word over a reset without loss of power
    { board.kept() } -> std::same_as<std::uint32_t>;      // read that word; arbitrary after a loss of power
    { board.load(count, to, count) };                     // reads bytes of the flash memory from an address on
    { board.program(count, from, count) };  // writes within a page; only clears bits; done when it returns
    { board.erase(count) };                 // sets all bits of a sector; may take 0.4 s
    {
        board.recovers()
    } -> std::same_as<bool>;  // whether the key is to be deleted, since somebody has the board in hand
    { board.log(from, count) } -> std::same_as<int>;    // black box: number of bytes accepted
    { board.receive(to, count) } -> std::same_as<int>;  // radio: number of bytes received, without waiting
    { board.send(from, count) } -> std::same_as<int>;   // radio: number of bytes accepted
};

}  // namespace hypertuna::firmware
