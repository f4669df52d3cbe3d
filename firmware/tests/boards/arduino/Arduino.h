/// A stand-in for the Arduino API of a Teensy 4.1, as far as board teensy41 calls it, with the effects of its core and
/// chips: rings that overflow, waits that take time, timers that count, a watchdog that resets.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <utility>
#include <vector>

inline constexpr int INPUT_PULLUP = 2, OUTPUT_OPENDRAIN = 4, LOW = 0, HIGH = 1;

namespace stand_in {

inline std::uint64_t now_us = 0;            // time, which advances whenever it is read
inline std::uint32_t lost_us = 0;           // time that micros() missed while interrupts were off
inline std::map<int, int> analog, digital;  // by pin
inline std::uint8_t flash[11 * 4096];
inline std::uint32_t erase_us = 45'000;

/// The watchdog is fed by two words in turn. It resets if it was not fed for too long; the test counts these resets.
struct Watchdog {
    bool on = false, half = false;
    std::uint32_t timeout_us = 0, bites = 0;
    std::uint64_t fed_us = 0;

    void look() {
        if (on && timeout_us < now_us - fed_us) ++bites, fed_us = now_us;
    }
};
inline Watchdog watchdog;

inline void pass(std::uint64_t us) {
    now_us += us;
    watchdog.look();
}

struct WatchdogControl {
    void operator=(std::uint16_t word) const {
        watchdog = {(word & 4) != 0, false, ((word >> 8) + 1u) * 500'000u, watchdog.bites, now_us};
    }
};
struct WatchdogService {
    void operator=(std::uint16_t word) const {
        if (watchdog.half && word == 0xaaaa) watchdog.fed_us = now_us;
        watchdog.half = word == 0x5555;
    }
};

}  // namespace stand_in

// Registers of the processor.
inline constexpr stand_in::WatchdogControl WDOG1_WCR;
inline constexpr stand_in::WatchdogService WDOG1_WSR;
inline std::uint16_t WDOG1_WMCR, WDOG1_WRSR;
inline std::uint32_t CCM_CCGR3, SNVS_LPCR, SNVS_LPGPR0, SNVS_LPGPR1;
inline constexpr std::uint32_t F_CPU_ACTUAL = 600'000'000, F_BUS_ACTUAL = 150'000'000;
inline std::uint32_t cycle_count() { return std::uint32_t(stand_in::now_us * 600); }
#define ARM_DWT_CYCCNT cycle_count()

inline std::uint32_t micros() {
    stand_in::pass(20);
    return std::uint32_t(stand_in::now_us - stand_in::lost_us);
}
inline void delay(std::uint32_t ms) { stand_in::pass(1000 * ms); }
inline void delayMicroseconds(std::uint32_t us) { stand_in::pass(us); }
inline void analogReadResolution(unsigned) {}
inline int analogRead(std::uint8_t pin) { return stand_in::analog[pin]; }

#include "i2c.h"
#include "pwm.h"
#include "serial.h"

inline void pinMode(std::uint8_t pin, std::uint8_t) { stand_in::bus.take_over(pin); }
inline void digitalWrite(std::uint8_t pin, std::uint8_t level) { stand_in::bus.drive(pin, level); }
inline int digitalRead(std::uint8_t pin) {
    if (pin == 18 || pin == 19) return stand_in::bus.level(pin);
    return stand_in::digital.count(pin) ? stand_in::digital[pin] : HIGH;
}

extern "C" {
inline void eepromemu_flash_write(void* to, const void* from, std::uint32_t count) {
    auto* at = static_cast<std::uint8_t*>(to);
    for (std::uint32_t k = 0; k < count; ++k) at[k] &= static_cast<const std::uint8_t*>(from)[k];
    stand_in::without_interrupts(700);
}
inline void eepromemu_flash_erase_sector(void* sector) {
    std::memset(sector, 0xff, 4096);
    stand_in::without_interrupts(stand_in::erase_us);
}
}
