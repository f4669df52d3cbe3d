/// Input of the controller: commands within their bounds, and valid readings.
#pragma once

#include "hypertuna/control/controller_model.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Store a commanded value within its bounds; one that is not a number leaves the last good one.
template <class T>
void take(T& kept, T value, T low, T high, Status& status) {
    if (low <= value && value <= high) {
        kept = value;
        return;
    }
    status.set(Condition::bad_command);
    if (is_finite(value)) kept = clamp(value, low, high);
}

/// Amplitude at which the pressure stays below the soft limit by the model: for frequencies without a pressure reading.
template <class T>
T safe_amplitude(const JointModel<T>& joint, T frequency) {
    return T(1) / (joint.safe_static + frequency * (joint.safe_rate + frequency * joint.safe_square));
}

template <class T>
void take_command(const Controller<T>& model, ControllerState<T>& state, const Command<T>& command, Status& status) {
    const T turn = T(2 * pi);
    state.age = command.fresh ? 0 : state.age <= model.timeout ? state.age + 1 : state.age;
    if (command.fresh) {
        Setpoint<T>& target = state.target;
        take(target.frequency, command.frequency, T(0), model.frequency_max, status);
        for (int j = 0; j < model.joints; ++j) {
            take(target.amplitude[j], command.amplitude[j], T(0), model.joint[j].amplitude, status);
            take(target.phase[j], command.phase[j], -turn, turn, status);
            take(target.bias[j], command.bias[j], -model.joint[j].amplitude, model.joint[j].amplitude, status);
        }
        for (int k = 0; k < 2; ++k) take(target.fin[k], command.fin[k], -model.fin_max, model.fin_max, status);
        for (int j = 0; j < model.joints; ++j) {
            if (direct(model, j)) continue;
            // A tail that starts from rest overshoots its steady beats, so its governor starts as at a frequency that
            // it has not seen.
            if (state.amplitude[j].value < T(governor_floor)) state.governor[j].frequency = T(0);
            expect(state.governor[j], target.frequency, safe_amplitude(model.joint[j], target.frequency));
        }
        // Only arming anew, not staying armed, ends the stop of a circuit.
        if (command.armed && !state.armed)
            for (int c = 0; c < 2 * model.joints; ++c) state.circuit[c].stopped = false;
        state.armed = command.armed;
    }
    if (state.age > model.timeout) status.set(Condition::timeout);
    if (!state.armed) status.set(Condition::disarmed);
}

/// Whether a joint has a circuit without a valid pressure reading.
template <class T>
bool blind(const ControllerState<T>& state, int j) {
    return state.pressure[2 * j].faulty || state.pressure[2 * j + 1].faulty;
}

/// Whether no sensor shows a joint's bend: the readings are not valid, or do not follow the joint.
template <class T>
bool unseen(const ControllerState<T>& state, int j) {
    return state.bend[j].faulty || state.posture[j].dull > 1;
}

/// Motion of a circuit's servo from 0 to 1, which is reached at 0.2 rad/s: how clearly its joint's sensors must show
/// it.
template <class T>
T motion_of(const Controller<T>& model, const SupervisorState<T>& circuit) {
    return min(T(1), abs(circuit.change) * (T(5) / model.tick));
}

/// Largest motion of any circuit's servo: it moves the whole body and changes every pressure.
template <class T>
T motion_of(const Controller<T>& model, const ControllerState<T>& state) {
    T change = T(0);
    for (int c = 0; c < 2 * model.joints; ++c) change = max(change, abs(state.circuit[c].change));
    return min(T(1), change * (T(5) / model.tick));
}

/// Check the readings of currents, IMU and battery. Only the voltage steers anything: the servos' speed depends on it.
template <class T>
void read_robot(const Controller<T>& model, ControllerState<T>& state, const Readings<T>& readings, T motion,
                Status& status) {
    const auto range = [](T low, T high, T part) {
        return Plausible<T>{low, high, part * (high - low), T(repeats_slow)};
    };
    const auto plain = [&](const Plausible<T>& limits, Health<T>& health, T reading) {
        return judge(limits, health, reading, health.last, motion).usable;
    };
    // An empty range: the robot has no such sensor.
    const Plausible<T> current = range(model.current_low, model.current_high, T(0.24));
    for (int j = 0; j < model.joints && current.low < current.high; ++j)
        for (int c = 2 * j; c < 2 * j + (direct(model, j) ? 1 : 2); ++c)
            if (!plain(current, state.current[c], readings.current[c])) status.set(Condition::current_fault, c);
    const auto judge_imu = [&](const T(&reading)[3], Health<T>* health, T limit) {
        const Plausible<T> limits = range(-limit, limit, T(0.2));
        for (int k = 0; k < 3 && T(0) < limit; ++k)
            if (!plain(limits, health[k], reading[k])) status.set(Condition::imu_fault);
    };
    judge_imu(readings.rate, state.imu, model.rate_high);
    judge_imu(readings.acceleration, state.imu + 3, model.acceleration_high);
    if (!(model.voltage_min < model.voltage_max)) return;
    const bool first = !state.voltage.seen;
    const bool voltage = plain(range(model.voltage_min, model.voltage_max, T(0.2)), state.voltage, readings.voltage);
    if (voltage) state.supply += (first ? T(1) : T(0.1)) * (readings.voltage - state.supply);
    if (!voltage) status.set(Condition::battery_fault);
    if (state.voltage.seen && state.supply < model.voltage_low) status.set(Condition::low_voltage);
}

/// Use a valid pressure reading; `trusted` says that none of the sensor's recent readings was rejected.
template <class T>
void use_pressure(const Controller<T>& model, ControllerState<T>& state, int c, T reading, bool trusted) {
    SupervisorState<T>& circuit = state.circuit[c];
    Governor<T>& governor = state.governor[c / 2];
    // Learn from readings two ticks apart, and never across a cavity, where the oil yields.
    if (trusted && T(0) < circuit.before && T(0) < circuit.pressure && T(0) < reading)
        learn(state.viscosity, model.circuit[c].line * (circuit.servo.change - circuit.turned[1]) / model.tick,
              reading - circuit.before);
    // In a line that rings a peak lasts for one reading: no median.
    const bool rings = model.circuit[c].rings(), single = trusted && rings;
    governor.peak = max(governor.peak, single ? reading : median(circuit.before, circuit.pressure, reading));
    circuit.before = circuit.pressure;
    circuit.pressure = reading;
    if (!rings) return;
    circuit.crest = max(reading, circuit.crest + T(crest_fall) * (reading - circuit.crest));
    circuit.trough = min(reading, circuit.trough + T(trough_rise) * (reading - circuit.trough));
}

/// Read a circuit's pressure, and stop the circuit where the pressure has passed the hard limit.
template <class T>
void read_pressure(const Controller<T>& model, ControllerState<T>& state, int c, T reading, T motion, Status& status) {
    const SupervisorModel<T>& supervisor = model.circuit[c];
    SupervisorState<T>& circuit = state.circuit[c];
    const ReadingQuality<T> quality =
        judge({model.pressure_low, model.pressure_high, model.pressure_step, T(repeats_fast)}, state.pressure[c],
              reading, state.pressure[c].last, motion, !circuit.wrong);
    Governor<T>& governor = state.governor[c / 2];
    const bool trusted = state.pressure[c].bucket == 0;
    if (quality.usable) {
        use_pressure(model, state, c, reading, trusted);
    } else {
        status.set(Condition::pressure_fault, c);
        circuit.pressure = min(circuit.pressure, circuit.before);  // the reading before may have begun a spike
    }
    // A spike does not stop a joint; a pressure that lasts does, even where the sensor seems faulty.
    circuit.hard = model.pressure_hard < reading && reading <= model.pressure_high ? circuit.hard + 1 : 0;
    if ((trusted ? hard_trusted : hard_any) <= circuit.hard) circuit.stopped = true;
    governor.untrusted = governor.untrusted || !quality.usable || repeats(state.pressure[c]);
    if (state.pressure[c].faulty) {
        status.set(Condition::blind, c);
        circuit.before = circuit.pressure = circuit.crest = circuit.trough = supervisor.fill;
        governor.ceiling =
            min(governor.ceiling, max(governor.proven, safe_amplitude(model.joint[c / 2], state.target.frequency)));
    }
    circuit.turned[1] = circuit.turned[0], circuit.turned[0] = circuit.servo.change;
    if (circuit.stopped) status.set(Condition::hard_stop, c);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
