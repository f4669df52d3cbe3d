/// An I2C bus with an MS5837 that sends the example of its data sheet. A transfer on a bus that is held low waits 17
/// ms.
#pragma once

namespace stand_in {

struct Bus {
    bool silent = false;     // the sensor does not answer
    bool held = false;       // the sensor holds the data line low, until it is given nine clock pulses
    bool broken = false;     // a short circuit: nothing helps
    bool clockless = false;  // the sensor stops the clock in the middle of the next transfer
    bool hangs = false;      // the sensor stops the clock in every transfer, and releases the lines afterwards
    bool blind = false;      // the lines cannot be read while the bus drives them
    bool taken = false;      // the lines are general pins, not the bus's
    int pulses = 0, transfers = 0;
    std::uint16_t memory[7] = {0x2000, 34982, 36352, 20328, 22354, 26646, 26146};
    std::uint32_t pressure = 4958179, temperature = 6815414;

    int level(int pin) const { return broken || (pin == 18 && held) || (blind && !taken) ? 0 : 1; }
    void take_over(int pin) { pulses = pin == 19 ? 0 : pulses, taken = pin == 18 || pin == 19 || taken; }
    void drive(int pin, int to) {
        if (pin == 19 && to == 1 && ++pulses == 9) held = false;
    }
    /// Whether a transfer succeeds; it takes its time.
    bool transfer() {
        ++transfers;
        const bool stuck = held || broken || clockless || taken;
        held = held || clockless, clockless = false;
        pass(stuck || hangs ? 17'000 : 100);
        return !stuck && !hangs && !silent;
    }
};
inline Bus bus;

}  // namespace stand_in
