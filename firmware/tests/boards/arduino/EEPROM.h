#pragma once

#include <cstdint>

struct Eeprom {
    std::uint8_t byte[4284];

    std::uint8_t read(int at) { return byte[at]; }
    void update(int at, std::uint8_t to) { byte[at] = to; }
};
inline Eeprom EEPROM;
