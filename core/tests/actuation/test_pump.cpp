/// Slider-crank, servo and circuit: numbers by hand, the volume balance, Poiseuille, the RC corner, step halving.
#include <limits>

#include "check.hpp"
#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/swimming/stepping.hpp"

using namespace hypertuna;

static constexpr double infinite = std::numeric_limits<double>::infinity();

/// A servo with numbers close to HyperTuna's.
static Servo<double> servo() { return {6.86, 7.5, 20.0, 0.3, 7.2, 7.0, 0.3, 0.009}; }

static Pump<double> pump() {
    Pump<double> p{2.5447e-4, 0.022, 0.050, pi / 2, 0.0, 7e-6, 0.0};
    p.start = travel(p, 0.0).travel;
    return p;
}

/// A circuit close to one of joint I: 8 cm of 3 mm line, oil of 0.117 Pa s, filled to 60 kPa.
static Circuit<double> circuit(double air = 0.01) {
    Circuit<double> c{pump(), servo(), 4.69e9, 0.0, 1.31e7, 0.0, 0.0, 8e-6, 2e-12, 1.4e9, air, -95e3};
    const double fill = 60e3, unit = oil_volume(c, 1.0, fill);
    c.oil_pump = c.pump.chamber / unit;
    c.oil_unit = (c.unit_rest + c.compliance * fill) / unit;
    return c;
}

/// At 90 degrees the rod is inclined by asin(0.44): the piston has moved 22 mm minus 50 - sqrt(50^2 - 22^2) = 5.1001
/// mm.
static void crank_by_hand() {
    const Pump<double> p = pump();
    CHECK_NEAR(travel(p, 0.0).travel, 0.022 - (0.050 - std::sqrt(0.0025 - 0.000484)), 1e-17);
    CHECK_NEAR(travel(p, 0.0).slope, 0.022, 1e-17);
    CHECK_NEAR(travel(p, -pi / 2).travel, 0.0, 1e-18);
    CHECK_NEAR(travel(p, pi / 2).travel, 0.044, 1e-17);  // two cranks, dead center to dead center
    CHECK(displaced(p, 0.0) == 0.0);
    for (double angle = -1.2; angle < 1.3; angle += 0.3) {
        const double h = 1e-5;
        CHECK_NEAR(displaced_slope(p, angle), (displaced(p, angle + h) - displaced(p, angle - h)) / (2 * h), 1e-15);
        Dual<double, 1> x(angle);
        x.d[0] = 1;
        const auto dual =
            displaced(Pump<Dual<double, 1>>{p.area, p.crank, p.rod, p.neutral, p.start, p.chamber, p.seal}, x);
        CHECK_NEAR(dual.d[0], displaced_slope(p, angle), 1e-19);
    }
}

/// At the computed pressure the oil fills the space exactly, from deep suction to high pressure, with air and without.
static void pressure_fills_the_space() {
    for (double air : {0.0, 1e-4, 0.01, 0.1})
        for (double compliance : {0.0, 2e-12}) {
            const Circuit<double> c = circuit(air);
            for (double space = 6e-6; space < 9e-6; space += 1e-8) {
                const OilPressure<double> p = oil_pressure(c, 7e-6, space, compliance);
                const double filled = oil_volume(c, 7e-6, p.pressure) + p.cavity - compliance * p.pressure;
                CHECK_NEAR(filled, space, 1e-15 * space * (1 + 1e-9 * c.bulk_modulus));
                CHECK(p.pressure >= c.cavitation && p.cavity >= 0);
                CHECK(p.cavity == 0 || p.pressure == c.cavitation);
            }
        }
    // By hand: without other compliance, 1 % of air halves its volume at twice the atmosphere.
    Circuit<double> c = circuit();
    c.bulk_modulus = infinite;
    CHECK_NEAR(oil_pressure(c, 1e-6, 1.005e-6, 0.0).pressure, atmosphere, 1e-6);
    const double h = 10.0, at = 80e3;
    CHECK_NEAR(oil_compliance(c, 1e-6, at), (oil_volume(c, 1e-6, at - h) - oil_volume(c, 1e-6, at + h)) / (2 * h),
               1e-20);
}

/// The pressure's slope and its change by difference quotients; a cavity leaves none.
static void pressure_by_space() {
    const Circuit<double> c = circuit(0.01);
    const double h = 1e-11;
    for (double space = 6.9e-6; space < 7.3e-6; space += 2e-8) {
        const auto [at, slope, change] = oil_curve(c, 7e-6, space, 2e-12);
        const auto low = oil_curve(c, 7e-6, space - h, 2e-12), high = oil_curve(c, 7e-6, space + h, 2e-12);
        if (low.at.cavity == 0 && high.at.cavity > 0) continue;  // the cavity opens in between
        CHECK_NEAR(slope, (high.at.pressure - low.at.pressure) / (2 * h), 1e6);
        CHECK_NEAR(change, (high.slope - low.slope) / (2 * h), 1e-5 * std::abs(change));
        CHECK(at.cavity == 0 || (slope == 0 && change == 0));
    }
}

/// A circuit filled as specified: 60 kPa on both sides at rest, where nothing moves and friction holds the piston.
static void rest_stays_rest() {
    const Circuit<double> c = circuit();
    const auto [rate, output] = circuit_rate(c, CircuitState<double>{}, 0.0, 7.2, 0.0);
    CHECK_NEAR(output.pump.pressure, 60e3, 1e-6);
    CHECK_NEAR(output.unit.pressure, 60e3, 1e-6);
    CHECK(std::fabs(rate.flow) < 1e-12 && rate.angle == 0 && rate.passed == 0 && rate.rate == 0);
    CHECK_NEAR(output.load, 60e3 * 2.5447e-4 * 0.022, 1e-9);  // 0.336 N m, of which friction holds 0.3
    CHECK_NEAR(output.torque, output.load - 0.3, 1e-12);
}

static void servo_by_hand() {
    const Servo<double> s = servo();
    // Far from its target the servo gives its full torque: stall torque at rest, half of it at half speed, none at full
    // speed, negative beyond.
    for (double part : {0.0, 0.5, 1.0, 1.2}) {
        const auto drive = servo_drive(s, 7.2, 0.0, 100.0, 0.0, part * 7.5);
        CHECK_NEAR(drive.torque, 6.86 * (1 - part), part == 0.0 ? 1e-12 : 1e-4);  // friction sets in over 0.05 rad/s
    }
    CHECK_NEAR(servo_drive(s, 3.6, 0.0, 100.0, 0.0, 0.0).torque, 3.43, 1e-12);  // half the voltage
    // At rest the motor's torque is the part of the load that friction does not hold.
    CHECK(servo_drive(s, 7.2, 0.2, 0.0, 0.0, 0.0).torque == 0.0);
    CHECK(servo_drive(s, 7.2, -0.3, 0.0, 0.0, 0.0).torque == 0.0);
    CHECK_NEAR(servo_drive(s, 7.2, 1.5, 0.0, 0.0, 0.0).torque, 1.2, 1e-15);
    CHECK_NEAR(servo_drive(s, 7.2, -1.5, 0.0, 0.0, 0.0).torque, -1.2, 1e-15);
}

/// The shares of the power add up; at rest, under a load that friction holds, only the electronics draw power; no power
/// is recovered.
static void power_by_hand() {
    const Servo<double> s = servo();
    for (double load : {-2.0, -0.2, 0.0, 1.5})
        for (double rate : {-6.0, -0.01, 0.0, 0.3, 7.0})
            for (double target : {-1.0, 0.0, 0.2}) {
                const auto drive = servo_drive(s, 7.2, load, target, 0.0, rate);
                const auto p = servo_power(s, drive, 7.2, load, rate);
                CHECK_NEAR(p.idle + p.windings + p.load + p.gears + p.seals + p.rotor + p.braking, p.total, 1e-12);
                CHECK_NEAR(p.load + p.gears + p.seals + p.rotor, drive.torque * rate, 1e-12);
                CHECK(p.total >= p.idle - 1e-12 && p.windings >= 0 && p.braking >= 0);
            }
    const auto held = servo_drive(s, 7.2, 0.25, 0.0, 0.0, 0.0);
    CHECK(servo_power(s, held, 7.2, 0.25, 0.0).total == 7.2 * 0.3);
    const auto stalled = servo_drive(s, 7.2, 0.0, 100.0, 0.0, 0.0);
    CHECK_NEAR(servo_power(s, stalled, 7.2, 0.0, 0.0).total, 7.2 * 7.3, 1e-10);  // stall and idle current
}

/// A piston whose seals rub with 15 N: at a constant rate they take F v in addition to the gears' losses, once friction
/// is fully developed. At rest they hold the load that the gears do not. Without seal friction not a bit changes.
static void seals_by_hand() {
    Circuit<double> c = circuit();
    const auto power = [&](const CircuitState<double>& at) { return circuit_rate(c, at, 1.0, 7.2, 0.0).output.power; };
    const CircuitState<double> turning{0.4, 4.0, 1e-5, 1e-6}, back{0.4, -4.0, 1e-5, 1e-6};
    const double slope = travel(c.pump, 0.4).slope;
    CHECK(power(turning).seals == 0);
    c.pump.seal = 15;
    for (const CircuitState<double>& at : {turning, back}) {
        CHECK_NEAR(power(at).seals, 15 * slope * 4, 5e-4);
        CHECK_NEAR(power(at).gears, 0.3 * 4, 5e-4);
    }
    // 60 kPa load it by 0.336 N m; gears and seals hold 0.3 + 15 x 0.022 N m.
    const auto held = circuit_rate(c, CircuitState<double>{}, 0.0, 7.2, 0.0).output;
    CHECK(held.torque == 0 && held.power.total == held.power.idle);
    CHECK(circuit_stiffness(c, 60e3, 0.0) > circuit_stiffness(circuit(), 60e3, 0.0));
}

template <class Rate>
static CircuitState<double> run(CircuitState<double> y, int steps, double step, const Rate& rate) {
    for (int k = 0; k < steps; ++k)
        y = runge_kutta_4(step, y,
                          [&](int half, const CircuitState<double>& at) { return rate((k + 0.5 * half) * step, at); });
    return y;
}

/// With a harmonic target and compliant units, the oil fills both spaces exactly after 60 s.
static void balance_is_exact() {
    const Circuit<double> c = circuit();
    const auto rate = [&](double t, const CircuitState<double>& y) {
        return circuit_rate(c, y, 0.3 * std::sin(2 * pi * 3 * t), 7.2, 1e-6 * std::sin(2 * pi * 3 * t - 0.4)).rate;
    };
    const CircuitState<double> y = run({}, 120000, 5e-4, rate);
    const auto out = circuit_rate(c, y, 0.0, 7.2, 5e-7).output;
    CHECK(y.angle != 0 && y.passed != 0 && out.pump.pressure != out.unit.pressure);
    const double pump = oil_volume(c, c.oil_pump - y.passed, out.pump.pressure) + out.pump.cavity;
    const double unit = oil_volume(c, c.oil_unit + y.passed, out.unit.pressure) + out.unit.cavity;
    CHECK_NEAR(pump, c.pump.chamber - displaced(c.pump, y.angle), 1e-19);
    CHECK_NEAR(unit, c.unit_rest + 5e-7 + c.compliance * out.unit.pressure, 1e-19);
    // The oil of both spaces together is the filled amount: volumes under pressure, converted to volumes of oil.
    const double all = (pump - out.pump.cavity) / oil_volume(c, 1.0, out.pump.pressure) +
                       (unit - out.unit.cavity) / oil_volume(c, 1.0, out.unit.pressure);
    CHECK_NEAR(all, c.oil_pump + c.oil_unit, 1e-20);
}

/// Suction opens a cavity at the cavitation pressure; pushing closes it again and the pressure comes back.
static void cavity_opens_and_closes() {
    const Circuit<double> c = circuit(1e-4);
    double lowest = 1e9, largest = 0;
    const auto rate = [&](double t, const CircuitState<double>& y) {
        const auto r = circuit_rate(c, y, t < 0.5 ? -0.6 : 0.0, 7.2, 0.0);
        lowest = std::fmin(lowest, r.output.pump.pressure);
        largest = std::fmax(largest, r.output.pump.cavity);
        return r.rate;
    };
    const CircuitState<double> y = run({}, 40000, 1e-4, rate);
    const auto out = circuit_rate(c, y, 0.0, 7.2, 0.0).output;
    CHECK(lowest == c.cavitation && largest > 1e-7 && out.pump.cavity == 0);
    CHECK_NEAR(out.pump.pressure, 60e3, 200.0);
}

/// Steady flow: the drop along the line is Poiseuille's 128 mu l Q / (pi d^4), plus the quadratic loss where there is
/// one.
static void drop_by_poiseuille() {
    Circuit<double> c = circuit();
    const double viscosity = 0.117, length = 0.08, bore = 0.003;
    c.resistance = 128 * viscosity * length / (pi * std::pow(bore, 4));
    for (double loss : {0.0, 1e13}) {
        c.loss = loss;
        const CircuitState<double> moving{0.3, 0.0, 2e-5, 1e-6};
        const auto [rate, out] = circuit_rate(c, moving, 0.3, 7.2, 0.0);
        const double drop = out.pump.pressure - out.unit.pressure - c.inertance * rate.flow;
        CHECK_NEAR(drop, 4.706e9 * 2e-5 + loss * 4e-10, 0.001 * drop);
        CHECK_NEAR(out.line, drop * 2e-5, 1e-12);
    }
}

/// A first-order lag: cylinder held at a pressure, line, units that give. The corner of its response is 1 / (2 pi R C).
static void corner_of_the_line() {
    Circuit<double> c = circuit(0.0);
    c.compliance = 9e-12;
    c.bulk_modulus = 1e15;  // nearly incompressible oil
    c.inertance = 1e5;      // with nearly no inertance
    const double corner = 1 / (2 * pi * c.resistance * c.compliance);
    const double step = 1e-5, period = 1 / corner;
    const int steps = static_cast<int>(period / step + 0.5);
    const auto swing = [&](double t) { return 1e5 * std::sin(2 * pi * t / (steps * step)); };
    // Pressure source: the same line, its cylinder's pressure given.
    const auto rate = [&](double t, const CircuitState<double>& y) {
        const double drop = swing(t) + 60e3 - unit_pressure(c, y, 0.0).pressure - c.resistance * y.flow;
        return CircuitState<double>{0, 0, drop / c.inertance, y.flow};
    };
    CircuitState<double> y = run({}, 10 * steps, step, rate);
    double largest = 0;
    for (int k = 0; k < steps; ++k) {
        y = run(y, 1, step, [&](double t, const CircuitState<double>& at) { return rate(t + k * step, at); });
        largest = std::fmax(largest, unit_pressure(c, y, 0.0).pressure - 60e3);
    }
    CHECK_NEAR(largest / 1e5, 1 / std::sqrt(2.0), 0.01 / std::sqrt(2.0));
}

/// Half the step changes nothing above 0.1 %, and the bound of the rates says that the step is stable.
static void half_the_step() {
    const Circuit<double> c = circuit();
    CHECK(circuit_stiffness(c, 300e3, 1e-4) * 5e-4 < 2.7);
    // A target every 10 ms, held in between as the controller does, and units that the joint squeezes.
    const auto swim = [&](int pulses, double step) {
        CircuitState<double> y{};
        for (int pulse = 0; pulse < pulses; ++pulse) {
            const double start = 0.01 * pulse, target = 0.36 * std::sin(2 * pi * 3 * start);
            y = run(y, static_cast<int>(0.01 / step + 0.5), step, [&](double t, const CircuitState<double>& at) {
                return circuit_rate(c, at, target, 7.2, 1e-6 * std::sin(2 * pi * 3 * (start + t))).rate;
            });
        }
        return y;
    };
    for (int pulses : {20, 50, 95}) {
        const CircuitState<double> a = swim(pulses, 5e-4), b = swim(pulses, 2.5e-4);
        CHECK_NEAR(a.angle, b.angle, 1e-3 * 0.36);
        CHECK_NEAR(a.passed, b.passed, 1e-3 * 1e-6);
        CHECK_NEAR(pump_pressure(c, a).pressure, pump_pressure(c, b).pressure, 1e-3 * 250e3);
    }
}

/// A row of numbers becomes a circuit, in double and in float; float sees the same to its digits.
static void rows_and_floats() {
    double row[circuit_column_count];
    for (int k = 0; k < circuit_column_count; ++k) row[k] = k + 1;
    const Circuit<double> counted = read_circuit<double>(row);
    CHECK(counted.pump.area == 1 && counted.pump.seal == 7 && counted.servo.stall_torque == 8);
    CHECK(counted.servo.inertia == 15 && counted.resistance == 16 && counted.oil_pump == 19);
    CHECK(counted.air == 24 && counted.cavitation == 25 && circuit_column_count == 25);

    const Circuit<double> c = circuit();
    const double all[circuit_column_count] = {c.pump.area,
                                              c.pump.crank,
                                              c.pump.rod,
                                              c.pump.neutral,
                                              c.pump.start,
                                              c.pump.chamber,
                                              c.pump.seal,
                                              c.servo.stall_torque,
                                              c.servo.speed,
                                              c.servo.bandwidth,
                                              c.servo.friction,
                                              c.servo.voltage,
                                              c.servo.stall_current,
                                              c.servo.idle_current,
                                              c.servo.inertia,
                                              c.resistance,
                                              c.loss,
                                              c.inertance,
                                              c.oil_pump,
                                              c.oil_unit,
                                              c.unit_rest,
                                              c.compliance,
                                              c.bulk_modulus,
                                              c.air,
                                              c.cavitation};
    const Circuit<float> single = read_circuit<float>(all);
    const CircuitState<double> at{0.2, 3.0, 2e-5, 1e-6};
    const auto wide = circuit_rate(c, at, 0.3, 7.2, 1e-7);
    const auto narrow = circuit_rate(single, CircuitState<float>{0.2f, 3.0f, 2e-5f, 1e-6f}, 0.3f, 7.2f, 1e-7f);
    // Pressure is the small difference of volumes: a float's 6e-8 of 8 ml over 1e-13 m^3/Pa of oil and air.
    CHECK_NEAR(narrow.output.unit.pressure, wide.output.unit.pressure, 2e3);
    CHECK_NEAR(narrow.output.pump.pressure, wide.output.pump.pressure, 2e4);
    CHECK_NEAR(narrow.output.torque, wide.output.torque, 0.1);
}

int main() {
    rows_and_floats();
    crank_by_hand();
    seals_by_hand();
    pressure_fills_the_space();
    pressure_by_space();
    rest_stays_rest();
    servo_by_hand();
    power_by_hand();
    balance_is_exact();
    cavity_opens_and_closes();
    drop_by_poiseuille();
    corner_of_the_line();
    half_the_step();
    return failures();
}
