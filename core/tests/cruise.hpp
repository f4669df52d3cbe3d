/// A purely kinematic fish and a handwritten pilot for it: it swims as fast as its beat says, turns by its bias,
/// pitches and rolls by its fins, and its head swings with the beat.
#pragma once

#include "check.hpp"
#include "hypertuna/pilot/pilot.hpp"
#include "pilot.hpp"

namespace hypertuna {

template <class T>
Steering<T> test_steering() {
    Steering<T> m{};
    m.joints = 2, m.period = T(0.1);
    GaitTable<T>& table = m.table;
    table.gaits = 3;
    const double speed[] = {0.15, 0.3, 0.45}, frequency[] = {1, 2, 3};
    for (int k = 0; k < 3; ++k) {
        table.speed[k] = T(speed[k]), table.frequency[k] = T(frequency[k]);
        table.amplitude[k][0] = T(0.27), table.amplitude[k][1] = T(0.4);
    }
    m.bias_max[0] = T(0.14), m.bias_max[1] = T(0.21), m.reach[0] = T(0.38), m.reach[1] = T(0.6);
    m.curvature = T(1.2), m.heading_rate = T(0.4), m.turn_max = T(0.3), m.rate_gain = T(0.5);
    m.heading_integral = T(0.1), m.speed_min = T(0.1), m.lookahead = T(4), m.depth_lookahead = T(1.5);
    m.climb_max = T(0.2), m.pitch_max = T(0.5), m.depth_integral = T(0.05);
    m.climb_lead = T(3), m.climb_gain = T(1), m.pitch_gain = T(0), m.pitch_damping = T(0.7);
    m.fin_max = T(0.7);
    return m;
}

template <class T>
Pilot<T> test_pilot() {
    Pilot<T> m{};
    m.controller = test_controller<T>();
    m.every = 10;
    m.estimator.attitude = {T(0.01), T(0.2), T(0.2), T(0.02), T(35), T(157), T(0.5), T(1.5)};
    Estimator<T>& e = m.estimator;
    e.depth_rate = T(1.5), e.depth_low = T(-10.3), e.depth_high = T(30), e.depth_step = T(0.5), e.glide = T(0.8);
    e.way = {T(0.05), T(0.002), T(0.002), T(1), T(0.1), T(0.1), T(1.5), T(1.5), T(12)};
    e.fix_depth = T(0.24);
    e.air_low = T(-5.2), e.air_high = T(0.74), e.antenna_x = T(0.17), e.antenna_z = T(0.086);
    Guidance<T>& g = m.guidance;
    g.steering = test_steering<T>();
    g.surface_depth = T(0.12), g.fence_margin = T(3), g.error_max = T(12), g.error_near = T(4);
    g.error_lost = T(40), g.drift_error_max = T(0.02), g.fix_timeout = T(60), g.retry = T(180), g.sensor_timeout = T(2);
    g.compass_timeout = T(120), g.fin_tilt = T(0.02), g.fin_min = T(0.2), g.fin_after = T(8), g.single_fin_max = T(0.7);
    g.response_time = T(25), g.response_depth = T(0.3), g.blind_fin = T(0.35), g.blind_speed = T(0.25);
    g.battery_empty = T(12), g.battery_span = T(4.8), g.battery_drop = T(0.2), g.endurance = T(8000);
    g.overhead = T(30), g.error_fix = T(1.9), g.depth_tolerance = T(0.2), g.arrival_timeout = T(180);
    return m;
}

/// Errors of the pilot's sensors; those of the robot are tested in test_sensors.cpp.
inline Sensors<double> test_senses(std::uint64_t seed) {
    Sensors<double> s{};
    s.joints = 2, s.root_tick = 0.1, s.seed = seed;
    s.of("bend") = {-1.5, 1.5, 0.0035, 0, 0, 0, 0}, s.of("pressure") = {-1e5, 5e5, 500, 183, 0, 0, 0};
    s.of("current") = {-5, 5, 0.02, 0, 0, 0, 0}, s.of("voltage") = {0, 20, 0.02, 0.005, 0, 0.04, 0};
    s.of("rate") = {-35, 35, 0.0012, 0.00107, 0, 0.0017, 0},
    s.of("acceleration") = {-157, 157, 0.02, 0.0048, 0, 0.05, 0};
    s.of("depth") = {-10.3, 30, 0.01, 0.002, 0, 0.02, 0}, s.of("field") = {-2, 2, 0.01, 0.001, 0, 0.01, 0};
    s.of("position") = {-1e5, 1e5, 1.5, 0, 0, 1.5, 0}, s.fix_every = 100;
    return s;
}

/// State of the water and of the fish, with the fish's flaws.
struct Water {
    double current[2] = {0, 0};
    double eases = 1e9;              // s, time after which the current is zero
    double factor = 1;               // true speed over the speed in the gait table
    double lean = 0;                 // bias that the tail has by itself, fraction of the largest bias
    double sinking = 0;              // m/s, from a trim that is off
    double dip = 1.1;                // rad, inclination of the magnetic field
    double stuck[2] = {9, 9};        // rad at which a fin's servo stands; more than 3 for none
    double gap[2] = {0, 0};          // s, begin and end of the time without satellites
    double volts = 15.5, drain = 0;  // V, V/s
    double held = 1e9,
           swell = 0;  // s, time from which a line holds the fish; m, amplitude of the swell of 7 s that moves the line
};

struct Cruiser {
    double time = 0, x = 0, y = 0, z = 0, yaw = 0;  // yaw of the facing direction, counter-clockwise from east
    double pitch = 0, roll = 0, speed = 0, turn = 0, pitch_rate = 0, roll_rate = 0, phase = 0, bias = 0, swing = 0;
    double fin[2] = {0, 0}, surge = 0, heave = 0;
    double voltage = 15.5;

    double swung() const { return yaw + 0.12 * swing * std::sin(phase); }
};

/// The true motion that the sensors measure, in body axes: from nose to tail, to starboard, up.
template <class T>
PilotReadings<double> truth_of(const Cruiser& at, const Water& water, const ControllerOutput<T>& out,
                               double frequency) {
    PilotReadings<double> r{};
    r.robot = calm_readings<double>();
    for (int j = 0; j < 2; ++j) r.robot.bend[j] = double(out.target[2 * j]);
    const double beat = 2 * pi * frequency, psi = at.swung() + pi, th = at.pitch, ph = -at.roll;
    const double psi_rate = at.turn + 0.12 * at.swing * beat * std::cos(at.phase), roll_rate = -at.roll_rate;
    double* w = r.robot.rate;
    w[0] = roll_rate - psi_rate * std::sin(th);
    w[1] = at.pitch_rate * std::cos(ph) + psi_rate * std::cos(th) * std::sin(ph);
    w[2] = -at.pitch_rate * std::sin(ph) + psi_rate * std::cos(th) * std::cos(ph);
    const double cy = std::cos(psi), sy = std::sin(psi), cp = std::cos(th), sp = std::sin(th), cr = std::cos(ph),
                 sr = std::sin(ph);
    // Rows of the rotation from body to world, yaw pitch roll.
    const double R[3][3] = {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                            {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                            {-sp, cp * sr, cp * cr}};
    const double north[3] = {0, std::cos(water.dip), -std::sin(water.dip)};
    for (int k = 0; k < 3; ++k) {
        r.robot.acceleration[k] = 9.81 * R[2][k];
        r.field[k] = R[1][k] * north[1] + R[2][k] * north[2];
    }
    // The beat shakes sideways once and along twice a beat, 3 m/s^2 and 1 m/s^2 at 2 Hz.
    const double shake = at.swing * frequency * frequency / 4;
    r.robot.acceleration[0] += -at.surge + shake * std::sin(2 * at.phase);
    r.robot.acceleration[1] += -w[2] * at.speed + 3 * shake * std::sin(at.phase + 0.5);
    r.robot.acceleration[2] += w[1] * at.speed;
    r.robot.voltage = at.voltage;
    r.depth = -at.z, r.fix[0] = at.x, r.fix[1] = at.y;
    r.fixed = at.z > -0.1 && (at.time < water.gap[0] || water.gap[1] <= at.time);
    return r;
}

/// Advance the fish by 10 ms.
template <class T>
void swim_on(Cruiser& at, const Water& water, const Steering<T>& steering, const ControllerState<T>& state,
             const ControllerOutput<T>& out) {
    const double dt = 0.01, f = double(state.frequency.value);
    at.swing = double(state.amplitude[0].value) / 0.27;
    at.bias = double(state.bias[0].value / steering.bias_max[0]) + water.lean * at.swing;
    at.phase += 2 * pi * f * dt;
    const double beat_speed = water.factor * 0.15 * f * (at.swing < 1 ? at.swing : 1);
    at.surge = (beat_speed * beat_speed - at.speed * std::fabs(at.speed)) / 0.8;
    at.speed += dt * at.surge;
    at.turn += dt / 0.5 * (-1.2 * at.speed * at.bias - at.turn);
    at.yaw += dt * at.turn;
    const double air = at.z > -0.03 ? 0.3 : 1;
    for (int k = 0; k < 2; ++k) {
        const double asked = water.stuck[k] < 3 ? water.stuck[k] : double(out.target[4 + k]);
        at.fin[k] += dt * 15 * (asked - at.fin[k]);
    }
    // Fins lift the body; the flow that then meets it from above turns its nose down again.
    const double q = air * at.speed * at.speed, w0 = 1.1, damp = 2 * 0.4 * w0 + 3 * at.speed;
    const double both = 0.5 * (at.fin[0] + at.fin[1]);
    at.heave += dt / 2.0 * (0.8 * air * at.speed * both - at.heave);
    const double met = at.speed > 0.05 ? at.heave / at.speed : 0;
    at.pitch_rate += dt * (-w0 * w0 * (at.pitch + 0.5 * met) - damp * at.pitch_rate + 1.5 * q * both);
    at.roll_rate += dt * (-w0 * w0 * at.roll - damp * at.roll_rate + 0.8 * q * (at.fin[0] - at.fin[1]));
    at.pitch += dt * at.pitch_rate, at.roll += dt * at.roll_rate;
    const Cruiser before = at;
    at.z = std::fmin(0.0, at.z + dt * (at.speed * std::sin(at.pitch) + at.heave - water.sinking));
    const double flows = at.time < water.eases ? 1 : 0;
    at.x += dt * (at.speed * std::cos(at.pitch) * std::cos(at.swung()) + flows * water.current[0]);
    at.y += dt * (at.speed * std::cos(at.pitch) * std::sin(at.swung()) + flows * water.current[1]);
    if (water.held < at.time) {
        const double beat = 2 * pi / 7;
        at.x = before.x, at.y = before.y;
        at.z = std::fmin(0.0, before.z + dt * water.swell * beat * std::cos(beat * at.time));
    }
    at.time += dt;
    at.voltage = water.volts - water.drain * at.time;
}

template <class T>
Mission<T> mission_of(const Waypoint<T>* waypoint, int count) {
    Mission<T> m{};
    m.waypoint = waypoint, m.waypoints = count;
    m.home_radius = T(3), m.home_speed = T(0.3), m.depth_max = T(6), m.reserve = T(0.1);
    return m;
}

/// A run: look(fish, step, tick) sees every tick; spoil(readings, tick) breaks what the sensors said.
template <class T>
struct Voyage {
    Cruiser fish;
    PilotStep<T> last;
    int ticks;
};

struct Sound {
    template <class R>
    void operator()(R&, int) const {}
};

template <class T, class Look, class Spoil = Sound>
Voyage<T> voyage(const Mission<T>& mission, const Water& water, double most, std::uint64_t seed, const Look& look,
                 const Spoil& spoil = {}, Cruiser fish = {}) {
    const Pilot<T> pilot = test_pilot<T>();
    const Sensors<double> senses = test_senses(seed);
    SensorsState<double> sensing{};
    Voyage<T> out{fish, {}, 0};
    out.last.state = init(pilot, mission);
    fish.voltage = water.volts;
    for (; out.ticks < int(most * 100) && !has_ended(out.last.mode); ++out.ticks) {
        const auto truth =
            truth_of(out.fish, water, out.last.output, double(out.last.state.controller.frequency.value));
        const auto sensed = sense(senses, sensing, truth, static_cast<const Fault<double>*>(nullptr), 0, out.fish.time);
        sensing = sensed.state;
        PilotReadings<double> readings = sensed.readings;
        spoil(readings, out.ticks);
        PilotReadings<T> seen{};
        visit_channels([&](const auto& channel, int) {
            for (int k = 0; k < channel.size; ++k) channel.of(seen)[k] = T(channel.of(readings)[k]);
        });
        seen.fixed = readings.fixed;
        out.last = fly(pilot, out.last.state, seen, mission);
        swim_on(out.fish, water, pilot.guidance.steering, out.last.state.controller, out.last.output);
        look(out.fish, out.last, out.ticks);
    }
    return out;
}

}  // namespace hypertuna
