/// Energy of a circuit: the work that the servo draws is lost in servo and line, stored in rotor and oil, or done on
/// the units.
#include "check.hpp"
#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/swimming/stepping.hpp"

using namespace hypertuna;

/// A circuit of round numbers, filled to 50 kPa.
static Circuit<double> round_circuit(double air) {
    Circuit<double> c{};
    c.pump = {2.5e-4, 0.02, 0.05, pi / 2, 0, 8e-6, 10};
    c.pump.start = travel(c.pump, 0.0).travel;
    c.servo = {7, 8, 20, 0.3, 7.4, 7, 0.3, 0.009};
    c.resistance = 4e9, c.loss = 1e12, c.inertance = 1e7, c.compliance = 2e-12, c.bulk_modulus = 1.4e9, c.air = air;
    c.cavitation = -95e3, c.unit_rest = 6e-6;
    const double swollen = oil_volume(c, 1.0, 50e3);
    c.oil_pump = c.pump.chamber / swollen;
    c.oil_unit = (c.unit_rest + c.compliance * 50e3) / swollen;
    return c;
}

/// Work stored in the oil of a unit, -int P dv from 0, and its enthalpy: P v plus that work.
static double stored(const Circuit<double>& c, double pressure) {
    const double p0 = atmosphere, p = p0 + pressure;
    return pressure * pressure / (2 * c.bulk_modulus) + c.air * p0 * (std::log(p / p0) + p0 / p - 1);
}
static double enthalpy(const Circuit<double>& c, double pressure) {
    return pressure * oil_volume(c, 1.0, pressure) + stored(c, pressure);
}

/// Energies and powers at one instant.
struct Balance {
    double energy;    // J, stored in rotor, oil, line and compliances
    double in, out;   // W drawn by the servo; W lost or done on the units
    double swelling;  // W of swelling that the line leaves out: its flow is counted as oil without air
};
static Balance look(const Circuit<double>& c, const CircuitState<double>& at, double target, double space,
                    double rate) {
    const CircuitOutput<double> seen = circuit_rate(c, at, target, 7.4, space).output;
    const double P = seen.pump.pressure, Q = seen.unit.pressure;
    const double oil = (c.oil_pump - at.passed) * stored(c, P) + (c.oil_unit + at.passed) * stored(c, Q);
    const double kinetic = 0.5 * c.inertance * at.flow * at.flow + 0.5 * c.servo.inertia * at.rate * at.rate;
    const double cavities = P * seen.pump.cavity + Q * seen.unit.cavity;
    const ServoPower<double>& w = seen.power;
    const double line = at.flow * (c.resistance * at.flow + c.loss * times_abs(at.flow));
    CHECK_NEAR(seen.line, line, 1e-12 * line);
    return {oil + kinetic + 0.5 * c.compliance * Q * Q - cavities, w.total,
            w.idle + w.windings + w.gears + w.seals + w.braking + line + Q * rate,
            at.flow * (enthalpy(c, P) - enthalpy(c, Q) - (P - Q))};
}

/// A second of a hard beat, its targets held for ticks of 10 ms, while the units give and take 1 mL; Simpson's rule.
static void nothing_is_lost(double air, double max_swelling) {
    const Circuit<double> c = round_circuit(air);
    CircuitState<double> state{};
    const double h = 1e-5, turn = 2 * pi * 3, gives = 1e-6;
    const auto space = [&](double t) { return gives * std::sin(turn * t - 0.5) + gives * std::sin(0.5); };
    const auto rate = [&](double t) { return gives * turn * std::cos(turn * t - 0.5); };
    const double start = look(c, state, 0.0, space(0), rate(0)).energy;
    double in = 0, out = 0, swelling = 0, lowest = 0;
    for (int k = 0; k < 100000; ++k) {
        const double t = h * k, target = 0.5 * std::sin(turn * 0.01 * (k / 1000));
        const auto step = [&](const CircuitState<double>& at, double from, double length) {
            return runge_kutta_4(length, at, [&](int half, const CircuitState<double>& now) {
                return circuit_rate(c, now, target, 7.4, space(from + 0.5 * half * length)).rate;
            });
        };
        const Balance a = look(c, state, target, space(t), rate(t));
        const CircuitState<double> half = step(state, t, h / 2);
        state = step(state, t, h);
        const Balance m = look(c, half, target, space(t + h / 2), rate(t + h / 2));
        const Balance b = look(c, state, target, space(t + h), rate(t + h));
        in += h / 6 * (a.in + 4 * m.in + b.in);
        out += h / 6 * (a.out + 4 * m.out + b.out);
        swelling += h / 6 * (a.swelling + 4 * m.swelling + b.swelling);
        lowest = std::fmin(lowest, pump_pressure(c, state).pressure);
    }
    const double gained = look(c, state, 0.0, space(1), rate(1)).energy - start;
    CHECK(in > 5);
    CHECK(lowest < -80e3);  // the beat includes suction
    CHECK_NEAR(gained, in - out - swelling, 1e-6 * in);
    CHECK(std::fabs(swelling) < max_swelling * in);
}

int main() {
    nothing_is_lost(0.01, 0.01);
    nothing_is_lost(0.0, 1e-4);
    return failures();
}
