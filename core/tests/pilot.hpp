/// A controller like that of a robot with two joints, written down by hand for the tests.
#pragma once

#include "hypertuna/simulation/sensors.hpp"

namespace hypertuna {

template <class T>
Controller<T> test_controller() {
    Controller<T> m{};
    const double tick = 0.01, smooth = 15.8;
    m.joints = 2, m.tick = T(tick);
    m.network = {T(std::exp(-20 * tick)), T(std::exp(-10 * tick))};
    m.smoothing = {T(smooth * tick), T(std::exp(-smooth * tick))};
    m.servo = {T(97.6 * tick), T(std::exp(-97.6 * tick))};
    m.viscosity_min = T(0.005), m.viscosity_own = T(0.1);
    m.posture = {T(0.7), T(0.25), T(0.1), T(0.05), T(0.05)};
    for (int j = 0; j < 2; ++j) m.joint[j] = {0, T(0.5), T(0.4), T(30), T(30), T(1.57), T(0.5), T(2.5), T(1.0), T(1.2)};
    for (int c = 0; c < 4; ++c) {
        m.map[c] = {T(-0.5), T(0.5), {T(1), T(-0.3), T(1), T(0), T(0.7), T(0)}};
        SupervisorModel<T>& s = m.circuit[c];
        s.speed = T(7.5), s.stall = T(1.2e6), s.fill = T(6e4), s.compliance = T(3e-7);
        s.line = T(3e5), s.hammer = T(7e4), s.draw = T(20), s.smooth = T(4), s.hold[0] = T(2e5);
    }
    m.pressure_work = T(2e5), m.pressure_soft = T(2.5e5), m.pressure_hard = T(3e5), m.pressure_low = T(-1e5),
    m.pressure_high = T(5e5);
    m.pressure_step = T(2e5);
    m.current_low = T(-5), m.current_high = T(5), m.rate_high = T(35), m.acceleration_high = T(157);
    m.voltage_rated = T(7.2), m.voltage_low = T(12.8), m.voltage_min = T(0), m.voltage_max = T(20);
    m.frequency_max = T(8), m.fin_max = T(1), m.timeout = 50;
    m.pulse_center = T(1500e-6), m.pulse_per_rad = T(637e-6), m.pulse_min = T(800e-6), m.pulse_max = T(2200e-6);
    m.slew = T(15);
    return m;
}

/// Readings of sound sensors of a robot at rest.
template <class T>
Readings<T> calm_readings() {
    Readings<T> r{};
    for (int c = 0; c < 4; ++c) r.pressure[c] = T(6e4), r.current[c] = T(0.3);
    r.acceleration[2] = T(9.8), r.voltage = T(15);
    return r;
}

template <class T>
Command<T> beat_command(double frequency = 2, double first = 0.2, double second = 0.3, double lag = 0.5) {
    Command<T> c{};
    c.frequency = T(frequency), c.amplitude[0] = T(first), c.amplitude[1] = T(second), c.phase[1] = T(lag);
    c.fresh = c.armed = true;
    return c;
}

/// Readings of a tail that follows its command with a gain, with a little noise so that no sensor looks stuck.
template <class T>
Readings<T> tail_readings(const ControllerOutput<T>& out, double gain, int tick, double noise = 1e-3) {
    Readings<T> r = calm_readings<T>();
    const auto draw = [&](int channel) {
        return normal<T>(random_bits(3, std::uint64_t(channel), std::uint64_t(tick)));
    };
    for (int j = 0; j < 2; ++j) r.bend[j] = T(gain) * out.target[2 * j] + T(noise) * draw(j);
    for (int c = 0; c < 4; ++c) {
        r.pressure[c] += (c % 2 == 0 ? T(2e5) : T(-2e5)) * r.bend[c / 2] + T(300) * draw(4 + c);
        r.current[c] += T(0.02) * draw(8 + c);
    }
    for (int k = 0; k < 3; ++k) r.rate[k] += T(0.01) * draw(12 + k), r.acceleration[k] += T(0.02) * draw(16 + k);
    r.voltage += T(0.02) * draw(20);
    return r;
}

}  // namespace hypertuna
