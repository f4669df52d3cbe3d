/// Twin: plant, battery, sensors and the controller that closes the loop, one control tick at a time.
///
/// A tick reads the sensors at its start, asks the controller, and lets the plant follow the servo targets by steps of
/// Runge-Kutta while they hold. A tick depends on its state alone, not on the time.
#pragma once

#include "hypertuna/actuation/battery.hpp"
#include "hypertuna/pilot/readings.hpp"
#include "hypertuna/simulation/plant.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A plant with its battery: the twin without its controller.
template <class Body>
struct Machine {
    using S = typename Body::Scalar;

    Plant<Body> plant;
    Battery<S> battery;
    S idle;     // W drawn in addition to the pumps' servos, by the fins for example
    S step;     // s, step of Runge-Kutta
    int steps;  // Runge-Kutta steps in a tick
};
template <class Body>
struct Twin : Machine<Body> {
    Controller<typename Body::Scalar> controller;
};

/// State of a machine. All members are of type S, so that vector lanes can be loaded from it.
template <class S, int D, class Space = InPlane>
struct MachineState {
    PlantState<S, D, Space> plant;
    ServoTargets<S, D> targets;
    S taken;                   // C taken from the battery
    BatteryOutput<S> battery;  // over the last tick
};
template <class S, int D, class Space = InPlane>
struct TwinState : MachineState<S, D, Space> {
    ControllerState<S> controller;
};
template <class Body>
using MachineStateOf = MachineState<typename Body::Scalar, Body::coordinates, typename Body::Space>;
template <class Body>
using TwinStateOf = TwinState<typename Body::Scalar, Body::coordinates, typename Body::Space>;

/// Type of the readings: in space they include the pilot's.
template <class S, class Space>
struct ReadingsOf {
    using Type = Readings<S>;
};
template <class S>
struct ReadingsOf<S, InSpace> {
    using Type = PilotReadings<S>;
};
template <class S>
HYPERTUNA_INLINE const Readings<S>& of_robot(const Readings<S>& readings) {
    return readings;
}
template <class S>
HYPERTUNA_INLINE const Readings<S>& of_robot(const PilotReadings<S>& readings) {
    return readings.robot;
}

/// Smallest and largest value of a quantity within a tick.
template <class S>
struct Extremes {
    S low, high;
};

/// One simulated tick of the machine: the output at its start, and extremes and means until its end. All members are of
/// type S.
template <class S, int D, class Space = InPlane>
struct MachineTick {
    PlantOutput<S, D, Space> seen;
    Extremes<S> pump[2 * D], unit[2 * D];  // Pa
    S power[2 * D];                        // W, mean electrical power of each servo
    S servo_power;                         // W, mean of all servos
    Losses<S> losses;                      // means, which add up to `servo_power`
};
template <class Body>
using MachineTickOf = MachineTick<typename Body::Scalar, Body::coordinates, typename Body::Space>;
/// One simulated tick of the twin: in addition the sensors' readings and the controller's output.
template <class S, int D, class Space = InPlane>
struct Tick : MachineTick<S, D, Space> {
    typename ReadingsOf<S, Space>::Type readings;
    ControllerOutput<S> output;
};
template <class Body>
using TickOf = Tick<typename Body::Scalar, Body::coordinates, typename Body::Space>;

/// True values of the robot's sensors, except those of the IMU.
template <class S, int D, class Space>
Readings<S> inner_readings(int joints, const MachineState<S, D, Space>& at, const PlantOutput<S, D, Space>& seen) {
    Readings<S> out{};
    for (int j = 0; j < joints; ++j) out.bend[j] = at.plant.bend.angle[j];
    for (int c = 0; c < 2 * joints; ++c) {
        out.pressure[c] = seen.circuit[c].pump.pressure;
        out.current[c] = seen.circuit[c].power.total / at.targets.supply;
    }
    out.voltage = at.battery.voltage;
    return out;
}

/// True values of all sensors in the plane: the IMU sits at the head's center of mass, `com` behind the nose, and
/// stands upright.
template <class S, int D>
Readings<S> true_readings(int joints, const S& com, const MachineState<S, D>& at, const PlantOutput<S, D>& seen) {
    Readings<S> out = inner_readings(joints, at, seen);
    const Twist<S>&xi = at.plant.xi, &rate = seen.twist_rate;
    out.rate[2] = xi.z;
    out.acceleration[0] = rate.x - xi.z * xi.y - com * xi.z * xi.z;
    out.acceleration[1] = rate.y + xi.z * xi.x + com * rate.z;
    out.acceleration[2] = S(base_t<S>(gravity));
    return out;
}
template <class S, class Law, int D>
Readings<S> true_readings(const Twin<Tail<S, Law, D>>& twin, const TwinState<S, D>& at, const PlantOutput<S, D>& seen) {
    return true_readings<S, D>(twin.plant.joints, twin.plant.body.fish.link[0].com, at, seen);
}

/// One tick of the machine under the servo targets of its state. `tick` already has the output at the start.
template <class Body>
void follow_targets(const Machine<Body>& machine, MachineStateOf<Body>& state, MachineTickOf<Body>& tick) {
    using S = typename Body::Scalar;
    const int circuits = 2 * machine.plant.joints;
    for (int c = 0; c < circuits; ++c) {
        const S pump = tick.seen.circuit[c].pump.pressure, unit = tick.seen.circuit[c].unit.pressure;
        tick.pump[c] = {pump, pump};
        tick.unit[c] = {unit, unit};
        tick.power[c] = state.plant.energy[c];
    }
    tick.losses = {};
    const auto widen = [](Extremes<S>& range, const S& x) { range = {min(range.low, x), max(range.high, x)}; };
    PlantOutputOf<Body> seen[2];
    Losses<S> losses{};
    for (int k = 0; k < machine.steps; ++k) {
        state.plant = plant_step(machine.plant, state.plant, state.targets, machine.step, seen, losses);
        for (const PlantOutputOf<Body>& now : seen)
            for (int c = 0; c < circuits; ++c) {
                widen(tick.pump[c], now.circuit[c].pump.pressure);
                widen(tick.unit[c], now.circuit[c].unit.pressure);
            }
    }
    const S period = machine.step * S(static_cast<base_t<S>>(machine.steps));
    add(tick.losses, S(1) / period, losses);
    tick.servo_power = machine.idle, tick.losses.idle += machine.idle;
    for (int c = 0; c < circuits; ++c) {
        tick.power[c] = (state.plant.energy[c] - tick.power[c]) / period;
        tick.servo_power += tick.power[c];
    }
    state.battery = battery_output(machine.battery, state.taken, tick.servo_power);
    state.taken += state.battery.current * period;
    state.targets.supply = state.battery.supply;
}

/// The twin's state at rest: circuits filled, battery full.
template <class S, int D, class Space = InPlane>
TwinState<S, D, Space> at_rest(const Controller<S>& controller, const Battery<S>& battery, const S& idle,
                               const PlantState<S, D, Space>& plant) {
    TwinState<S, D, Space> state{};
    state.plant = plant;
    state.controller = init(controller);
    state.battery = battery_output(battery, S(0), idle);
    state.targets.supply = state.battery.supply;
    return state;
}
template <class Body>
TwinStateOf<Body> at_rest(const Twin<Body>& twin) {
    return at_rest<typename Body::Scalar, Body::coordinates, typename Body::Space>(twin.controller, twin.battery,
                                                                                   twin.idle, at_rest(twin.plant));
}

/// Set the servos' targets to what the pulses ask for.
template <class S, int D, class Space>
void set_targets(const Controller<S>& controller, const ControllerOutput<S>& output, MachineState<S, D, Space>& state) {
    const auto angle_of = [&](int servo) {
        return (output.pulse[servo] - controller.pulse_center) / controller.pulse_per_rad;
    };
    const int circuits = 2 * controller.joints;
    for (int c = 0; c < circuits; ++c) state.targets.angle[c] = angle_of(c);
    for (int k = 0; k < 2; ++k) state.targets.fin[k] = angle_of(circuits + k);
}

/// One tick of the twin. `sense` turns true values into the sensors' readings, and `decide` turns readings into the
/// controller's output: by the controller alone, or by a pilot.
template <class Body, class Sense, class Decide>
TickOf<Body> decided_tick(const Twin<Body>& twin, TwinStateOf<Body>& state, const Sense& sense, const Decide& decide) {
    TickOf<Body> tick{};
    plant_rate(twin.plant, state.plant, state.targets, &tick.seen);
    tick.readings = sense(true_readings(twin, state, tick.seen));
    tick.output = decide(tick.readings);
    set_targets(twin.controller, tick.output, state);
    follow_targets(twin, state, tick);
    return tick;
}

/// One tick of the twin, its controller under a command and without a pilot.
template <class Body, class Sense>
TickOf<Body> twin_tick(const Twin<Body>& twin, TwinStateOf<Body>& state, const Command<typename Body::Scalar>& command,
                       const Sense& sense) {
    return decided_tick(twin, state, sense, [&](const auto& readings) {
        const auto next = step(twin.controller, state.controller, of_robot(readings), command);
        state.controller = next.state;
        return next.output;
    });
}

/// One tick without sensors and controller, from given servo targets.
template <class Body>
TickOf<Body> driven_tick(const Twin<Body>& twin, TwinStateOf<Body>& state, const typename Body::Scalar* target) {
    TickOf<Body> tick{};
    for (int c = 0; c < 2 * twin.plant.joints; ++c) state.targets.angle[c] = target[c];
    plant_rate(twin.plant, state.plant, state.targets, &tick.seen);
    follow_targets(twin, state, tick);
    return tick;
}

/// Whether the head's motion is physically possible: 100 m/s at most, and finite.
template <class S>
bool plausible(const Twist<S>& xi, const Pose<S>& pose) {
    const S far = S(base_t<S>(100));
    return abs(xi.x) < far && abs(xi.y) < far && abs(xi.z) < far && is_finite(pose.x + pose.y);
}

/// Whether the plant's state is physically possible: bends below half a turn, 100 m/s at most, and finite.
template <class S, int D, class Space>
bool plausible(const PlantState<S, D, Space>& at) {
    const S turn = S(base_t<S>(pi));
    bool good = plausible(at.xi, at.pose);
    for (int d = 0; d < D; ++d) good = good && abs(at.bend.angle[d]) < turn && is_finite(at.bend.rate[d]);
    for (int c = 0; c < 2 * D; ++c) good = good && is_finite(at.circuit[c].flow + at.circuit[c].rate);
    return good;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
