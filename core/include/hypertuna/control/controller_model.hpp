/// Types of the controller: model, input, state and output.
#pragma once

#include "hypertuna/control/flow.hpp"
#include "hypertuna/control/posture.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Number of terms of a pump map, the servo angle for a bend toward the circuit's side: three parabolas that join, the
/// middle one through zero. Beyond the middle one, one side's pressure is at its lowest and the other's rises faster.
inline constexpr int map_terms = 6;
template <class T>
struct PumpMap {
    T low, high;        // rad: the middle parabola's range of bends
    T term[map_terms];  // coefficients of the bend and its square: of the middle parabola, that below it, that above it
};
template <class T>
T servo_angle(const PumpMap<T>& map, T bend) {
    const T middle = clamp(bend, map.low, map.high), past = bend - middle;
    const T angle = (map.term[0] + map.term[1] * middle) * middle;
    if (past == T(0)) return angle;
    const T* term = past < T(0) ? map.term + 2 : map.term + 4;
    return angle + (term[0] + term[1] * past) * past;
}

/// What the controller knows of one joint.
template <class T>
struct JointModel {
    T direct;     // servo turns per bend of a joint without oil, bend sensor and second servo: 1 on its axle; 0 for a
                  // joint with oil
    T reach;      // rad: largest bend to either side that its pumps are asked for
    T amplitude;  // rad: largest amplitude of a command
    T rate;       // rad/s: largest rate of the bend that the hammer of the displaced oil allows
    T sent_rate;  // rad/s: largest rate of the bend that the pumps are sent to; also limited by the oil that refills an
                  // emptied cylinder
    T bend_range;                           // rad: range of the bend sensor to either side
    T bend_step;                            // rad: largest change of the bend reading within a tick
    T safe_static, safe_rate, safe_square;  // polynomial in the frequency [Hz]: largest pressure above the fill per
                                            // amplitude, over the soft limit above the fill
};

template <class T>
struct Controller {
    int joints;
    T tick;  // s
    Network<T> network;
    Smoothing<T> smoothing;
    Smoothing<T> servo;  // position loop of the pumps' servos
    T viscosity_min,
        viscosity_own;  // viscosity of hot oil, and of the oil at its own temperature, relative to the thickest
    PostureModel<T> posture;
    JointModel<T> joint[max_joints];
    PumpMap<T> map[max_circuits];
    SupervisorModel<T> circuit[max_circuits];
    T pressure_work, pressure_soft, pressure_hard, pressure_low, pressure_high, pressure_step;  // Pa
    T current_low, current_high;                                                                // A
    T rate_high, acceleration_high;                                                             // rad/s, m/s^2
    T voltage_rated, voltage_low, voltage_min, voltage_max;                                     // V
    T frequency_max;                                                                            // Hz
    T fin_max;                                                                                  // rad
    int timeout;                                                                                // ticks
    T pulse_center, pulse_per_rad, pulse_min, pulse_max;                                        // s, s/rad
    T slew;                                                                                     // rad/s
};

template <class T>
struct Readings {
    T bend[max_joints];          // rad
    T pressure[max_circuits];    // Pa, at the cylinder
    T current[max_circuits];     // A
    T rate[3], acceleration[3];  // rad/s, m/s^2
    T voltage;                   // V of the battery
};

template <class T>
struct Command {
    T frequency;              // Hz
    T amplitude[max_joints];  // rad
    T phase[max_joints];      // rad, lag behind the first joint's oscillator
    T bias[max_joints];       // rad
    T fin[2];                 // rad of the pectoral fins
    bool fresh;               // came since the last tick
    bool armed;
};

/// A command of which every value can be used.
template <class T>
struct Setpoint {
    T frequency, amplitude[max_joints], phase[max_joints], bias[max_joints], fin[2];
};

template <class T>
struct ControllerState {
    Setpoint<T> target;
    int age;  // ticks since the last command
    bool armed;
    Follower<T> frequency, amplitude[max_joints], phase[max_joints], bias[max_joints], fin[2];
    Follower<T> more[max_joints], aside[max_joints];  // corrections: of the amplitude, relative; of the bias, rad
    Oscillator<T> oscillator[max_joints];  // oscillator of each joint's left circuit; the right one is in antiphase
    PostureState<T> posture[max_joints];
    SupervisorState<T> circuit[max_circuits];
    Governor<T> governor[max_joints];
    Health<T> bend[max_joints], pressure[max_circuits], current[max_circuits], imu[6], voltage;
    T supply;                // V, mean of the last valid readings
    Viscosity<T> viscosity;  // viscosity of the oil
    T swing;  // s: s: amplitude per rate of a bend at this frequency; less where the oil is thin, at the frequency and
              // with what the oil leaves
    T bend_sent[max_joints];  // rad: bends that the pumps were last sent to
    T slip[max_joints];       // rad: mean of the bend read minus the bend sent
    int checked;              // joint whose pressures were checked last
    T sent[max_servos];       // rad: last angles sent
};

template <class T>
struct ControllerOutput {
    T pulse[max_servos];       // s: s: pulses of the circuits' servos, then of the two pectoral fins pectoral fins'
    T target[max_servos];      // rad: angles of the same servos
    T set[max_joints];         // rad: commanded bend of each joint now, without correction
    T pressure[max_circuits];  // Pa: valid pressure that the supervisor uses
    Status status;
};

template <class T>
struct ControllerStep {
    ControllerState<T> state;
    ControllerOutput<T> output;
};

/// Whether a servo turns a joint on its axle or by tendons: the servo of its first circuit. Such a joint has no second
/// one.
template <class T>
bool direct(const Controller<T>& model, int joint) {
    return model.joint[joint].direct != T(0);
}

/// Set a state of zeros to rest, with the pumps at neutral; in place, because a board's stack is small.
template <class T>
void begin(const Controller<T>& model, ControllerState<T>& state) {
    state.age = model.timeout + 1;
    state.supply = model.voltage_rated;
    state.viscosity.value = state.viscosity.largest = T(1);
    for (int j = 0; j < max_joints; ++j) {
        state.oscillator[j] = at_rest<T>();
        state.governor[j].ceiling = model.joint[j].reach;
    }
    for (int c = 0; c < max_circuits; ++c) {
        SupervisorState<T>& circuit = state.circuit[c];
        circuit.before = circuit.pressure = circuit.crest = circuit.trough = model.circuit[c].fill;
    }
}
template <class T>
ControllerState<T> init(const Controller<T>& model) {
    ControllerState<T> state{};
    begin(model, state);
    return state;
}

/// Call visit(name, index, field) for every number of the model: Python and the firmware fill the model by this list.
/// The number of joints must be set before.
template <class T, class Visit>
void visit_fields(Controller<T>& m, const Visit& visit) {
    visit("tick", 0, m.tick);
    visit("relax", 0, m.network.relax), visit("couple", 0, m.network.couple);
    visit("smoothing_rate", 0, m.smoothing.rate), visit("smoothing_decay", 0, m.smoothing.decay);
    visit("servo_loop", 0, m.servo.rate), visit("servo_decay", 0, m.servo.decay);
    visit("viscosity_min", 0, m.viscosity_min), visit("viscosity_own", 0, m.viscosity_own);
    visit("learning", 0, m.posture.learning);
    visit("missing", 0, m.posture.missing), visit("limited", 0, m.posture.limited);
    visit("moving", 0, m.posture.moving), visit("amplitude_min", 0, m.posture.amplitude_min);
    for (int j = 0; j < m.joints; ++j) {
        JointModel<T>& joint = m.joint[j];
        visit("direct", j, joint.direct);
        visit("reach", j, joint.reach), visit("amplitude", j, joint.amplitude);
        visit("rate", j, joint.rate), visit("sent_rate", j, joint.sent_rate);
        visit("bend_range", j, joint.bend_range), visit("bend_step", j, joint.bend_step);
        visit("safe_static", j, joint.safe_static), visit("safe_rate", j, joint.safe_rate);
        visit("safe_square", j, joint.safe_square);
    }
    for (int c = 0; c < 2 * m.joints; ++c) {
        visit("map_low", c, m.map[c].low), visit("map_high", c, m.map[c].high);
        for (int k = 0; k < map_terms; ++k) visit("map", map_terms * c + k, m.map[c].term[k]);
        visit("servo_speed", c, m.circuit[c].speed), visit("servo_stall", c, m.circuit[c].stall);
        visit("fill", c, m.circuit[c].fill), visit("compliance", c, m.circuit[c].compliance);
        visit("line", c, m.circuit[c].line), visit("hammer", c, m.circuit[c].hammer);
        visit("draw", c, m.circuit[c].draw), visit("smooth", c, m.circuit[c].smooth);
        visit("spare", c, m.circuit[c].spare);
        for (int k = 0; k < hold_terms; ++k) visit("hold", hold_terms * c + k, m.circuit[c].hold[k]);
    }
    visit("pressure_work", 0, m.pressure_work);
    visit("pressure_soft", 0, m.pressure_soft), visit("pressure_hard", 0, m.pressure_hard);
    visit("pressure_low", 0, m.pressure_low), visit("pressure_high", 0, m.pressure_high);
    visit("pressure_step", 0, m.pressure_step);
    visit("current_low", 0, m.current_low), visit("current_high", 0, m.current_high);
    visit("rate_high", 0, m.rate_high), visit("acceleration_high", 0, m.acceleration_high);
    visit("voltage_rated", 0, m.voltage_rated), visit("voltage_low", 0, m.voltage_low);
    visit("voltage_min", 0, m.voltage_min), visit("voltage_max", 0, m.voltage_max);
    visit("frequency_max", 0, m.frequency_max), visit("fin_max", 0, m.fin_max), visit("timeout", 0, m.timeout);
    visit("pulse_center", 0, m.pulse_center), visit("pulse_per_rad", 0, m.pulse_per_rad);
    visit("pulse_min", 0, m.pulse_min), visit("pulse_max", 0, m.pulse_max), visit("slew", 0, m.slew);
}

/// Whether the limits of pressures and pulses are in ascending order.
template <class T>
bool consistent(const Controller<T>& m) {
    return m.pressure_work < m.pressure_soft && m.pressure_soft < m.pressure_hard && m.pulse_min < m.pulse_center &&
           m.pulse_center < m.pulse_max;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
