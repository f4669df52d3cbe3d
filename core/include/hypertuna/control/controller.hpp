/// Controller: what runs on the robot. A command and readings go in, servo pulses and a status come out.
///
/// oscillators -> bend of each joint -> servo angles by the inverse volume map -> pressure supervisor -> slew, clamp.
/// The servo of a joint without oil is sent to the bend itself or, where tendons go between, to its turns for that
/// bend. The controller uses only + - * / sqrt and sincos of trig.hpp: without contraction to fused multiply-adds,
/// every machine gets the same bits.
#pragma once

#include "hypertuna/control/controller_input.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Advance the filters of all commanded values, and the oscillators, by one tick.
template <class T>
void generate(const Controller<T>& model, ControllerState<T>& state, bool active) {
    const Setpoint<T>& target = state.target;
    state.frequency = follow(model.smoothing, state.frequency, target.frequency);
    const SinCos<T> turn = sincos(T(2 * pi) * state.frequency.value * model.tick);
    const Oscillator<T> reference = state.oscillator[0];
    for (int j = 0; j < model.joints; ++j) {
        state.amplitude[j] = follow(model.smoothing, state.amplitude[j], active ? target.amplitude[j] : T(0));
        state.bias[j] = follow(model.smoothing, state.bias[j], active ? target.bias[j] : T(0));
        state.phase[j] = follow(model.smoothing, state.phase[j], target.phase[j]);
        Oscillator<T>& z = state.oscillator[j];
        const Oscillator<T> before = z;
        if (j > 0) z = couple(model.network, z, reference, sincos(state.phase[j].value));
        z = oscillate(model.network, z, turn);
        state.posture[j].ended = beat_ends(before, z);
    }
    for (int k = 0; k < 2; ++k) state.fin[k] = follow(model.smoothing, state.fin[k], active ? target.fin[k] : T(0));
}

/// Amplitude that command and posture correction ask of a joint, before the limits of its pressures.
template <class T>
T asked_amplitude(const ControllerState<T>& state, int j) {
    return state.amplitude[j].value * (T(1) + state.more[j].value);
}

/// Amplitude and bias that a joint's pressures allow. The governor bounds the widest bend, bias included, and the
/// hammer of the oil bounds the rate of the bend. Without a pressure reading, the pressure that holds a bias also
/// bounds that bias.
template <class T>
BeatShape<T> allowed(const Controller<T>& model, const ControllerState<T>& state, int j) {
    const T limit = state.governor[j].bend_limit;
    const T fill = model.circuit[2 * j].fill, part = (model.pressure_work - fill) / (model.pressure_soft - fill);
    const T bias_limit = blind(state, j) ? min(limit, part / model.joint[j].safe_static) : limit;
    const T bias = clamp(state.bias[j].value + state.aside[j].value, -bias_limit, bias_limit);
    const T rate = (unseen(state, j) ? T(flow_unseen) : T(1)) * model.joint[j].sent_rate;
    return {min(asked_amplitude(state, j), min(limit - abs(bias), rate * state.swing)), bias};
}

/// At the end of a joint's beat, learn the corrections of amplitude and bias from the bends that were sent and read.
template <class T>
void correct_posture(const Controller<T>& model, ControllerState<T>& state, int j) {
    PostureState<T>& posture = state.posture[j];
    const PostureModel<T>& rules = model.posture;
    const T ticks = T(posture.ticks), length = ticks * state.frequency.value * model.tick;
    const bool whole = abs(length - T(1)) < T(beat_length) && T(posture.missing) <= rules.missing * ticks;
    const bool stopped = state.circuit[2 * j].stopped || state.circuit[2 * j + 1].stopped;
    if (whole && !stopped) {
        posture.seen = refit(posture.seen, posture.error, ticks);
        const BeatShape<T> seen = shape(posture.seen), sent{posture.sent.amplitude / ticks, posture.sent.bias / ticks};
        const bool judged = rules.amplitude_min < sent.amplitude;
        const bool dull = judged && swing(posture.seen) < rules.moving * sent.amplitude;
        if (judged) posture.dull = !dull ? 0 : posture.dull < 2 ? posture.dull + 1 : 2;
        if (!dull && state.armed) {
            const T reach = model.joint[j].reach;
            const bool held = T(posture.limited) > rules.limited * ticks;
            const T factor = clamp(sent.amplitude / max(seen.amplitude, T(1e-3)), T(1 / factor_max), T(factor_max));
            if (judged) posture.more = learn(posture.more, factor - T(1), rules.learning, held);
            posture.aside = clamp(learn(posture.aside, sent.bias - seen.bias, rules.learning, held), -reach, reach);
        }
    }
    posture.error = {}, posture.sent = {};
    posture.ticks = posture.missing = posture.limited = 0;
}

/// One tick of a joint's posture control: take in the bend reading, and learn from the beat where it ends.
template <class T>
void hold_posture(const Controller<T>& model, ControllerState<T>& state, int j, T reading, Status& status) {
    PostureState<T>& posture = state.posture[j];
    Governor<T>& governor = state.governor[j];
    const JointModel<T>& joint = model.joint[j];
    const ReadingQuality<T> quality =
        judge({-joint.bend_range, joint.bend_range, joint.bend_step, T(repeats_fast)}, state.bend[j], reading,
              state.bend[j].last, motion_of(model, state.circuit[2 * j]),
              !(state.circuit[2 * j].bent || state.circuit[2 * j + 1].bent));
    const BeatShape<T> sent = allowed(model, state, j);
    if (quality.usable) {
        add_reading(posture, state.oscillator[j], reading);
        governor.swung = max(governor.swung, abs(reading));
    } else {
        status.set(Condition::bend_fault, j), ++posture.missing;
    }
    posture.sent.amplitude += sent.amplitude, posture.sent.bias += sent.bias;
    ++posture.ticks;
    if (posture.ended) {
        const T frequency = max(state.frequency.value, state.target.frequency);
        correct_posture(model, state, j);
        govern(governor, {sent.amplitude + abs(sent.bias), frequency, joint.reach, joint.rate},
               model.circuit[2 * j].fill, model.pressure_work);
    }
    // Two beats without a swing: the sensor gives readings, but does not follow the joint.
    if (posture.dull > 1) status.set(Condition::bend_fault, j);
    if (unseen(state, j)) status.set(Condition::open_loop, j);
    state.more[j] = follow(model.smoothing, state.more[j], posture.more);
    state.aside[j] = follow(model.smoothing, state.aside[j], state.armed ? posture.aside : T(0));
}

/// Last step for every servo's angle: limit its slew and clamp its pulse. The last good angle replaces one that is not
/// a number.
template <class T>
void send(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int servo, T angle) {
    const T last_angle = state.sent[servo], max_change = model.slew * model.tick;
    if (!(abs(angle - last_angle) <= max_change)) {
        angle = is_finite(angle) ? clamp(angle, last_angle - max_change, last_angle + max_change) : last_angle;
        output.status.set(Condition::slew_limit, servo);
    }
    T pulse = model.pulse_center + model.pulse_per_rad * angle;
    if (!(model.pulse_min <= pulse && pulse <= model.pulse_max)) {
        pulse = clamp(pulse, model.pulse_min, model.pulse_max);
        angle = (pulse - model.pulse_center) / model.pulse_per_rad;
        output.status.set(Condition::pulse_limit, servo);
    }
    state.sent[servo] = output.target[servo] = angle;
    output.pulse[servo] = pulse;
}

/// Bend to send a joint to, within what its pressures allow and its pumps reach.
template <class T>
T asked_bend(const Controller<T>& model, ControllerState<T>& state, int j, Status& status) {
    Governor<T>& governor = state.governor[j];
    governor.bend_limit += model.smoothing.rate * (governor.ceiling - governor.bend_limit);
    const BeatShape<T> sent = allowed(model, state, j);
    const bool limited = sent.amplitude < asked_amplitude(state, j);
    if (limited && direct(model, j)) status.set(Condition::amplitude_limit, j);
    for (int side = 0; side < 2 && limited && !direct(model, j); ++side)
        status.set(Condition::pressure_limit, 2 * j + side);
    const T wanted = sent.bias + sent.amplitude * state.oscillator[j].x;
    const T reach = model.joint[j].reach, bend = clamp(wanted, -reach, reach);
    if (bend != wanted) status.set(Condition::amplitude_limit, j), ++state.posture[j].limited;
    // After a limit the bend catches up little faster than the beat goes: no jump, no surge of pressure.
    const T fastest = sent.amplitude * T(2 * pi) * state.frequency.value * model.tick + abs(state.bias[j].change);
    const T limit = T(1.25) * fastest + T(0.02) * reach, last_bend = state.bend_sent[j];
    return clamp(bend, last_bend - limit, last_bend + limit);
}

/// Send a circuit's servo to an angle, and return whether the servo can follow; `supply` is the part of the rated
/// voltage. By the torque-speed line the servo has its full speed without load and none at the stall pressure.
template <class T>
bool drive_circuit(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int c, T angle,
                   T supply) {
    const SupervisorModel<T>& supervisor = model.circuit[c];
    SupervisorState<T>& circuit = state.circuit[c];
    const T last_angle = state.sent[c];
    send(model, state, output, c, angle);
    circuit.change = output.target[c] - last_angle;
    circuit.servo = follow(model.servo, circuit.servo, output.target[c]);
    const T free = supply - max(T(0), circuit.pressure) / supervisor.stall;
    output.pressure[c] = circuit.pressure;
    const bool slow = max(T(0.1), free) * supervisor.speed * model.tick < abs(circuit.change);
    if (slow) output.status.set(Condition::speed_limit, c);
    return !slow && output.target[c] == angle;
}

/// Furthest angle that a circuit's servo may be sent to in this tick. Above the soft limit the servo goes back. It
/// turns no faster than the flow's pressure fits between the pressure in the drive units and the soft limit. In a line
/// that rings, the crest of the readings limits the way forward and their trough the way back: otherwise the pump would
/// jerk, and the line ring more.
template <class T>
T furthest_angle(const Controller<T>& model, const ControllerState<T>& state, int c, bool rings) {
    const SupervisorModel<T>& supervisor = model.circuit[c];
    const SupervisorState<T>& circuit = state.circuit[c];
    const T viscosity = state.viscosity.value, line = supervisor.line * viscosity;
    // A single reading of a doubted sensor may be a spike.
    const T reading = state.pressure[c].bucket != 0 ? min(circuit.pressure, circuit.before) : circuit.pressure;
    const T low = rings ? circuit.trough : reading, high = rings ? circuit.crest : reading;
    const T bent = model.joint[c / 2].safe_static * abs(state.bend_sent[c / 2]);
    const T least_rise = max(T(flow_held) * viscosity, bent) * (model.pressure_soft - supervisor.fill);
    const T unit = max(supervisor.fill + least_rise, high - line * circuit.servo.change / model.tick);
    const T margin = max(T(0), model.pressure_soft - unit);
    const T rate = margin / pressure_per_rate(supervisor, state.viscosity.largest) * model.tick;
    const T change = rings ? min(rate, circuit.servo.change + supervisor.smooth * model.tick) : rate;
    const T target = furthest_target(model.servo, circuit.servo, change);
    if (low <= model.pressure_soft) return target;
    return min(target, furthest_pump_angle(supervisor, state.sent[c], low, model.pressure_soft, model.pressure_hard,
                                           model.tick));
}

/// Furthest angle back that the pump of a line that rings may be sent to in this tick. The pump moves smoothly, and so
/// slowly that its cylinder does not run empty: oil that refills an empty cylinder hammers. A lower trough of the
/// pressure makes the pump slower.
template <class T>
T nearest_angle(const Controller<T>& model, const ControllerState<T>& state, int c) {
    const SupervisorModel<T>& supervisor = model.circuit[c];
    const Follower<T>& servo = state.circuit[c].servo;
    const T lowest_rate = supervisor.spare * max(T(0), supervisor.fill - state.circuit[c].trough) - supervisor.draw;
    const T change = max(servo.change - supervisor.smooth * model.tick, min(T(0), lowest_rate) * model.tick);
    return furthest_target(model.servo, servo, change);
}

/// Send a joint's two servos to the angles for the bend that is asked.
///
/// Where one circuit is held back, both go the same part of the way. Otherwise the side that draws would outrun the
/// side that pushes, and the oil between them would be lost beat by beat.
template <class T>
void drive_joint(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int j) {
    const T asked = asked_bend(model, state, j, output.status);
    const bool stopped = state.circuit[2 * j].stopped || state.circuit[2 * j + 1].stopped;
    const T supply = min(T(1), state.supply / model.voltage_rated);
    const auto angle_of = [&](int side, T bend) {
        return stopped ? T(0) : servo_angle(model.map[2 * j + side], side == 0 ? bend : -bend);
    };
    T angle[2], nearest[2], furthest[2], part = T(1);
    bool pressed = false, followed = true;
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        angle[side] = angle_of(side, asked);
        const bool rings = model.circuit[c].rings();
        nearest[side] = rings ? nearest_angle(model, state, c) : T(-1e3);
        furthest[side] = furthest_angle(model, state, c, rings);
        if (nearest[side] <= angle[side] && angle[side] <= furthest[side]) continue;
        const T last_angle = angle_of(side, state.bend_sent[j]);
        const T way = furthest[side] < angle[side] ? furthest[side] - last_angle : last_angle - nearest[side];
        part = min(part, max(T(0), way / max(abs(angle[side] - last_angle), T(1e-6))));
        output.status.set(Condition::pressure_limit, c), pressed = true;
    }
    state.bend_sent[j] = pressed ? state.bend_sent[j] + part * (asked - state.bend_sent[j]) : asked;
    state.governor[j].sent = max(state.governor[j].sent, abs(state.bend_sent[j]));
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        const T sent = min(pressed ? angle_of(side, state.bend_sent[j]) : angle[side], furthest[side]);
        followed = drive_circuit(model, state, output, c, max(sent, nearest[side]), supply) && followed;
    }
    if (pressed || !followed) ++state.posture[j].limited;
}

/// Send the servo of a joint without oil to the bend that is asked, times the servo's turns per bend.
template <class T>
void turn_joint(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int j) {
    const T supply = min(T(1), state.supply / model.voltage_rated);
    state.bend_sent[j] = asked_bend(model, state, j, output.status);
    drive_circuit(model, state, output, 2 * j, model.joint[j].direct * state.bend_sent[j], supply);
    send(model, state, output, 2 * j + 1, T(0));
}

/// Compare a joint's pressure readings with the pressures that follow from its bend and its pumps' angles. The means
/// are free of most of the water's loads, and the drop along the line of the thickest possible oil is allowed for.
/// Where the bend sensor is as far from the bend that the pumps were sent to, in the direction that explains the
/// pressures, the bend sensor is to blame. Each tick checks one joint.
template <class T>
HYPERTUNA_NOINLINE void check_pressures(const Controller<T>& model, ControllerState<T>& state,
                                        const Readings<T>& readings) {
    const int j = state.checked = state.checked + 1 < model.joints ? state.checked + 1 : 0;
    if (direct(model, j)) return;
    const T weight = T(model.joints) * model.tick / T(astray_time), reach = model.joint[j].reach;
    const T bend = state.bend[j].last, line = state.viscosity.largest / model.tick;
    state.slip[j] += weight * (bend - state.bend_sent[j] - state.slip[j]);
    for (int c = 2 * j; c < 2 * j + 2; ++c) {
        const SupervisorModel<T>& supervisor = model.circuit[c];
        SupervisorState<T>& circuit = state.circuit[c];
        const T side = c == 2 * j ? T(1) : T(-1), reading = readings.pressure[c];
        const T expected = held(supervisor, side * clamp(bend, -reach, reach)), off = reading - expected;
        const T drop = supervisor.line * line * circuit.servo.change;
        if (model.pressure_low <= reading && reading <= model.pressure_high)
            circuit.astray += weight * (off - clamp(off, min(T(0), drop), max(T(0), drop)) - circuit.astray);
        const T tolerance =
            T(astray_room) * (model.pressure_soft - supervisor.fill) + T(astray_held) * abs(expected - supervisor.fill);
        const T slipped = side * supervisor.hold[0] * state.slip[j];
        const bool astray = tolerance < abs(circuit.astray);
        circuit.bent = astray && T(0.5) * tolerance < abs(slipped) && (T(0) < slipped) == (circuit.astray < T(0));
        circuit.wrong = astray && !circuit.bent;
    }
}

/// One tick of the controller; changes state and output in place.
template <class T>
void advance(const Controller<T>& model, ControllerState<T>& state, const Readings<T>& readings,
             const Command<T>& command, ControllerOutput<T>& output) {
    Status& status = output.status;
    status = {};
    take_command(model, state, command, status);
    generate(model, state, state.armed && state.age <= model.timeout);
    const T motion = motion_of(model, state);
    read_robot(model, state, readings, motion, status);
    check_pressures(model, state, readings);
    for (int c = 0; c < 2 * model.joints; ++c)
        if (!direct(model, c / 2)) read_pressure(model, state, c, readings.pressure[c], motion, status);
    weigh(state.viscosity, model.viscosity_min, model.viscosity_own);
    state.swing = state.viscosity.rate / (T(2 * pi) * max(state.frequency.value, T(0.1)));
    for (int j = 0; j < model.joints; ++j) {
        output.set[j] = state.bias[j].value + state.amplitude[j].value * state.oscillator[j].x;
        if (direct(model, j)) {
            turn_joint(model, state, output, j);
            continue;
        }
        hold_posture(model, state, j, readings.bend[j], status);
        drive_joint(model, state, output, j);
    }
    for (int k = 0; k < 2; ++k) send(model, state, output, 2 * model.joints + k, state.fin[k].value);
}

/// One tick of the controller as a pure function: returns the new state and the output.
template <class T>
ControllerStep<T> step(const Controller<T>& model, const ControllerState<T>& before, const Readings<T>& readings,
                       const Command<T>& command) {
    ControllerStep<T> next{before, {}};
    advance(model, next.state, readings, command, next.output);
    return next;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
