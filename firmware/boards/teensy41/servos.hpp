/// Servo pulses by the timers of the microcontroller: no interrupt makes the pulses, so none can stretch them.
#pragma once

#include <Arduino.h>

namespace hypertuna::firmware {

inline constexpr float pulse_rate = 50;  // Hz, rate of all servos, since pins share timers
inline constexpr int pulse_bits = 16;    // bits of the duty cycle; a timer counts 0.43 us

/// Whether a pin has pulse-width modulation by a timer, on a Teensy 4.1 (pwm.c of its core).
constexpr bool has_pulses(int pin) {
    return (0 <= pin && pin <= 15) || pin == 18 || pin == 19 || (22 <= pin && pin <= 25) || pin == 28 || pin == 29 ||
           pin == 33 || pin == 36 || pin == 37;
}

inline void begin_servo(int pin) {
    analogWriteResolution(pulse_bits);
    analogWriteFrequency(std::uint8_t(pin), pulse_rate);
    analogWrite(std::uint8_t(pin), 0);
}

/// Send pulses of a length [s]; 0 for none. The duty cycle is rounded down here, and by the core to counts of the
/// timer: adding 1.2 before makes the error at most 0.4 us either way.
inline void send_pulse(int pin, float pulse) {
    const float duty = pulse * pulse_rate * float(1 << pulse_bits);
    analogWrite(std::uint8_t(pin), 0.0f < pulse ? int(duty + 1.2f) : 0);
}

}  // namespace hypertuna::firmware
