/// A board on the bench: sound sensors with a little noise, bends that follow the servos, memory, and no twin.
#pragma once

#include <algorithm>
#include <vector>

#include "app/app.hpp"
#include HYPERTUNA_ROBOT

namespace hypertuna::firmware {

struct BenchBoard {
    std::vector<std::uint8_t> memory = std::vector<std::uint8_t>(flash_sectors * flash_sector, 0xff);
    float bend[max_joints] = {}, pulse[max_servos] = {};
    std::uint32_t ticks = 0;
    float acceleration[3] = {0.0f, 0.0f, 9.81f}, rate[3] = {}, field[3] = {-0.6f, 0.0f, -0.8f};
    float voltage = 15.0f, depth = 0.05f;
    bool leak = false, sky = true;              // water in the hull; the receiver has satellites
    std::int32_t place = 500000000;             // latitude of the fixes [1e-7 deg]
    std::vector<std::uint8_t> heard{}, said{};  // bytes that the radio received, and that it sent

    float noise(int channel) const { return normal<float>(random_bits(7, std::uint64_t(channel), ticks)); }

    bool wait() { return true; }
    void read(Raw& raw) {
        const Calibration& c = sound().calibration;
        const auto put = [&](int channel, float reading, float spread) {
            const float counts = (reading + spread * noise(channel)) / c.scale[channel] + c.zero[channel];
            raw.channel[channel].add(std::int32_t(counts + 0.5f));
        };
        const Controller<float>& controller = sound().pilot.controller;
        for (int j = 0; j < robot::description.joints; ++j) {
            const float servo = pulse[2 * j] == 0.0f ? 0.0f : (pulse[2 * j] - 1500e-6f) / 637e-6f;
            bend[j] += 0.3f * (servo / controller.map[2 * j].term[0] - bend[j]);
            put(first_channel("bend") + j, bend[j], 2e-3f);
        }
        for (int k = 0; k < 2 * robot::description.joints; ++k) {
            const float toward = k % 2 == 0 ? bend[k / 2] : -bend[k / 2];
            put(first_channel("pressure") + k, held(controller.circuit[k], toward), 500.0f);
            put(first_channel("current") + k, 0.3f, 0.02f);
        }
        for (int k = 0; k < 3; ++k) {
            put(first_channel("rate") + k, rate[k], 2e-3f), put(first_channel("field") + k, field[k], 5e-3f);
            put(first_channel("acceleration") + k, acceleration[k], 0.02f);
        }
        put(first_channel("voltage"), voltage, 0.02f), put(first_channel("depth"), depth, 5e-3f);
        raw.fixed = sky && ticks % 100 == 50, raw.leak = leak;
        raw.fix[0] = place + int(10 * noise(sensor_channels)), raw.fix[1] = 80000000;
        ++ticks;
    }
    void drive(const float (&to)[max_servos], int count) { std::copy(to, to + count, pulse); }
    void feed() {}
    std::uint32_t clock() { return 0; }
    std::uint32_t per_tick() { return 1; }
    bool watchdog_reset() { return false; }
    void keep(std::uint32_t) {}
    std::uint32_t kept() { return 0; }
    void load(int at, std::uint8_t* to, int count) { std::copy_n(&memory[std::size_t(at)], count, to); }
    void program(int at, const std::uint8_t* from, int count) {
        for (int k = 0; k < count; ++k) memory[std::size_t(at + k)] &= from[k];
    }
    void erase(int sector) { std::fill_n(memory.begin() + sector * flash_sector, flash_sector, std::uint8_t(0xff)); }
    bool recovers() { return false; }
    int log(const std::uint8_t*, int count) { return count; }
    int receive(std::uint8_t* to, int limit) {
        const int count = std::min(limit, int(heard.size()));
        std::copy_n(heard.begin(), count, to);
        heard.erase(heard.begin(), heard.begin() + count);
        return count;
    }
    int send(const std::uint8_t* from, int count) {
        said.insert(said.end(), from, from + count);
        return count;
    }

    /// Parameters of the description: the sensors are always those that it describes; the radio changes none.
    static const Model& sound() {
        static const Model model = [] {
            float value[max_parameters];
            for (int k = 0; k < robot::description.parameters; ++k) value[k] = robot::description.parameter[k].standard;
            Model made;
            configure(made, robot::description, value);
            return made;
        }();
        return model;
    }
};

}  // namespace hypertuna::firmware
