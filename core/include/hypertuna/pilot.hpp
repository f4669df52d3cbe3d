/// Pilot: all that runs on board, a hundred times a second. Readings and a mission go in, servo pulses come out.
///
/// estimator (each tick) -> guidance (each tenth) -> controller (each tick).
#pragma once

#include "guidance.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct Pilot {
    Controller<T> controller;
    Estimator<T> estimator;
    Guidance<T> guidance;
    int every;  // ticks from one decision to the next
};

template <class T>
struct PilotState {
    ControllerState<T> controller;
    EstimatorState<T> estimator;
    GuidanceState<T> guidance;
    Command<T> command;
    int wait;    // ticks until the next decision
    bool fix;    // one was taken in since the last
    bool joint;  // one was released since
};

template <class T>
struct PilotStep {
    PilotState<T> state;
    ControllerOutput<T> output;
    Command<T> command;
    Estimate<T> estimate;
    Mode mode;
    Reasons reasons;
};

template <class T>
PilotState<T> init(const Pilot<T>& pilot, const Mission<T>& mission) {
    PilotState<T> state{};
    state.controller = init(pilot.controller);
    const T start[2] = {mission.start.x, mission.start.y};
    state.estimator = init(pilot.estimator, start);
    state.guidance = init(pilot.guidance, mission);
    return state;
}

/// Speed that the present beat keeps up: the table's for the frequency that the oscillators have now.
template <class T>
T thrust_of(const Pilot<T>& pilot, const ControllerState<T>& state) {
    const GaitTable<T>& table = pilot.guidance.steering.table;
    const T frequency = state.frequency.value;
    int k = 0;
    while (k < table.gaits - 1 && table.frequency[k] < frequency) ++k;
    const T below = k > 0 ? table.frequency[k - 1] : T(0), slow = k > 0 ? table.speed[k - 1] : T(0);
    const T part = clamp((frequency - below) / (table.frequency[k] - below), T(0), T(1));
    // What swings less, because it turns or rests, pushes less.
    const T full = beating(table, pilot.controller.joints, table.speed[k]).amplitude[0];
    const T swing = clamp(state.amplitude[0].value / full, T(0), T(1));
    return swing * (slow + part * (table.speed[k] - slow));
}

/// Whether every channel of the IMU is in good standing.
template <class T>
bool imu_stands(const ControllerState<T>& state) {
    bool good = true;
    for (const Health<T>& channel : state.imu) good = good && !channel.faulty;
    return good;
}

/// One tick.
template <class T>
PilotStep<T> fly(const Pilot<T>& pilot, const PilotState<T>& before, const PilotReadings<T>& readings,
                 const Mission<T>& mission) {
    PilotStep<T> next{before, {}, {}, {}, {}, {}};
    PilotState<T>& state = next.state;
    const T thrust = thrust_of(pilot, state.controller);
    next.estimate = estimate(pilot.estimator, state.estimator, readings, thrust, imu_stands(state.controller));
    state.fix = state.fix || next.estimate.fix;
    state.command.fresh = false;
    if (state.wait == 0) {
        carry(pilot.estimator, state.estimator.way);
        Estimate<T> at = next.estimate;
        at.fix = state.fix;
        const Onboard<T> onboard{state.controller.supply, state.controller.voltage.faulty, state.joint};
        const Guided<T> guided = guide(pilot.guidance, state.guidance, at, onboard, mission);
        state.guidance = guided.state;
        state.command = guided.command;
        state.wait = pilot.every;
        state.fix = state.joint = false;
    }
    --state.wait;
    const ControllerStep<T> step_ = step(pilot.controller, state.controller, readings.robot, state.command);
    const bool ended = beat_ends(state.controller.oscillator[0], step_.state.oscillator[0]);
    look(state.guidance.steering.beat, next.estimate, ended, int(T(1) / pilot.estimator.attitude.tick));
    state.controller = step_.state;
    state.joint = state.joint || step_.output.status.has(Condition::hard_stop);
    next.output = step_.output;
    next.command = state.command;
    next.mode = state.guidance.mode;
    next.reasons = state.guidance.reasons;
    return next;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
