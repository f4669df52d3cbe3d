/// Controller: what runs on the robot. A command and readings go in, servo pulses and a status come out.
///
/// oscillators -> bend of each joint -> servo angles by the inverse volume map -> pressure supervisor -> slew, clamp.
/// It is made of + - * / sqrt and sincos of trig.hpp alone: without contraction it has the same bits on every machine.
#pragma once

#include "posture.hpp"
#include "safety.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Servo angle for a bend toward the side of a circuit: a polynomial, lowest power first.
inline constexpr int map_terms = 6;
template <class T>
struct PumpMap {
    T term[map_terms];
};
template <class T>
T servo_angle(const PumpMap<T>& map, T bend) {
    T angle = map.term[map_terms - 1];
    for (int k = map_terms - 2; k >= 0; --k) angle = angle * bend + map.term[k];
    return angle;
}

/// What the controller knows of one joint.
template <class T>
struct JointModel {
    T reach;                                // rad: largest bend to either side that its pumps are asked for
    T amplitude;                            // rad: largest amplitude of a command
    T bend_range;                           // rad: of the bend sensor, to either side
    T bend_step;                            // rad: largest change of its reading within a tick
    T safe_static, safe_rate, safe_square;  // 1/rad, s/rad, s^2/rad: largest pressure over the soft limit's room, per
                                            // amplitude, by powers of the frequency in Hz
};

template <class T>
struct Controller {
    int joints;
    T tick;  // s
    Network<T> network;
    Smoothing<T> smoothing;
    PostureModel<T> posture;
    JointModel<T> joint[most_joints];
    PumpMap<T> map[most_circuits];
    SupervisorModel<T> circuit[most_circuits];
    T pressure_soft, pressure_hard, pressure_low, pressure_high, pressure_step;  // Pa
    T current_low, current_high;                                                 // A
    T rate_high, acceleration_high;                                              // rad/s, m/s^2
    T voltage_rated, voltage_low, voltage_least, voltage_most;                   // V
    T frequency_most;                                                            // Hz
    T fin_most;                                                                  // rad
    int timeout;                                                                 // ticks
    T pulse_center, pulse_per_rad, pulse_least, pulse_most;                      // s, s/rad
    T slew;                                                                      // rad per tick
};

template <class T>
struct Readings {
    T bend[most_joints];         // rad
    T pressure[most_circuits];   // Pa, at the cylinder
    T current[most_circuits];    // A
    T rate[3], acceleration[3];  // rad/s, m/s^2
    T voltage;                   // V of the battery
};

template <class T>
struct Command {
    T frequency;               // Hz
    T amplitude[most_joints];  // rad
    T phase[most_joints];      // rad, lag behind the first joint's oscillator
    T bias[most_joints];       // rad
    T fin[2];                  // rad of the pectoral fins
    bool fresh;                // came since the last tick
    bool armed;
};

/// A command of which every value can be used.
template <class T>
struct Wish {
    T frequency, amplitude[most_joints], phase[most_joints], bias[most_joints], fin[2];
};

template <class T>
struct ControllerState {
    Wish<T> wish;
    int age;  // ticks since the last command
    bool armed;
    Follower<T> frequency, amplitude[most_joints], phase[most_joints], bias[most_joints], fin[2];
    Follower<T> more[most_joints], aside[most_joints];  // corrections of amplitude and bias
    Oscillator<T> oscillator[most_circuits];            // of each circuit; the two of a joint in antiphase
    PostureState<T> posture[most_joints];
    SupervisorState<T> circuit[most_circuits];
    Governor<T> governor[most_joints];
    Health<T> bend[most_joints], pressure[most_circuits], current[most_circuits], imu[6], voltage;
    T supply;                  // V believed
    T bend_sent[most_joints];  // rad: bends that the pumps were last sent to
    T sent[most_servos];       // rad: last angles sent
};

template <class T>
struct ControllerOutput {
    T pulse[most_servos];       // s: the circuits', then the two pectoral fins'
    T target[most_servos];      // rad: the same as angles
    T set[most_joints];         // rad: bend that is asked of each joint now, without correction
    T believed[most_circuits];  // Pa: pressure that the supervisor goes by
    Status status;
};

template <class T>
struct ControllerStep {
    ControllerState<T> state;
    ControllerOutput<T> output;
};

/// Everything at rest, the pumps at neutral.
template <class T>
ControllerState<T> init(const Controller<T>& model) {
    ControllerState<T> state{};
    state.age = model.timeout + 1;
    state.supply = model.voltage_rated;
    for (int j = 0; j < most_joints; ++j) state.governor[j].ceiling = model.joint[j].reach;
    for (int c = 0; c < most_circuits; ++c) {
        state.oscillator[c] = c % 2 == 0 ? Oscillator<T>{T(0), T(-1)} : Oscillator<T>{T(0), T(1)};
        state.circuit[c].before = state.circuit[c].pressure = model.circuit[c].fill;
    }
    return state;
}

/// Take a value of a command within its bounds; one that is no number leaves the last good one.
template <class T>
void take(T& kept, T value, T low, T high, Status& status) {
    if (is_finite(value)) kept = clamp(value, low, high);
    if (!(low <= value && value <= high)) status.tell(Condition::bad_command);
}

/// Amplitude at which the model's pressure surely stays below the soft limit: for a beat that no pressure was seen of.
template <class T>
T safe_amplitude(const JointModel<T>& joint, T frequency) {
    return T(1) / (joint.safe_static + frequency * (joint.safe_rate + frequency * joint.safe_square));
}

template <class T>
void take_command(const Controller<T>& model, ControllerState<T>& state, const Command<T>& command, Status& status) {
    const T turn = T(2 * pi);
    state.age = command.fresh ? 0 : state.age <= model.timeout ? state.age + 1 : state.age;
    if (command.fresh) {
        Wish<T>& wish = state.wish;
        take(wish.frequency, command.frequency, T(0), model.frequency_most, status);
        for (int j = 0; j < model.joints; ++j) {
            take(wish.amplitude[j], command.amplitude[j], T(0), model.joint[j].amplitude, status);
            take(wish.phase[j], command.phase[j], -turn, turn, status);
            take(wish.bias[j], command.bias[j], -model.joint[j].amplitude, model.joint[j].amplitude, status);
        }
        for (int k = 0; k < 2; ++k) take(wish.fin[k], command.fin[k], -model.fin_most, model.fin_most, status);
        for (int j = 0; j < model.joints; ++j)
            expect(state.governor[j], wish.frequency, safe_amplitude(model.joint[j], wish.frequency));
        // Arming anew, not staying armed, gives a stopped circuit back.
        if (command.armed && !state.armed)
            for (int c = 0; c < 2 * model.joints; ++c) state.circuit[c].stopped = false;
        state.armed = command.armed;
    }
    if (state.age > model.timeout) status.tell(Condition::timeout);
    if (!state.armed) status.tell(Condition::disarmed);
}

/// Whether a joint has a circuit without a pressure reading.
template <class T>
bool blind(const ControllerState<T>& state, int j) {
    return state.pressure[2 * j].faulty || state.pressure[2 * j + 1].faulty;
}

/// Let everything that a command sets follow it, and go on by one tick with the oscillators. Returns the low-pass that
/// belongs to the beat's frequency.
template <class T>
LowPass<T> generate(const Controller<T>& model, ControllerState<T>& state, bool active) {
    const Wish<T>& wish = state.wish;
    state.frequency = follow(model.smoothing, state.frequency, wish.frequency);
    const T turns = state.frequency.value * model.tick;
    const SinCos<T> turn = sincos(T(2 * pi) * state.frequency.value * model.tick);
    const Oscillator<T> reference = state.oscillator[0];
    for (int j = 0; j < model.joints; ++j) {
        state.amplitude[j] = follow(model.smoothing, state.amplitude[j], active ? wish.amplitude[j] : T(0));
        const T bias =
            blind(state, j) ? clamp(wish.bias[j], -abs(state.bias[j].value), abs(state.bias[j].value)) : wish.bias[j];
        state.bias[j] = follow(model.smoothing, state.bias[j], active ? bias : T(0));
        state.phase[j] = follow(model.smoothing, state.phase[j], wish.phase[j]);
        Oscillator<T>&left = state.oscillator[2 * j], &right = state.oscillator[2 * j + 1];
        if (j > 0) left = couple(model.network, left, reference, sincos(state.phase[j].value));
        right = couple(model.network, right, left, {T(0), T(-1)});
        left = oscillate(model.network, left, turn);
        right = oscillate(model.network, right, turn);
    }
    for (int k = 0; k < 2; ++k) state.fin[k] = follow(model.smoothing, state.fin[k], active ? wish.fin[k] : T(0));
    return low_pass(model.posture, max(turns, T(1e-4)), turn);
}

/// Whether a circuit's servo moves, so that its joint's sensors must show it.
template <class T>
bool moves(const Controller<T>& model, const SupervisorState<T>& circuit) {
    return T(0.2) * model.tick < abs(circuit.change);
}

/// Currents, IMU and battery: they steer nothing but the voltage, which the servos' speed depends on.
template <class T>
void read_robot(const Controller<T>& model, ControllerState<T>& state, const Readings<T>& readings, Status& status) {
    bool moving = false;
    for (int c = 0; c < 2 * model.joints; ++c) moving = moving || moves(model, state.circuit[c]);
    const auto plain = [&](Health<T>& health, T reading, T low, T high, T part) {
        return judge({low, high, part * (high - low), repeats_slow}, health, reading, health.last, moving).usable;
    };
    for (int c = 0; c < 2 * model.joints; ++c)
        if (!plain(state.current[c], readings.current[c], model.current_low, model.current_high, T(0.24)))
            status.tell(Condition::current_fault, c);
    for (int k = 0; k < 6; ++k) {
        const T most = k < 3 ? model.rate_high : model.acceleration_high;
        const T reading = k < 3 ? readings.rate[k] : readings.acceleration[k - 3];
        if (!plain(state.imu[k], reading, -most, most, T(0.2))) status.tell(Condition::imu_fault);
    }
    const bool first = !state.voltage.seen;
    const bool voltage = plain(state.voltage, readings.voltage, model.voltage_least, model.voltage_most, T(0.2));
    if (voltage) state.supply += (first ? T(1) : T(0.1)) * (readings.voltage - state.supply);
    if (!voltage) status.tell(Condition::battery_fault);
    if (state.voltage.seen && state.supply < model.voltage_low) status.tell(Condition::low_voltage);
}

/// Take in the pressure of a circuit, and stop it where that has passed the hard limit.
template <class T>
void read_pressure(const Controller<T>& model, ControllerState<T>& state, int c, T reading, Status& status) {
    const SupervisorModel<T>& supervisor = model.circuit[c];
    SupervisorState<T>& circuit = state.circuit[c];
    const bool moving = moves(model, circuit);
    const Verdict<T> verdict = judge({model.pressure_low, model.pressure_high, model.pressure_step, repeats_fast},
                                     state.pressure[c], reading, state.pressure[c].last, moving);
    Governor<T>& governor = state.governor[c / 2];
    if (verdict.usable) {
        governor.peak = max(governor.peak, median(circuit.before, circuit.pressure, reading));
        // Two in a row, of a sensor in good standing: spikes stop nothing.
        if (state.pressure[c].bucket == 0 && model.pressure_hard < min(circuit.pressure, reading))
            circuit.stopped = true;
        circuit.before = circuit.pressure;
        circuit.pressure = reading;
    } else {
        status.tell(Condition::pressure_fault, c);
        circuit.pressure = min(circuit.pressure, circuit.before);  // the one before may have been the first of a spike
    }
    governor.doubt = governor.doubt || !verdict.usable || T(1) < T(state.pressure[c].repeats);
    if (state.pressure[c].faulty) {
        status.tell(Condition::blind, c);
        circuit.before = circuit.pressure = supervisor.fill;
        governor.ceiling =
            min(governor.ceiling, max(governor.proven, safe_amplitude(model.joint[c / 2], state.wish.frequency)));
    }
    if (circuit.stopped) status.tell(Condition::hard_stop, c);
}

/// Amplitude that the commands and the corrections ask of a joint, whatever its pressures allow.
template <class T>
T asked_amplitude(const ControllerState<T>& state, int j) {
    return max(T(0), state.amplitude[j].value + state.more[j].value);
}

/// One tick of a joint's posture control; at the end of its beat the PID sets the corrections anew.
template <class T>
void hold_posture(const Controller<T>& model, ControllerState<T>& state, int j, T reading, bool ended,
                  const LowPass<T>& filter, Status& status) {
    PostureState<T>& posture = state.posture[j];
    const JointModel<T>& joint = model.joint[j];
    const T set = state.bias[j].value + state.amplitude[j].value * state.oscillator[2 * j].x;
    const bool moving = moves(model, state.circuit[2 * j]);
    const Verdict<T> verdict = judge({-joint.bend_range, joint.bend_range, joint.bend_step, repeats_fast},
                                     state.bend[j], reading, state.bend[j].last, moving);
    look(posture.wanted, filter.weight, set);
    if (verdict.usable) look(posture.measured, filter.weight, reading);
    ++posture.ticks;
    posture.missing += !verdict.usable;
    if (!verdict.usable) status.tell(Condition::bend_fault, j);
    if (ended) {
        posture.set = close_beat(posture.wanted, filter.gain);
        posture.seen = close_beat(posture.measured, filter.gain);
        const bool stopped = state.circuit[2 * j].stopped || state.circuit[2 * j + 1].stopped;
        const T sent = min(posture.set.amplitude, state.governor[j].lid);
        const bool dull =
            !stopped && model.posture.least < sent && posture.seen.amplitude < model.posture.moving * sent;
        posture.dull = !dull ? 0 : posture.dull < 2 ? posture.dull + 1 : 2;
        const bool heard = !dull && !stopped && T(posture.missing) <= model.posture.missing * T(posture.ticks);
        const bool held = T(posture.limited) > model.posture.limited * T(posture.ticks);
        if (heard && state.armed && !blind(state, j)) {
            posture.amplitude = correct(model.posture, posture.amplitude,
                                        posture.set.amplitude - posture.seen.amplitude, held, joint.reach);
            posture.bias =
                correct(model.posture, posture.bias, posture.set.bias - posture.seen.bias, held, joint.reach);
        }
        Governor<T>& governor = state.governor[j];
        const T amplitude = min(asked_amplitude(state, j), governor.lid);
        govern(governor, amplitude, max(state.frequency.value, state.wish.frequency), model.circuit[2 * j].fill,
               model.pressure_soft);
        posture.ticks = posture.missing = posture.limited = 0;
    }
    // Two beats without a swing: the sensor lives, but does not follow.
    if (posture.dull > 1) status.tell(Condition::bend_fault, j);
    if (state.bend[j].faulty || posture.dull > 1) status.tell(Condition::open_loop, j);
    state.more[j] = follow(model.smoothing, state.more[j], posture.amplitude.output);
    state.aside[j] = follow(model.smoothing, state.aside[j], posture.bias.output);
}

/// Slew and clamp: the last that happens to every servo's angle. One that is no number leaves the last good one.
template <class T>
void send(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int servo, T angle) {
    const T last = state.sent[servo], wanted = is_finite(angle) ? angle : last;
    const T slewed = clamp(wanted, last - model.slew, last + model.slew);
    const T low = (model.pulse_least - model.pulse_center) / model.pulse_per_rad;
    const T high = (model.pulse_most - model.pulse_center) / model.pulse_per_rad;
    const T kept = clamp(slewed, low, high);
    if (slewed != wanted) output.status.tell(Condition::slew_limit, servo);
    if (kept != slewed) output.status.tell(Condition::pulse_limit, servo);
    state.sent[servo] = output.target[servo] = kept;
    output.pulse[servo] = clamp(model.pulse_center + model.pulse_per_rad * kept, model.pulse_least, model.pulse_most);
}

/// Bend that is asked of a joint, within what its pressures allow and its pumps reach: half the difference of what its
/// two oscillators put out.
template <class T>
T asked_bend(const Controller<T>& model, ControllerState<T>& state, int j, Status& status) {
    Governor<T>& governor = state.governor[j];
    governor.lid += model.smoothing.rate * (governor.ceiling - governor.lid);
    const T asked = asked_amplitude(state, j), amplitude = min(asked, governor.lid);
    for (int side = 0; side < 2 && amplitude < asked; ++side) status.tell(Condition::pressure_limit, 2 * j + side);
    const T swing = T(0.5) * (state.oscillator[2 * j].x - state.oscillator[2 * j + 1].x);
    const T wanted = state.bias[j].value + state.aside[j].value + amplitude * swing;
    const T reach = model.joint[j].reach, bend = clamp(wanted, -reach, reach);
    if (bend != wanted) status.tell(Condition::amplitude_limit, j);
    // What was held back catches up little faster than the beat goes: no jump, no surge of pressure.
    const T fastest = amplitude * T(2 * pi) * state.frequency.value * model.tick + abs(state.bias[j].change);
    const T most = T(1.25) * fastest + T(0.02) * reach, last = state.bend_sent[j];
    return clamp(bend, last - most, last + most);
}

/// Send a circuit's servo to an angle, and say where it cannot follow at a part of its voltage. Torque-speed line: no
/// load leaves the whole speed, the stall pressure leaves none.
template <class T>
void drive_circuit(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int c, T angle,
                   T supply) {
    const SupervisorModel<T>& supervisor = model.circuit[c];
    SupervisorState<T>& circuit = state.circuit[c];
    const T last = state.sent[c];
    send(model, state, output, c, angle);
    circuit.change = output.target[c] - last;
    const T free = supply - max(T(0), circuit.pressure) / supervisor.stall;
    if (clamp(free, T(0.1), T(1)) * supervisor.speed * model.tick < abs(circuit.change))
        output.status.tell(Condition::speed_limit, c);
    output.believed[c] = circuit.pressure;
}

/// One joint: from the bend that is asked to the angles of its two servos.
///
/// Where one circuit is held back, both stop at the same bend. Were each held back by itself, the side that draws would
/// outrun the side that pushes, and the oil between them would be lost beat by beat.
template <class T>
void drive_joint(const Controller<T>& model, ControllerState<T>& state, ControllerOutput<T>& output, int j) {
    const T asked = asked_bend(model, state, j, output.status);
    const bool stopped = state.circuit[2 * j].stopped || state.circuit[2 * j + 1].stopped;
    const T supply = min(T(1), state.supply / model.voltage_rated);
    T angle[2], most[2];
    const auto bend_to = [&](T bend) {
        for (int side = 0; side < 2; ++side)
            angle[side] = stopped ? T(0) : servo_angle(model.map[2 * j + side], side == 0 ? bend : -bend);
    };
    bend_to(asked);
    bool pressed = false, slow = false;
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        most[side] = furthest(model.circuit[c], state.sent[c], state.circuit[c].pressure, model.pressure_soft,
                              model.pressure_hard);
        if (most[side] < angle[side]) output.status.tell(Condition::pressure_limit, c), pressed = true;
    }
    if (pressed)
        bend_to(state.bend_sent[j]);
    else
        state.bend_sent[j] = asked;
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        const T sent = min(angle[side], most[side]);
        drive_circuit(model, state, output, c, sent, supply);
        slow = slow || output.status.has(Condition::speed_limit, c) || output.target[c] != sent;
    }
    const bool governed = output.status.has(Condition::pressure_limit, 2 * j);
    if (pressed || slow || governed) ++state.posture[j].limited;
}

/// One tick of the controller, its state in place.
template <class T>
ControllerOutput<T> advance(const Controller<T>& model, ControllerState<T>& state, const Readings<T>& readings,
                            const Command<T>& command) {
    ControllerOutput<T> output{};
    Status& status = output.status;
    take_command(model, state, command, status);
    Oscillator<T> before[most_joints];
    for (int j = 0; j < model.joints; ++j) before[j] = state.oscillator[2 * j];
    const LowPass<T> filter = generate(model, state, state.armed && state.age <= model.timeout);
    read_robot(model, state, readings, status);
    for (int c = 0; c < 2 * model.joints; ++c) read_pressure(model, state, c, readings.pressure[c], status);
    for (int j = 0; j < model.joints; ++j) {
        const bool ended = beat_ends(before[j], state.oscillator[2 * j]);
        hold_posture(model, state, j, readings.bend[j], ended, filter, status);
        output.set[j] = state.bias[j].value + state.amplitude[j].value * state.oscillator[2 * j].x;
        drive_joint(model, state, output, j);
    }
    for (int k = 0; k < 2; ++k) send(model, state, output, 2 * model.joints + k, state.fin[k].value);
    return output;
}

/// The same as a function of the state before.
template <class T>
ControllerStep<T> step(const Controller<T>& model, const ControllerState<T>& before, const Readings<T>& readings,
                       const Command<T>& command) {
    ControllerStep<T> next{before, {}};
    next.output = advance(model, next.state, readings, command);
    return next;
}

/// Call visit(name, index, field) for every number of the model: the one list that Python and the firmware fill it by.
/// How many joints there are is set before.
template <class T, class Visit>
void visit_fields(Controller<T>& m, const Visit& visit) {
    visit("tick", 0, m.tick);
    visit("relax", 0, m.network.relax), visit("couple", 0, m.network.couple);
    visit("smoothing_rate", 0, m.smoothing.rate), visit("smoothing_decay", 0, m.smoothing.decay);
    visit("proportional", 0, m.posture.proportional), visit("integral", 0, m.posture.integral);
    visit("derivative", 0, m.posture.derivative), visit("peak_smoothing", 0, m.posture.smoothing);
    visit("missing", 0, m.posture.missing), visit("limited", 0, m.posture.limited);
    visit("moving", 0, m.posture.moving), visit("least", 0, m.posture.least);
    for (int j = 0; j < m.joints; ++j) {
        JointModel<T>& joint = m.joint[j];
        visit("reach", j, joint.reach), visit("amplitude", j, joint.amplitude);
        visit("bend_range", j, joint.bend_range), visit("bend_step", j, joint.bend_step);
        visit("safe_static", j, joint.safe_static), visit("safe_rate", j, joint.safe_rate);
        visit("safe_square", j, joint.safe_square);
    }
    for (int c = 0; c < 2 * m.joints; ++c) {
        for (int k = 0; k < map_terms; ++k) visit("map", map_terms * c + k, m.map[c].term[k]);
        visit("servo_speed", c, m.circuit[c].speed), visit("servo_stall", c, m.circuit[c].stall);
        visit("fill", c, m.circuit[c].fill), visit("give", c, m.circuit[c].give);
    }
    visit("pressure_soft", 0, m.pressure_soft), visit("pressure_hard", 0, m.pressure_hard);
    visit("pressure_low", 0, m.pressure_low), visit("pressure_high", 0, m.pressure_high);
    visit("pressure_step", 0, m.pressure_step);
    visit("current_low", 0, m.current_low), visit("current_high", 0, m.current_high);
    visit("rate_high", 0, m.rate_high), visit("acceleration_high", 0, m.acceleration_high);
    visit("voltage_rated", 0, m.voltage_rated), visit("voltage_low", 0, m.voltage_low);
    visit("voltage_least", 0, m.voltage_least), visit("voltage_most", 0, m.voltage_most);
    visit("frequency_most", 0, m.frequency_most), visit("fin_most", 0, m.fin_most), visit("timeout", 0, m.timeout);
    visit("pulse_center", 0, m.pulse_center), visit("pulse_per_rad", 0, m.pulse_per_rad);
    visit("pulse_least", 0, m.pulse_least), visit("pulse_most", 0, m.pulse_most), visit("slew", 0, m.slew);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
