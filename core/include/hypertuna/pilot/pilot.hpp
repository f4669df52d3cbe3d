/// Pilot: all that runs on board, a hundred times a second. Readings and a mission go in, servo pulses come out.
///
/// estimator (each tick) -> guidance (each tenth) -> controller (each tick).
#pragma once

#include "hypertuna/pilot/guidance.hpp"

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
    bool fix;    // a fix was used since the last decision
    bool joint;  // a joint was released since the last decision
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
    begin(pilot.controller, state.controller);
    const T start[2] = {mission.start.x, mission.start.y};
    state.estimator = init(pilot.estimator, start);
    state.guidance = init(pilot.guidance, mission);
    return state;
}

/// Steady speed of the present beat [m/s]: the gait table's at the frequency that the oscillators have now.
template <class T>
T beat_speed_of(const Pilot<T>& pilot, const ControllerState<T>& state) {
    const GaitTable<T>& table = pilot.guidance.steering.table;
    const T frequency = state.frequency.value;
    int k = 0;
    while (k < table.gaits - 1 && table.frequency[k] < frequency) ++k;
    const T below = k > 0 ? table.frequency[k - 1] : T(0), slow = k > 0 ? table.speed[k - 1] : T(0);
    const T part = clamp((frequency - below) / (table.frequency[k] - below), T(0), T(1));
    // A tail that swings less, because it turns or rests, pushes less.
    const T full = beating(table, pilot.controller.joints, table.speed[k]).amplitude[0];
    const T swing = clamp(state.amplitude[0].value / full, T(0), T(1));
    return swing * (slow + part * (table.speed[k] - slow));
}

/// Whether no channel of the IMU is faulty.
template <class T>
bool imu_valid(const ControllerState<T>& state) {
    bool good = true;
    for (const Health<T>& channel : state.imu) good = good && !channel.faulty;
    return good;
}

/// Estimate the robot's motion from a tick's readings; `declination` is that of the magnetic field [rad].
template <class T>
Estimate<T> perceive(const Pilot<T>& pilot, PilotState<T>& state, const PilotReadings<T>& readings, T declination) {
    const T beat_speed = beat_speed_of(pilot, state.controller);
    const bool imu = imu_valid(state.controller);
    const Estimate<T> at = estimate(pilot.estimator, state.estimator, readings, beat_speed, imu, declination);
    state.fix = state.fix || at.fix;
    state.command.fresh = false;
    return at;
}

/// Count the ticks to the next decision, and say whether it is due.
template <class T>
bool due(const Pilot<T>& pilot, PilotState<T>& state) {
    const bool now = state.wait == 0;
    if (now) {
        carry(pilot.estimator.way, state.estimator.way, pilot.estimator.attitude.tick);
        state.wait = pilot.every;
    }
    --state.wait;
    return now;
}

/// Let guidance decide on the command that holds until the next decision.
template <class T>
void decide(const Pilot<T>& pilot, PilotState<T>& state, Estimate<T> at, const Mission<T>& mission) {
    at.fix = state.fix;
    const Onboard<T> onboard{state.controller.supply, state.controller.voltage.faulty, state.joint};
    const Guided<T> guided = guide(pilot.guidance, state.guidance, at, onboard, mission);
    state.guidance = guided.state;
    state.command = guided.command;
    state.fix = state.joint = false;
}

/// Decide without guidance: the command's beat is turned to face a direction, and the fins hold a depth, as on a leg.
template <class T>
void steer(const Pilot<T>& pilot, PilotState<T>& state, const Estimate<T>& at, const Command<T>& beat,
           const Course<T>& facing, T depth) {
    const Steering<T>& steering = pilot.guidance.steering;
    state.command = beat;
    turn_beat(steering, state.command,
              at.attitude ? bias_for(steering, state.guidance.steering, facing, at.speed) : T(0));
    steer_depth(pilot.guidance, state.guidance, at, depth, state.command);
}

/// Run the controller under the present command.
template <class T>
void act(const Pilot<T>& pilot, PilotState<T>& state, const Estimate<T>& at, const Readings<T>& robot,
         ControllerOutput<T>& output) {
    advance(pilot.controller, state.controller, robot, state.command, output);
    update(state.guidance.steering.beat, at, state.controller.posture[0].ended,
           int(T(1) / pilot.estimator.attitude.tick));
    state.joint = state.joint || output.status.has(Condition::hard_stop);
}

/// One tick of the pilot: estimate, decide where a decision is due, control.
template <class T>
PilotStep<T> fly(const Pilot<T>& pilot, const PilotState<T>& before, const PilotReadings<T>& readings,
                 const Mission<T>& mission) {
    PilotStep<T> next{before, {}, {}, {}, {}, {}};
    PilotState<T>& state = next.state;
    next.estimate = perceive(pilot, state, readings, mission.declination);
    if (due(pilot, state)) decide(pilot, state, next.estimate, mission);
    act(pilot, state, next.estimate, readings.robot, next.output);
    next.command = state.command;
    next.mode = state.guidance.mode;
    next.reasons = state.guidance.reasons;
    return next;
}

/// Call visit(name, index, field) for every number of the pilot except the controller's. The numbers of joints and
/// gaits must be set before.
template <class T, class Visit>
void visit_fields(Pilot<T>& m, const Visit& visit) {
    visit("every", 0, m.every);
    visit_fields(m.estimator, visit);
    visit_fields(m.guidance, visit);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
