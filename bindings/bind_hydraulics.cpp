/// Bindings of pump, lines and servos.
#include "hypertuna/actuation/battery.hpp"
#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/actuation/pair.hpp"
#include "hypertuna/swimming/stepping.hpp"
#include "model.hpp"

namespace hypertuna {

static std::vector<std::string> columns() { return {circuit_columns, circuit_columns + circuit_column_count}; }

static Circuit<double> circuit_of(const Input<1>& row) {
    check_extent("circuit", row.shape(0), circuit_column_count);
    return read_circuit<double>(row.data());
}

static Output displaced_by(const Input<1>& row, const Input<1>& angle) {
    const Circuit<double> circuit = circuit_of(row);
    Output out = zeros({angle.shape(0), 2});
    for (std::size_t k = 0; k < angle.shape(0); ++k) {
        out.data()[2 * k] = displaced(circuit.pump, angle.data()[k]);
        out.data()[2 * k + 1] = displaced_slope(circuit.pump, angle.data()[k]);
    }
    return out;
}

/// What a run of one circuit shows at every instant, and in which order.
struct CircuitColumn {
    const char* name;
    double (*of)(const CircuitState<double>&, const CircuitOutput<double>&);
};
#define HYPERTUNA_SEEN(name, value)                                                  \
    {name, [](const CircuitState<double>& state, const CircuitOutput<double>& out) { \
         return (void)state, (void)out, value;                                       \
     }}
static constexpr CircuitColumn circuit_seen[] = {
    HYPERTUNA_SEEN("angle", state.angle),
    HYPERTUNA_SEEN("rate", state.rate),
    HYPERTUNA_SEEN("flow", state.flow),
    HYPERTUNA_SEEN("passed", state.passed),
    HYPERTUNA_SEEN("pump_pressure", out.pump.pressure),
    HYPERTUNA_SEEN("unit_pressure", out.unit.pressure),
    HYPERTUNA_SEEN("pump_cavity", out.pump.cavity),
    HYPERTUNA_SEEN("unit_cavity", out.unit.cavity),
    HYPERTUNA_SEEN("load", out.load),
    HYPERTUNA_SEEN("torque", out.torque),
    HYPERTUNA_SEEN("power", out.power.total),
    HYPERTUNA_SEEN("power_idle", out.power.idle),
    HYPERTUNA_SEEN("power_holding", out.power.holding),
    HYPERTUNA_SEEN("power_hydraulic", out.power.hydraulic),
    HYPERTUNA_SEEN("power_friction", out.power.friction),
    HYPERTUNA_SEEN("power_inertia", out.power.inertia),
    HYPERTUNA_SEEN("power_braking", out.power.braking),
};

/// Run the pair of a joint through servo targets; one row before each interval and one after the last.
static NamedArrays run_pair(const Input<2>& rows, const Input<2>& points, double first, double step, double stop,
                            const Input<2>& target, double supply, double interval, int steps) {
    check_extent("circuits", rows.shape(0), 2);
    check_extent("circuits", rows.shape(1), circuit_column_count);
    check_extent("points", points.shape(1), sizeof(JointPoint<double>) / sizeof(double));
    check_extent("target", target.shape(1), 2);
    const auto* const point = reinterpret_cast<const JointPoint<double>*>(points.data());
    const JointTable<double> joint{point, static_cast<int>(points.shape(0)), first, step, 0.0, stop};
    const Pair<double> pair =
        make_pair(read_circuit<double>(rows.data()), read_circuit<double>(rows.data() + circuit_column_count), joint);
    const std::size_t count = target.shape(0), columns = std::size(circuit_seen);
    std::vector<Output> seen;
    for (std::size_t c = 0; c < columns; ++c) seen.push_back(zeros({count + 1, 2}));
    Output bend = zeros({count + 1});
    {
        const nb::gil_scoped_release unlocked;
        PairState<double> state{};
        double angle = 0;
        for (std::size_t k = 0; k <= count; ++k) {
            const double* const aim = target.data() + 2 * (k < count ? k : count - 1);
            angle = pair_angle(pair, state, angle);
            const PairRate<double> now = pair_rate(pair, state, aim, supply, angle);
            bend.data()[k] = angle;
            for (std::size_t c = 0; c < columns; ++c)
                for (int s = 0; s < 2; ++s)
                    seen[c].data()[2 * k + s] = circuit_seen[c].of(state.side[s], now.output[s]);
            if (k == count) break;
            for (int i = 0; i < steps; ++i)
                state = runge_kutta_4(interval / steps, state, [&](int, const PairState<double>& at) {
                    angle = pair_angle(pair, at, angle);
                    return pair_rate(pair, at, aim, supply, angle).rate;
                });
        }
    }
    NamedArrays out;
    for (std::size_t c = 0; c < columns; ++c) out[circuit_seen[c].name] = seen[c];
    out["bend"] = bend;
    return out;
}

static double stiffness(const Input<1>& row, double pressure, double flow) {
    return circuit_stiffness(circuit_of(row), pressure, flow);
}

static std::vector<std::string> of_battery() { return {battery_columns, battery_columns + battery_column_count}; }

static Output battery_at(const Input<1>& row, const Input<1>& taken, const Input<1>& power) {
    check_extent("battery", row.shape(0), battery_column_count);
    check_extent("power", power.shape(0), taken.shape(0));
    const Battery<double> battery = read_battery<double>(row.data());
    Output out = zeros({taken.shape(0), 3});
    for (std::size_t k = 0; k < taken.shape(0); ++k) {
        const BatteryOutput<double> at = battery_output(battery, taken.data()[k], power.data()[k]);
        const double seen[3] = {at.voltage, at.current, at.supply};
        std::copy(seen, seen + 3, out.data() + 3 * k);
    }
    return out;
}

void bind_hydraulics(nb::module_& m) {
    m.attr("ATMOSPHERE") = atmosphere;
    m.def("circuit_columns", &columns, "Numbers that describe a circuit, in the order of a row.");
    m.def(
        "displaced", &displaced_by, nb::arg("circuit"), nb::arg("angle"),
        "Volume that a cylinder pushes out when its servo turns from zero to an angle, and its derivative by the angle "
        "[m^3, m^3/rad].");
    m.def(
        "run_pair", &run_pair, nb::arg("circuits"), nb::arg("points"), nb::kw_only(), nb::arg("first"), nb::arg("step"),
        nb::arg("stop"), nb::arg("target"), nb::arg("supply"), nb::arg("interval"), nb::arg("steps"),
        "Run the two circuits of a joint in air from rest: servo targets are held for an interval each, in Runge-Kutta "
        "steps, and the joint, without mass, bends to where silicone and oil balance. What is seen at every interval, "
        "with one column per side.");
    m.def("circuit_stiffness", &stiffness, nb::arg("circuit"), nb::arg("pressure"), nb::arg("flow"),
          "Bound of a circuit's rates with the joint held, at a pressure and a flow [1/s]: Runge-Kutta steps must be "
          "shorter than 2.7 over it.");
    m.def("battery_columns", &of_battery, "Numbers that describe a battery, in the order of a row.");
    m.def(
        "battery_output", &battery_at, nb::arg("battery"), nb::arg("taken"), nb::arg("power"),
        "Voltage and current of a battery and voltage at the servos, after a charge was taken, while they draw a power "
        "[V, A, V].");
}

}  // namespace hypertuna
