#pragma once

#include <cstdint>

/// An I2C bus with an MS5837 that shows the example of its data sheet.
struct Bus {
    std::uint8_t command = 0, asked = 0;
    int left = 0;
    std::uint32_t number = 0;
    bool silent = false;

    void begin() {}
    void setClock(std::uint32_t) {}
    void beginTransmission(std::uint8_t) {}
    void write(std::uint8_t byte) {
        if (byte != 0) asked = byte;
        command = byte;
    }
    void endTransmission() {}
    std::uint8_t requestFrom(std::uint8_t, std::uint8_t count) {
        static constexpr std::uint32_t memory[7] = {0, 34982, 36352, 20328, 22354, 26646, 26146};
        number = command >= 0xa0 ? memory[(command - 0xa0) / 2] : asked == 0x44 ? 4958179 : 6815414;
        left = count;
        return silent ? 0 : count;
    }
    int read() { return int(number >> 8 * --left & 0xff); }
};
inline Bus Wire;
