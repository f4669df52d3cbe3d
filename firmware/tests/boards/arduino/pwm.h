/// Pulse-width modulation by timers as the Teensy's core sets them: which pins have it, and which share a timer.
#pragma once

namespace stand_in {

struct Pwm {
    std::uint32_t bits = 8;
    std::map<int, std::pair<std::uint32_t, std::uint32_t>>
        timer;                          // by the timer's number: power of its prescaler, counts of a period
    std::map<int, std::uint32_t> high;  // by pin: counts of a pulse

    /// Number of a pin's timer; -1 for a pin without.
    static int timer_of(int pin) {
        static const std::map<int, int> timers = {{0, 11},  {1, 10},  {2, 42},  {3, 42},  {4, 20},  {5, 21},  {6, 22},
                                                  {7, 13},  {8, 13},  {9, 22},  {10, 50}, {11, 52}, {12, 51}, {13, 60},
                                                  {14, 72}, {15, 73}, {18, 71}, {19, 70}, {22, 40}, {23, 41}, {24, 12},
                                                  {25, 13}, {28, 31}, {29, 31}, {33, 20}, {36, 23}, {37, 23}};
        return timers.count(pin) ? timers.at(pin) : -1;
    }
    /// Length of a pin's pulses [us], and their number per second; 0 for none.
    double pulse(int pin) { return high.count(pin) == 0 ? 0 : high[pin] * count_us(pin); }
    double rate(int pin) { return 1e6 / (timer[timer_of(pin)].second * count_us(pin)); }
    double count_us(int pin) { return double(1 << timer[timer_of(pin)].first) / 150; }
};
inline Pwm pwm;

}  // namespace stand_in

inline void analogWriteResolution(std::uint32_t bits) { stand_in::pwm.bits = bits; }
inline void analogWriteFrequency(std::uint8_t pin, float frequency) {
    std::uint32_t counts = std::uint32_t(float(F_BUS_ACTUAL) / frequency + 0.5f), power = 0;
    for (; counts > 65535 && power < 7; ++power) counts >>= 1;
    stand_in::pwm.timer[stand_in::Pwm::timer_of(pin)] = {power, std::min(counts, 65535u)};
}
inline void analogWrite(std::uint8_t pin, int duty) {
    const int timer = stand_in::Pwm::timer_of(pin);
    if (timer >= 0)
        stand_in::pwm.high[pin] =
            std::uint32_t(std::uint64_t(duty) * stand_in::pwm.timer[timer].second >> stand_in::pwm.bits);
}
