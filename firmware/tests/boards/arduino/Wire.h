#pragma once

#include "Arduino.h"

struct TwoWire {
    std::uint8_t command = 0, asked = 0;
    int left = 0;
    std::uint32_t number = 0;

    void begin() { stand_in::bus.taken = false; }
    void setClock(std::uint32_t) {}
    void beginTransmission(std::uint8_t) {}
    void write(std::uint8_t byte) {
        if (byte != 0) asked = byte;
        command = byte;
    }
    std::uint8_t endTransmission() { return stand_in::bus.transfer() ? 0 : 4; }
    std::uint8_t requestFrom(std::uint8_t, std::uint8_t count) {
        const stand_in::Bus& bus = stand_in::bus;
        number = command >= 0xa0 ? bus.memory[(command - 0xa0) / 2] : asked == 0x44 ? bus.pressure : bus.temperature;
        left = count;
        return stand_in::bus.transfer() ? count : 4;
    }
    int read() { return int(number >> 8 * --left & 0xff); }
};
inline TwoWire Wire;
