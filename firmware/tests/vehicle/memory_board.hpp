/// A board made of memory, for the tests: its sensors show what a test sets, and its power can go at any byte.
#pragma once

#include "../../boards/lockstep.hpp"
#include "app/vehicle/tick.hpp"
#include "flash/flash.hpp"
#include HYPERTUNA_ROBOT

namespace hypertuna::firmware {

struct MemoryBoard {
    Raw raw;
    float pulse[max_servos];
    Flash<flash_sectors> flash;
    int card;  // bytes that the black box takes per tick
    std::uint8_t box[1 << 16];
    int logged, fed;
    bool reset, jumper;
    std::uint32_t took;  // counts of the tick that were used, of 1000

    bool wait() { return true; }
    void read(Raw& to) { to = raw; }
    void drive(const float (&to)[max_servos], int count) {
        for (int k = 0; k < count; ++k) pulse[k] = to[k];
    }
    void feed() { ++fed; }
    std::uint32_t clock() { return took += ticking; }
    std::uint32_t per_tick() { return 1000; }
    bool watchdog_reset() { return reset; }
    void keep(std::uint32_t to) { word = to; }
    std::uint32_t kept() { return word; }
    void load(int at, std::uint8_t* to, int count) { flash.load(at, to, count); }
    void program(int at, const std::uint8_t* from, int count) { flash.program(at, from, count); }
    void erase(int sector) { took += erasing, flash.erase(sector); }
    bool recovers() { return jumper; }
    int log(const std::uint8_t* from, int count) {
        const int take = count < card ? count : card;
        for (int k = 0; k < take; ++k) box[logged++ & 0xffff] = from[k];
        return take;
    }
    int receive(std::uint8_t*, int) { return 0; }
    int send(const std::uint8_t*, int count) { return count; }

    float depth = 0.05f;        // m
    bool limp[2] = {};          // joints that do not bend
    int stands = -1;            // circuit whose servo does not turn as it is sent; none
    float turns = 0;            // part of the angle sent that this servo turns
    std::uint32_t word = 0;     // kept over a reset without loss of power
    std::uint32_t ticking = 0;  // counts by which the clock advances at every reading
    std::uint32_t erasing = 0;  // counts that an erasure takes
};
static_assert(Board<MemoryBoard>);

inline std::uint32_t word_at(const std::uint8_t* from) {
    std::uint32_t word;
    std::memcpy(&word, from, 4);
    return word;
}

/// Pressure in a joint's circuit above the one that holds a bend, where a servo turns by a part of the angle sent:
/// by the oil that its servo displaces beyond that of the bend. The other side is at the pressure that holds the bend.
inline float displaced(const MemoryBoard& board, const Vehicle& vehicle, int circuit, float bend) {
    if (circuit != board.stands) return 0;
    const Controller<float>& model = vehicle.model.pilot.controller;
    const float beyond = board.turns * vehicle.state.controller.sent[circuit] - servo_angle(model.map[circuit], bend);
    return beyond / (turn_own * model.circuit[circuit].compliance);
}

/// Sensor counts of a robot that floats upright at the surface and bends as commanded, under the pressures that hold
/// its bends, with a little noise so that no sensor looks stuck. Of a joint with a servo that stands, half the bend is
/// left.
inline void float_upright(MemoryBoard& board, const Vehicle& vehicle, int tick) {
    const Calibration& c = vehicle.model.calibration;
    board.raw = {};
    const auto show = [&](int channel, float value) {
        const float noise = 3.0f * normal<float>(random_bits(5, std::uint64_t(channel), std::uint64_t(tick)));
        board.raw.channel[channel].add(std::int32_t(value / c.scale[channel] + c.zero[channel] + noise));
    };
    for (int k = 0; k < 4; ++k) {
        const bool stands = 0 <= board.stands && board.stands / 2 == k / 2;
        const float part = board.limp[k / 2] ? 0 : stands ? 0.5f + 0.5f * board.turns : 1;
        const float bend = part * vehicle.now.output.set[k / 2], side = k % 2 == 0 ? bend : -bend;
        if (k % 2 == 0) show(first_channel("bend") + k / 2, bend);
        const float pressure = held(vehicle.model.pilot.controller.circuit[k], side);
        show(first_channel("pressure") + k, pressure + displaced(board, vehicle, k, side));
        show(first_channel("current") + k, 0.3f);
    }
    for (int k = 0; k < 3; ++k)
        show(first_channel("rate") + k, 0), show(first_channel("acceleration") + k, k == 2 ? 9.81f : 0.0f);
    show(first_channel("voltage"), 15.0f), show(first_channel("depth"), board.depth);
    for (int k = 0; k < 3; ++k) show(first_channel("field") + k, k == 1 ? 0.7f : k == 2 ? -0.7f : 0.0f);
}

/// Run some ticks.
inline void float_on(Vehicle& vehicle, MemoryBoard& board, int ticks) {
    for (int k = 0; k < ticks; ++k) {
        const bool leak = board.raw.leak;
        float_upright(board, vehicle, int(vehicle.now.tick));
        board.raw.leak = leak;
        tick(vehicle, board);
    }
}

}  // namespace hypertuna::firmware
