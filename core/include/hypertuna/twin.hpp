/// Twin: plant, battery, sensors and the controller that closes the loop, one control tick at a time.
///
/// A tick reads the sensors at its start, asks the controller, and lets the plant follow the servo targets by steps of
/// Runge-Kutta while they hold. Nothing here knows of time beyond the tick: the same state gives the same tick.
#pragma once

#include "battery.hpp"
#include "controller.hpp"
#include "plant.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S, class Law, int D>
struct Twin {
    Plant<S, Law, D> plant;
    Controller<S> controller;
    Battery<S> battery;
    S idle;     // W of what draws power beside the pumps' servos
    S step;     // s, Runge-Kutta's
    int steps;  // in a tick
};

template <class S, int D>
struct TwinState {
    PlantState<S, D> plant;
    ControllerState<S> controller;
    ServoTargets<S, D> targets;
    S taken;                   // C from the battery
    BatteryOutput<S> battery;  // over the last tick
};

/// Smallest and largest value of a quantity within a tick.
template <class S>
struct Range {
    S low, high;
};

/// A tick as it went: what held at its start, and what passed until its end.
template <class S, int D>
struct Tick {
    PlantOutput<S, D> seen;
    Readings<S> readings;
    ControllerOutput<S> output;
    Range<S> pump[2 * D], unit[2 * D];  // Pa
    S power[2 * D];                     // W, mean electrical power of each servo
    S servo_power;                      // W, mean of all servos
};

/// What sensors would read if they read the truth: the IMU sits at the head's center of mass and stands upright.
template <class S, class Law, int D>
Readings<S> true_readings(const Twin<S, Law, D>& twin, const TwinState<S, D>& at, const PlantOutput<S, D>& seen) {
    Readings<S> out{};
    const PlantState<S, D>& plant = at.plant;
    for (int j = 0; j < twin.plant.joints; ++j) out.bend[j] = plant.bend.angle[j];
    for (int c = 0; c < 2 * twin.plant.joints; ++c) {
        out.pressure[c] = seen.circuit[c].pump.pressure;
        out.current[c] = seen.circuit[c].power.total / at.targets.supply;
    }
    const Twist<S>&xi = plant.xi, &rate = seen.twist_rate;
    const S com = twin.plant.tail.fish.link[0].com;
    out.rate[2] = xi.z;
    out.acceleration[0] = rate.x - xi.z * xi.y - com * xi.z * xi.z;
    out.acceleration[1] = rate.y + xi.z * xi.x + com * rate.z;
    out.acceleration[2] = S(base_t<S>(9.81));
    out.voltage = at.battery.voltage;
    return out;
}

/// One tick of the plant alone: the targets hold. `tick` has what its start shows.
template <class S, class Law, int D>
void follow_targets(const Twin<S, Law, D>& twin, TwinState<S, D>& state, Tick<S, D>& tick) {
    const int circuits = 2 * twin.plant.joints;
    for (int c = 0; c < circuits; ++c) {
        const S pump = tick.seen.circuit[c].pump.pressure, unit = tick.seen.circuit[c].unit.pressure;
        tick.pump[c] = {pump, pump};
        tick.unit[c] = {unit, unit};
        tick.power[c] = state.plant.energy[c];
    }
    const auto widen = [](Range<S>& range, const S& x) { range = {min(range.low, x), max(range.high, x)}; };
    PlantOutput<S, D> seen[2];
    for (int k = 0; k < twin.steps; ++k) {
        state.plant = plant_step(twin.plant, state.plant, state.targets, twin.step, seen);
        for (const PlantOutput<S, D>& now : seen)
            for (int c = 0; c < circuits; ++c) {
                widen(tick.pump[c], now.circuit[c].pump.pressure);
                widen(tick.unit[c], now.circuit[c].unit.pressure);
            }
    }
    const S period = twin.step * S(static_cast<base_t<S>>(twin.steps));
    tick.servo_power = twin.idle;
    for (int c = 0; c < circuits; ++c) {
        tick.power[c] = (state.plant.energy[c] - tick.power[c]) / period;
        tick.servo_power += tick.power[c];
    }
    state.battery = battery_output(twin.battery, state.taken, tick.servo_power);
    state.taken += state.battery.current * period;
    state.targets.supply = state.battery.supply;
}

/// At rest: the circuits filled, the battery full.
template <class S, class Law, int D>
TwinState<S, D> at_rest(const Twin<S, Law, D>& twin) {
    TwinState<S, D> state{};
    state.controller = init(twin.controller);
    state.battery = battery_output(twin.battery, S(0), twin.idle);
    state.targets.supply = state.battery.supply;
    return state;
}

/// One tick of the twin. `sense` turns true readings into what the sensors say.
template <class S, class Law, int D, class Sense>
Tick<S, D> twin_tick(const Twin<S, Law, D>& twin, TwinState<S, D>& state, const Command<S>& command,
                     const Sense& sense) {
    Tick<S, D> tick{};
    plant_rate(twin.plant, state.plant, state.targets, &tick.seen);
    tick.readings = sense(true_readings(twin, state, tick.seen));
    const ControllerStep<S> next = step(twin.controller, state.controller, tick.readings, command);
    state.controller = next.state;
    tick.output = next.output;
    // A servo hears its pulse, whatever the controller meant by it.
    for (int c = 0; c < 2 * twin.plant.joints; ++c)
        state.targets.angle[c] = (next.output.pulse[c] - twin.controller.pulse_center) / twin.controller.pulse_per_rad;
    follow_targets(twin, state, tick);
    return tick;
}

/// One tick without sensors and controller: the servos are told where to go.
template <class S, class Law, int D>
Tick<S, D> driven_tick(const Twin<S, Law, D>& twin, TwinState<S, D>& state, const S* target) {
    Tick<S, D> tick{};
    for (int c = 0; c < 2 * twin.plant.joints; ++c) state.targets.angle[c] = target[c];
    plant_rate(twin.plant, state.plant, state.targets, &tick.seen);
    follow_targets(twin, state, tick);
    return tick;
}

/// Whether the plant's state is made of numbers that a robot can have: less than a turn, 100 m/s, and finite.
template <class S, int D>
bool plausible(const PlantState<S, D>& at) {
    const S far = S(base_t<S>(100)), turn = S(base_t<S>(pi));
    bool good = abs(at.xi.x) < far && abs(at.xi.y) < far && abs(at.xi.z) < far && is_finite(at.pose.x + at.pose.y);
    for (int d = 0; d < D; ++d) good = good && abs(at.bend.angle[d]) < turn && is_finite(at.bend.rate[d]);
    for (int c = 0; c < 2 * D; ++c) good = good && is_finite(at.circuit[c].flow + at.circuit[c].rate);
    return good;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
