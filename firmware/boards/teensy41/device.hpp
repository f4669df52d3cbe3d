/// A device on a serial port that keeps its settings only while it has power.
#pragma once

#include <Arduino.h>

namespace hypertuna::firmware {

/// The device is set up at its initial rate, 9,600 bit/s, and then at its own: at boot, and whenever it has been
/// silent.
struct Device {
    static constexpr std::uint32_t hand_over = 250'000;  // us: longer than the settings take at 9,600 bit/s

    std::uint32_t baud, patience;          // bit/s; us of silence
    std::uint32_t heard_at, messages = 0;  // us of the last message or change of rate; number of messages
    bool slow = false;

    Device(std::uint32_t rate, std::uint32_t silence) : baud(rate), patience(silence), heard_at(0u - silence) {}

    /// `set_up(slow)` sends the settings for one of the two rates.
    template <class SetUp>
    void look(HardwareSerialIMXRT& port, std::uint32_t so_far, const SetUp& set_up) {
        const std::uint32_t now = std::uint32_t(micros());
        if (so_far != messages && !slow) heard_at = now;
        messages = so_far;
        if (now - heard_at < (slow ? hand_over : patience)) return;
        slow = !slow, heard_at = now;
        port.begin(slow ? 9600 : baud);
        set_up(slow);
    }
};

}  // namespace hypertuna::firmware
