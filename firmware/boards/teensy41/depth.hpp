/// Depth sensor MS5837-30BA on I2C: two conversions in turn, compensated to second order in integers as in its data
/// sheet.
///
/// No function here waits for the sensor. A stuck line is detected before it is used, and after a failure the sensor is
/// left alone for a second: then the bus is freed and the sensor started anew, a step per millisecond.
#pragma once

#include <Arduino.h>
#include <Wire.h>

#include "app/board.hpp"

namespace hypertuna::firmware {

/// Words of the sensor's memory, checksum and C1 to C6, and the last temperature.
struct DepthSensor {
    std::uint16_t c[7];
    std::int64_t dt, celsius;  // difference from the reference temperature; temperature [0.01 C]

    /// CRC-4 of the memory, bit by bit: polynomial x^4 + x + 1 after two bytes each of eight words.
    static int checksum(const std::uint16_t (&words)[8]) {
        std::uint16_t rest = 0;
        for (int k = 0; k < 16; ++k) {
            rest = std::uint16_t(rest ^ (k % 2 == 0 ? words[k / 2] >> 8 : words[k / 2] & 0xff));
            for (int bit = 0; bit < 8; ++bit) rest = std::uint16_t(rest & 0x8000 ? rest << 1 ^ 0x3000 : rest << 1);
        }
        return rest >> 12;
    }
    /// Whether the memory was read without an error: its first four bits are its checksum.
    bool is_valid() const {
        std::uint16_t words[8] = {std::uint16_t(c[0] & 0x0fff), c[1], c[2], c[3], c[4], c[5], c[6], 0};
        return c[1] != 0 && checksum(words) == c[0] >> 12;
    }

    void temperature(std::uint32_t d2) {
        dt = std::int64_t(d2) - (std::int64_t(c[5]) << 8);
        celsius = 2000 + ((dt * c[6]) >> 23);
    }

    /// Pressure in 0.1 mbar = 10 Pa, the unit of the firmware's counts.
    std::int32_t pressure(std::uint32_t d1) const {
        std::int64_t offset = (std::int64_t(c[2]) << 16) + ((c[4] * dt) >> 7);
        std::int64_t slope = (std::int64_t(c[1]) << 15) + ((c[3] * dt) >> 8);
        const std::int64_t warm = celsius - 2000, frozen = celsius + 1500;
        offset -= warm < 0 ? 3 * warm * warm / 2 : warm * warm / 16;
        slope -= warm < 0 ? 5 * warm * warm / 8 : 0;
        if (frozen < 0) offset -= 7 * frozen * frozen, slope -= 4 * frozen * frozen;
        return std::int32_t((((std::int64_t(d1) * slope) >> 21) - offset) >> 13);
    }
};

struct DepthLine {
    static constexpr std::uint8_t address = 0x76, data_pin = 18, clock_pin = 19;
    static constexpr int reset = 0x1e, ask_pressure = 0x44, ask_temperature = 0x54, memory = 0xa0;
    static constexpr int settled = 10, words = 7,
                         max_counts =
                             310'000;  // ms to wait after a reset; words of the memory; largest pressure [10 Pa]

    DepthSensor sensor{};
    int step = -1;               // ms since the reset; -1 while the sensor is left alone
    bool measured = false;       // a temperature was measured
    bool sees = false;           // the lines can be read while the bus drives them
    std::uint32_t retry_at = 0;  // us

    void begin() {
        Wire.begin(), Wire.setClock(400'000);
        step = -1, measured = false, retry_at = std::uint32_t(micros());
    }

    /// Do the work of a millisecond; `ms` is the time since the tick began.
    void work(int ms, Samples& samples) {
        if (step < 0 && std::int32_t(micros() - retry_at) < 0) return;
        if (!(step < 0 ? restart() : step < settled + words ? read_memory() : convert(ms, samples))) {
            step = -1, measured = false;
            retry_at = std::uint32_t(micros()) + 1'000'000;
        }
    }

  private:
    /// Take the lines from the bus, and free it from a device that was cut off in a byte: nine clock pulses let it
    /// finish. Then reset the sensor.
    bool restart() {
        pinMode(data_pin, INPUT_PULLUP), pinMode(clock_pin, INPUT_PULLUP);
        delayMicroseconds(10);
        if (!are_high()) {
            pinMode(clock_pin, OUTPUT_OPENDRAIN);
            for (int k = 0; k < 9; ++k) {
                digitalWrite(clock_pin, LOW), delayMicroseconds(5);
                digitalWrite(clock_pin, HIGH), delayMicroseconds(5);
            }
        }
        const bool free = are_high();
        Wire.begin(), Wire.setClock(400'000);
        sees = free && are_high();
        return free && ask(reset) && ++step == 0;
    }
    bool read_memory() {
        std::uint32_t word = 0;
        const int k = step++ - settled;
        if (k < 0) return true;
        if (!read(memory + 2 * k, 2, word)) return false;
        sensor.c[k] = std::uint16_t(word);
        return k < words - 1 || sensor.is_valid();
    }
    /// Read pressure, then temperature, each 3 ms after its conversion was started: a reading per tick.
    bool convert(int ms, Samples& samples) {
        std::uint32_t number = 0;
        if (ms == 0) return ask(ask_pressure);
        if (ms == 3) {
            if (!read(0, 3, number) || number == 0) return false;
            const std::int32_t counts = sensor.pressure(number);
            if (measured && 0 < counts && counts < max_counts) samples.add(counts);
            return ask(ask_temperature);
        }
        if (ms == 6) {
            if (!read(0, 3, number) || number == 0) return false;
            sensor.temperature(number), measured = true;
        }
        return true;
    }
    static bool are_high() { return digitalRead(data_pin) == HIGH && digitalRead(clock_pin) == HIGH; }
    /// Send a command, unless a line is held low: such a transfer would wait 17 ms.
    bool ask(int command) const {
        if (sees && !are_high()) return false;
        Wire.beginTransmission(address);
        Wire.write(std::uint8_t(command));
        return Wire.endTransmission() == 0;
    }
    bool read(int command, int bytes, std::uint32_t& number) const {
        if (!ask(command) || Wire.requestFrom(address, std::uint8_t(bytes)) != bytes) return false;
        for (int k = 0; k < bytes; ++k) number = number << 8 | std::uint8_t(Wire.read());
        return true;
    }
};

}  // namespace hypertuna::firmware
