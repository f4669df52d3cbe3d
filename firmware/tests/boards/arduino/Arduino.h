/// A stand-in for the Arduino API: as much of it as board teensy41 calls, made of memory that the test looks into.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>

inline constexpr int INPUT_PULLUP = 2, LOW = 0, HIGH = 1;

namespace stand_in {
inline std::uint32_t now_us = 0;
inline std::map<int, int> analog, digital;  // by pin
inline void (*each_look)() = nullptr;       // is called whenever the clock is looked at
inline std::uint8_t flash[9 * 4096];
}  // namespace stand_in

inline std::uint32_t micros() {
    stand_in::now_us += 20;
    if (stand_in::each_look != nullptr) stand_in::each_look();
    return stand_in::now_us;
}
inline void delay(std::uint32_t ms) { stand_in::now_us += 1000 * ms; }
inline void analogReadResolution(unsigned) {}
inline int analogRead(std::uint8_t pin) { return stand_in::analog[pin]; }
inline void pinMode(std::uint8_t, std::uint8_t) {}
inline int digitalRead(std::uint8_t pin) { return stand_in::digital.count(pin) ? stand_in::digital[pin] : HIGH; }

struct HardwareSerial {
    std::deque<std::uint8_t> in, out;
    int room = 64;
    std::uint32_t rate = 0;

    void begin(std::uint32_t baud) { rate = baud; }
    int available() { return int(in.size()); }
    int read() {
        const int byte = in.front();
        in.pop_front();
        return byte;
    }
    int availableForWrite() { return room; }
    std::size_t write(const std::uint8_t* from, std::size_t count) {
        out.insert(out.end(), from, from + count);
        return count;
    }
};
inline HardwareSerial Serial1, Serial2, Serial3, Serial4, Serial5, Serial6, Serial7, Serial8;

inline void eepromemu_flash_write(void* to, const void* from, std::uint32_t count) {
    auto* at = static_cast<std::uint8_t*>(to);
    for (std::uint32_t k = 0; k < count; ++k) at[k] &= static_cast<const std::uint8_t*>(from)[k];
}
inline void eepromemu_flash_erase_sector(void* sector) { std::memset(sector, 0xff, 4096); }
