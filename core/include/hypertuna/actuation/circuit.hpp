/// Circuit: servo, cylinder, oil line and the drive units of one side of a joint, as a sealed volume of oil.
///
/// The state holds the oil that has passed the line, and both pressures follow from volumes in closed form. So the oil
/// is conserved to the last bit, however long the run and whatever the time step. Pressures are above atmosphere. Air
/// travels with the oil as bubbles of constant share; it is isothermal and never dissolves.
#pragma once

#include "hypertuna/actuation/muscle.hpp"
#include "hypertuna/actuation/pump.hpp"
#include "hypertuna/actuation/servo.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr double atmosphere = 101325.0;  // Pa

template <class S>
struct Circuit {
    Pump<S> pump;
    Servo<S> servo;
    S resistance;    // Pa s/m^3 of the line, laminar
    S loss;          // Pa s^2/m^6: entry and exit, quadratic in the flow
    S inertance;     // Pa s^2/m^3 of the oil in the line
    S oil_pump;      // m^3 of oil in the cylinder while `passed` is 0, measured at atmosphere and without air
    S oil_unit;      // m^3 of oil in line and units while `passed` is 0, measured likewise
    S unit_rest;     // m^3 that line and units hold with the joint straight and no pressure
    S compliance;    // m^3/Pa, elastic compliance of hoses, braids and fittings on the units' side
    S bulk_modulus;  // Pa of the oil without air
    S air;           // m^3 of air at atmosphere per m^3 of oil
    S cavitation;    // Pa, the lowest pressure, at which a vapor cavity opens
};

template <class S>
struct CircuitState {
    S angle;   // rad of the servo from neutral, positive pushes oil out
    S rate;    // rad/s
    S flow;    // m^3/s toward the units
    S passed;  // m^3 of oil that has passed from the cylinder into the units

    template <class A>
    friend HYPERTUNA_INLINE CircuitState operator*(const A& a, const CircuitState& b) {
        return {a * b.angle, a * b.rate, a * b.flow, a * b.passed};
    }
    friend HYPERTUNA_INLINE CircuitState operator+(const CircuitState& a, const CircuitState& b) {
        return {a.angle + b.angle, a.rate + b.rate, a.flow + b.flow, a.passed + b.passed};
    }
};

/// Pressure of oil in a space, and the vapor cavity beside it.
template <class S>
struct OilPressure {
    S pressure;  // Pa
    S cavity;    // m^3
};

/// Pressure of oil in a space, with its first and second derivative with respect to the space's volume.
template <class S>
struct OilCurve {
    OilPressure<S> at;
    S slope;   // Pa/m^3
    S change;  // Pa/m^6
};

template <class S>
struct CircuitOutput {
    OilPressure<S> pump, unit;
    S load;               // N m, moment of the oil's pressure on the servo
    S torque;             // N m of the motor
    ServoPower<S> power;  // W
    S line;               // W lost along the line
};

template <class S>
struct CircuitRate {
    CircuitState<S> rate;
    CircuitOutput<S> output;
};

/// Volume of oil with its air under a pressure, m^3.
template <class S>
HYPERTUNA_INLINE S oil_volume(const Circuit<S>& circuit, const S& oil, const S& pressure) {
    const S p0 = S(base_t<S>(atmosphere));
    return oil * (S(1) - pressure / circuit.bulk_modulus + circuit.air * p0 / (p0 + pressure));
}

/// Volume that oil with its air gains per lost pressure, m^3/Pa.
template <class S>
HYPERTUNA_INLINE S oil_compliance(const Circuit<S>& circuit, const S& oil, const S& pressure) {
    const S p0 = S(base_t<S>(atmosphere)), p = p0 + pressure;
    return oil * (S(1) / circuit.bulk_modulus + circuit.air * p0 / (p * p));
}

/// Pressure at which the oil fills its space: oil_volume(P) = space + compliance P, a quadratic in the absolute
/// pressure whose larger root is the only positive one.
template <class S>
HYPERTUNA_INLINE OilCurve<S> oil_curve(const Circuit<S>& circuit, const S& oil, const S& space, const S& compliance) {
    const S p0 = S(base_t<S>(atmosphere));
    const S stiff = compliance + oil * (S(1) / circuit.bulk_modulus), gas = oil * circuit.air * p0;
    const S excess = oil + stiff * p0 - space, lowest = circuit.cavitation + p0;
    const S root = sqrt(excess * excess + S(4) * stiff * gas);
    const auto stretched = excess < S(0);  // choose the form of the root without cancellation
    const S absolute = select(stretched, S(2) * gas, root + excess) / select(stretched, root - excess, S(2) * stiff);
    const S inverse = S(1) / root, slope = -absolute * inverse, change = slope * (excess * inverse - S(1)) * inverse;
    const auto parted = absolute < lowest;
    if (!any(parted)) return {{absolute - p0, S(0)}, slope, change};
    const S cavity = max(S(0), stiff * lowest - excess - gas / lowest);
    return {{max(lowest, absolute) - p0, select(parted, cavity, S(0))},
            select(parted, S(0), slope),
            select(parted, S(0), change)};
}
template <class S>
HYPERTUNA_INLINE OilPressure<S> oil_pressure(const Circuit<S>& circuit, const S& oil, const S& space,
                                             const S& compliance) {
    return oil_curve(circuit, oil, space, compliance).at;
}

/// Pressure in the cylinder from which the piston pushed the volume `pushed` [m^3].
template <class S>
HYPERTUNA_INLINE OilPressure<S> pump_pressure(const Circuit<S>& circuit, const S& passed, const S& pushed) {
    return oil_pressure(circuit, circuit.oil_pump - passed, circuit.pump.chamber - pushed, S(0));
}
template <class S>
HYPERTUNA_INLINE OilPressure<S> pump_pressure(const Circuit<S>& circuit, const CircuitState<S>& state) {
    return pump_pressure(circuit, state.passed, displaced(circuit.pump, state.angle));
}
/// Pressure in the units; `unit_space` is what the joint's bend adds to their volume, m^3.
template <class S>
HYPERTUNA_INLINE OilCurve<S> unit_curve(const Circuit<S>& circuit, const CircuitState<S>& state, const S& unit_space) {
    return oil_curve(circuit, circuit.oil_unit + state.passed, circuit.unit_rest + unit_space, circuit.compliance);
}
template <class S>
HYPERTUNA_INLINE OilPressure<S> unit_pressure(const Circuit<S>& circuit, const CircuitState<S>& state,
                                              const S& unit_space) {
    return unit_curve(circuit, state, unit_space).at;
}

/// Oil in the muscles of a joint's two sides (0 and 1), in the form that section_load of joint.hpp takes; T is S or a
/// dual.
template <class S>
struct JointOil {
    const Circuit<S>* circuit;
    const CircuitState<S>* state;
    const S* rest;  // m^3, in the muscles of the straight, filled joint

    template <class T>
    HYPERTUNA_INLINE OilAt<T> at(int side, const T& volume) const {
        const S now = value(volume);
        const OilCurve<S> oil = unit_curve(circuit[side], state[side], now - rest[side]);
        return {oil.at.pressure + oil.slope * (volume - now), T(oil.slope), T(oil.change)};
    }
    /// Volume of a side's muscles at a pressure, which counts as cavitation's where it is lower.
    HYPERTUNA_INLINE S volume(int side, const S& pressure) const {
        const Circuit<S>& c = circuit[side];
        const S under = max(c.cavitation, pressure);
        return oil_volume(c, c.oil_unit + state[side].passed, under) - c.compliance * under - c.unit_rest + rest[side];
    }
};

/// Time derivative of a circuit's state, and its pressures, torques and powers.
template <class S>
HYPERTUNA_INLINE CircuitRate<S> circuit_rate(const Circuit<S>& circuit, const CircuitState<S>& state, const S& target,
                                             const S& supply, const S& unit_space) {
    const auto [at, slope] = travel(circuit.pump, state.angle);
    const S area = circuit.pump.area, pushed = area * (at - circuit.pump.start);
    const OilPressure<S> pump = pump_pressure(circuit, state.passed, pushed);
    const OilPressure<S> unit = unit_pressure(circuit, state, unit_space);
    const S load = pump.pressure * (area * slope);
    const ServoDrive<S> drive =
        servo_drive(circuit.servo, supply, load, target, state.angle, state.rate, sealing(circuit.pump, slope));
    const S drop = circuit.resistance * state.flow + circuit.loss * times_abs(state.flow);
    const S flow = (pump.pressure - unit.pressure - drop) / circuit.inertance;
    return {{state.rate, drive.acceleration, flow, state.flow},
            {pump, unit, load, drive.torque, servo_power(circuit.servo, drive, supply, load, state.rate),
             drop * state.flow}};
}

/// Upper bound of the circuit's rates with the joint held, 1/s, at a pressure: RK4 is stable for steps below 2.7 /
/// bound.
///
/// The largest of: the line's lag, the line's oscillation with the oil at both its ends, the servo's with the oil of
/// the cylinder, and the servo's own rate.
template <class S>
S circuit_stiffness(const Circuit<S>& circuit, const S& pressure, const S& flow) {
    const S pump = oil_compliance(circuit, circuit.oil_pump, pressure);
    const S unit = oil_compliance(circuit, circuit.oil_unit, pressure) + circuit.compliance;
    const S slope = displaced_slope(circuit.pump, S(0));
    Servo<S> servo = circuit.servo;
    servo.friction += sealing(circuit.pump, slope / circuit.pump.area);
    const S lag = (circuit.resistance + S(2) * circuit.loss * abs(flow)) / circuit.inertance;
    const S ring = sqrt((S(1) / pump + S(1) / unit) / circuit.inertance);
    const S bounce = slope / sqrt(pump * circuit.servo.inertia);
    return max(max(lag, ring), max(bounce, servo_rate(servo)));
}

/// Order of a circuit's numbers in a row from Python.
inline constexpr const char* circuit_columns[] = {HYPERTUNA_PUMP_COLUMNS,
                                                  HYPERTUNA_SERVO_COLUMNS,
                                                  "resistance",
                                                  "loss",
                                                  "inertance",
                                                  "oil_pump",
                                                  "oil_unit",
                                                  "unit_rest",
                                                  "compliance",
                                                  "bulk_modulus",
                                                  "air",
                                                  "cavitation"};
inline constexpr int circuit_column_count = sizeof(circuit_columns) / sizeof(circuit_columns[0]);

template <class S, class T>
Circuit<S> read_circuit(const T* row) {
    return read_row<Circuit<S>, S>(circuit_columns, row);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
