/// Bindings of muscles, soft joints, pump, lines, servos and battery.
#include <nanobind/stl/pair.h>

#include <vector>

#include "hypertuna/actuation/battery.hpp"
#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/actuation/joint_table.hpp"
#include "hypertuna/actuation/pair.hpp"
#include "hypertuna/swimming/stepping.hpp"
#include "model.hpp"

namespace hypertuna {

/// A soft joint that owns its segments.
struct OwnedJoint {
    SoftJoint<double> joint;
    std::vector<Segment<double>> segments;

    SoftJoint<double> view() const {
        SoftJoint<double> out = joint;
        out.segment = segments.data();
        return out;
    }
};

static DriveUnit<double> make_unit(double outer, double inner, double tan2, double sleeve,
                                   const std::pair<double, double>& hose, const std::pair<double, double>& matrix,
                                   double friction) {
    return {outer, inner, tan2, sleeve, {hose.first, hose.second}, {matrix.first, matrix.second}, friction};
}

static OwnedJoint make_joint(const DriveUnit<double>& unit, double units, const std::pair<double, double>& lever,
                             const std::vector<double>& length, const std::vector<double>& stiffness) {
    check_extent("stiffness", stiffness.size(), length.size());
    if (length.empty()) throw nb::value_error("length: a joint has one segment at least");
    OwnedJoint out{{unit,
                    units,
                    {lever.first, lever.second},
                    static_cast<int>(length.size()),
                    nullptr,
                    {false, {false, false}, true}},
                   {}};
    for (std::size_t i = 0; i < length.size(); ++i) out.segments.push_back({length[i], stiffness[i]});
    return out;
}

static OwnedJoint with_law(OwnedJoint joint, bool printed, bool nominal_stress, bool inner_balance, bool passive) {
    joint.joint.law = {printed, {nominal_stress, inner_balance}, passive};
    return joint;
}

/// What a muscle does at every stretch.
static NamedArrays muscle(const DriveUnit<double>& unit, const Input<1>& stretch, double pressure) {
    const std::size_t n = stretch.shape(0);
    Output energy_out = zeros({n}), wall_out = zeros({n}), lumen_out = zeros({n}), slope_out = zeros({n}),
           pull_out = zeros({n}), printed_out = zeros({n}), carried_out = zeros({n}), contact_out = zeros({n});
    for (std::size_t k = 0; k < n; ++k) {
        const double l = stretch.data()[k];
        energy_out.data()[k] = energy(unit, l);
        wall_out.data()[k] = energy_slope(unit, l);
        lumen_out.data()[k] = lumen(unit, l);
        slope_out.data()[k] = lumen_slope(unit, l);
        pull_out.data()[k] = pull(unit, pressure, l);
        printed_out.data()[k] = printed_pull(unit, pressure, l, {true, true});
        carried_out.data()[k] = carried(unit, l);
        contact_out.data()[k] = contact(unit, l);
    }
    NamedArrays out;
    out["energy"] = energy_out;
    out["energy_slope"] = wall_out;
    out["lumen"] = lumen_out;
    out["lumen_slope"] = slope_out;
    out["pull"] = pull_out;
    out["printed_pull"] = printed_out;
    out["carried"] = carried_out;
    out["contact"] = contact_out;
    return out;
}

static Output bend(const OwnedJoint& owned, const Input<2>& pressure) {
    check_extent("pressure", pressure.shape(1), 2);
    const SoftJoint<double> joint = owned.view();
    const std::size_t n = pressure.shape(0), segments = owned.segments.size();
    Output out = zeros({n, segments});
    for (std::size_t i = 0; i < segments; ++i) {
        double angle = 0;
        for (std::size_t k = 0; k < n; ++k) {
            angle = bend_from(joint, static_cast<int>(i), pressure.data() + 2 * k, angle);
            out.data()[k * segments + i] = angle;
        }
    }
    return out;
}

static constexpr std::size_t point_columns = sizeof(JointPoint<double>) / sizeof(double);

static Output joint_table(const OwnedJoint& owned, double reach, int points) {
    if (points < 3 || points % 2 == 0) throw nb::value_error("points: must be odd, and 3 at least");
    Output out = zeros({static_cast<std::size_t>(points), point_columns});
    const nb::gil_scoped_release unlocked;
    tabulate(owned.view(), reach, points, reinterpret_cast<JointPoint<double>*>(out.data()));
    return out;
}

static NamedArrays joint_loads(const Input<2>& points, double first, double step, double stop, const Input<1>& angle) {
    check_extent("points", points.shape(1), point_columns);
    if (points.shape(0) < 2) throw nb::value_error("points: a table has two points at least");
    const JointTable<double> table{reinterpret_cast<const JointPoint<double>*>(points.data()),
                                   static_cast<int>(points.shape(0)),
                                   first,
                                   step,
                                   0.0,
                                   stop};
    const std::size_t n = angle.shape(0);
    Output elastic = zeros({n}), energy_out = zeros({n}), volume = zeros({n, 2}), slope = zeros({n, 2}),
           friction = zeros({n, 2}), carried_out = zeros({n, 2});
    for (std::size_t k = 0; k < n; ++k) {
        const JointLoad<double> load = joint_load(table, angle.data()[k]);
        elastic.data()[k] = load.elastic;
        energy_out.data()[k] = load.energy;
        std::copy(load.volume, load.volume + 2, volume.data() + 2 * k);
        std::copy(load.slope, load.slope + 2, slope.data() + 2 * k);
        std::copy(load.friction, load.friction + 2, friction.data() + 2 * k);
        std::copy(load.carried, load.carried + 2, carried_out.data() + 2 * k);
    }
    NamedArrays out;
    out["elastic"] = elastic;
    out["energy"] = energy_out;
    out["volume"] = volume;
    out["slope"] = slope;
    out["friction"] = friction;
    out["carried"] = carried_out;
    return out;
}

static std::vector<std::string> circuit_names() { return {circuit_columns, circuit_columns + circuit_column_count}; }

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

static double stiffness_of(const Input<1>& row, double pressure, double flow) {
    return circuit_stiffness(circuit_of(row), pressure, flow);
}

static std::vector<std::string> battery_names() { return {battery_columns, battery_columns + battery_column_count}; }

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

static void bind_joints(nb::module_& m) {
    nb::class_<DriveUnit<double>>(m, "DriveUnit", "A McKibben muscle. Immutable.")
        .def(
            "__init__",
            [](DriveUnit<double>* self, double outer, double inner, double tan2, double sleeve,
               const std::pair<double, double>& hose, const std::pair<double, double>& matrix, double friction) {
                new (self) DriveUnit<double>(make_unit(outer, inner, tan2, sleeve, hose, matrix, friction));
            },
            nb::kw_only(), nb::arg("outer"), nb::arg("inner"), nb::arg("tan2"), nb::arg("sleeve"), nb::arg("hose"),
            nb::arg("matrix"), nb::arg("friction"),
            "Diameters at rest, squared tangent of the braid's angle, sleeve, C1 and C2 of hose and matrix.")
        .def("at", &muscle, nb::arg("stretch"), nb::kw_only(), nb::arg("pressure"),
             "Energy and lumen per length at rest with their slopes, pull, pull by the printed equations, pressure "
             "that the walls carry and contact area, at every stretch.")
        .def(
            "closing_stretch", [](const DriveUnit<double>& unit, double left) { return closing_stretch(unit, left); },
            nb::arg("left"), "Stretch at which this part of the lumen at rest is left.");
    nb::class_<OwnedJoint>(m, "SoftJoint", "A soft joint: muscles on both sides of segments of matrix. Immutable.")
        .def(
            "__init__",
            [](OwnedJoint* self, const DriveUnit<double>& unit, double units, const std::pair<double, double>& lever,
               const std::vector<double>& length, const std::vector<double>& stiffness) {
                new (self) OwnedJoint(make_joint(unit, units, lever, length, stiffness));
            },
            nb::arg("unit"), nb::kw_only(), nb::arg("units"), nb::arg("lever"), nb::arg("length"), nb::arg("stiffness"),
            "Muscles a side, lever of each side, length and E I of each segment.")
        .def("with_law", &with_law, nb::kw_only(), nb::arg("printed"), nb::arg("nominal_stress"),
             nb::arg("inner_balance"), nb::arg("passive"), "The same joint by other equations.")
        .def("bend", &bend, nb::arg("pressure"),
             "Angle of each segment (times, segments) along a path of the two sides' pressures (times, 2) from rest.")
        .def(
            "reach",
            [](const OwnedJoint& owned, int side, double left, double highest) {
                if (side != 0 && side != 1) throw nb::value_error("side must be 0 or 1");
                return joint_reach(owned.view(), side, left, highest);
            },
            nb::arg("side"), nb::kw_only(), nb::arg("left"), nb::arg("highest"),
            "Largest angle toward a side, up to the highest pressure, whose segments keep this part of every lumen.")
        .def(
            "stiffness",
            [](const OwnedJoint& owned) {
                const JointStiffness<double> stiffness = stiffness_at_rest(owned.view());
                return std::pair(stiffness.matrix, stiffness.walls);
            },
            "Stiffness at rest against the joint's angle: of the matrix, and of the walls.")
        .def("table", &joint_table, nb::kw_only(), nb::arg("reach"), nb::arg("points"),
             "The joint's table from -reach to reach (points, columns).");
    m.def("joint_load", &joint_loads, nb::arg("points"), nb::kw_only(), nb::arg("first"), nb::arg("step"),
          nb::arg("stop"), nb::arg("angle"), "What a joint's table says at every angle.");
}

static void bind_hydraulics(nb::module_& m) {
    m.attr("ATMOSPHERE") = atmosphere;
    m.def("circuit_columns", &circuit_names, "Numbers that describe a circuit, in the order of a row.");
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
    m.def("circuit_stiffness", &stiffness_of, nb::arg("circuit"), nb::arg("pressure"), nb::arg("flow"),
          "Bound of a circuit's rates with the joint held, at a pressure and a flow [1/s]: Runge-Kutta steps must be "
          "shorter than 2.7 over it.");
    m.def("battery_columns", &battery_names, "Numbers that describe a battery, in the order of a row.");
    m.def(
        "battery_output", &battery_at, nb::arg("battery"), nb::arg("taken"), nb::arg("power"),
        "Voltage and current of a battery and voltage at the servos, after a charge was taken, while they draw a power "
        "[V, A, V].");
}

void bind_actuation(nb::module_& m) {
    bind_joints(m);
    bind_hydraulics(m);
}

}  // namespace hypertuna
