/// Bindings of muscles, soft joints, pump, lines, servos and battery.
#include <nanobind/stl/pair.h>

#include <vector>

#include "hypertuna/actuation/battery.hpp"
#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/actuation/pair.hpp"
#include "hypertuna/swimming/stepping.hpp"
#include "model.hpp"

namespace hypertuna {

/// A soft joint that owns its sections.
struct OwnedJoint {
    SoftJoint<double> joint;
    std::vector<Section<double>> sections;

    SoftJoint<double> view() const {
        SoftJoint<double> out = joint;
        out.section = sections.data();
        return out;
    }
};

static DriveUnit<double> make_unit(double outer, double inner, double tan2, double sleeve,
                                   const std::pair<double, double>& hose, const std::pair<double, double>& matrix,
                                   double friction) {
    return {outer, inner, tan2, sleeve, {hose.first, hose.second}, {matrix.first, matrix.second}, friction};
}

static OwnedJoint make_joint(const DriveUnit<double>& unit, double units, const std::pair<double, double>& lever,
                             const Input<2>& sections, const std::pair<double, double>& axis) {
    check_extent("sections", sections.shape(1), sizeof(Section<double>) / sizeof(double));
    if (sections.shape(0) == 0) throw nb::value_error("sections: a joint has one at least");
    const auto* const first = reinterpret_cast<const Section<double>*>(sections.data());
    return {{unit,
             units,
             {lever.first, lever.second},
             int(sections.shape(0)),
             nullptr,
             {false, {}, true, true},
             {axis.first, axis.second}},
            {first, first + sections.shape(0)}};
}

static OwnedJoint with_law(OwnedJoint joint, bool printed, bool nominal_stress, bool inner_balance, bool passive,
                           bool shortens) {
    joint.joint.law = {printed, {nominal_stress, inner_balance}, passive, shortens};
    return joint;
}

/// Forces, energy and volume of a muscle at every stretch.
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
    const std::size_t n = pressure.shape(0), sections = owned.sections.size();
    Output out = zeros({n, sections, 2});
    const nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < sections; ++i) {
        Bent<double> bent{0, 0};
        for (std::size_t k = 0; k < n; ++k) {
            bent = bend_from(joint, owned.sections[i], pressure.data() + 2 * k, bent.angle);
            out.data()[2 * (k * sections + i)] = bent.angle;
            out.data()[2 * (k * sections + i) + 1] = bent.strain;
        }
    }
    return out;
}

static std::vector<double> one_section_of(const OwnedJoint& owned, double left, double right) {
    const double pressure[2] = {left, right};
    const Section<double> one = one_section(owned.view(), pressure);
    return {one.length, one.area, one.second, one.sleeve};
}

static std::vector<std::string> joint_names() { return {joint_columns, joint_columns + joint_column_count}; }

static Joint<double> joint_of(const Input<1>& row) {
    check_extent("joint", row.shape(0), joint_column_count);
    return read_joint(row.data());
}

static NamedArrays joint_loads(const Input<1>& row, const Input<1>& angle, const Input<1>& strain,
                               const Input<2>& pressure) {
    check_extent("strain", strain.shape(0), angle.shape(0));
    check_extent("pressure", pressure.shape(0), angle.shape(0));
    check_extent("pressure", pressure.shape(1), 2);
    const Joint<double> joint = joint_of(row);
    const std::size_t n = angle.shape(0);
    Output energy_out = zeros({n}), elastic = zeros({n}), axial = zeros({n}), volume = zeros({n, 2}),
           slope = zeros({n, 2}), gain = zeros({n, 2}), friction = zeros({n, 2}), carried_out = zeros({n, 2});
    for (std::size_t k = 0; k < n; ++k) {
        const double* both = pressure.data() + 2 * k;
        const JointLoad<double> load =
            joint_load(joint, angle.data()[k], strain.data()[k], given_pressures(both[0], both[1]));
        energy_out.data()[k] = load.energy;
        elastic.data()[k] = load.elastic;
        axial.data()[k] = load.axial;
        std::copy(load.volume, load.volume + 2, volume.data() + 2 * k);
        std::copy(load.slope, load.slope + 2, slope.data() + 2 * k);
        std::copy(load.gain, load.gain + 2, gain.data() + 2 * k);
        std::copy(load.friction, load.friction + 2, friction.data() + 2 * k);
        std::copy(load.carried, load.carried + 2, carried_out.data() + 2 * k);
    }
    NamedArrays out;
    out["energy"] = energy_out;
    out["elastic"] = elastic;
    out["axial"] = axial;
    out["volume"] = volume;
    out["slope"] = slope;
    out["gain"] = gain;
    out["friction"] = friction;
    out["carried"] = carried_out;
    return out;
}

/// Pressures, strain and volumes that hold a joint at every angle.
static NamedArrays held_joint(const Input<1>& row, const Input<1>& angle, double fill, double lowest) {
    const Joint<double> joint = joint_of(row);
    const std::size_t n = angle.shape(0);
    Output strain = zeros({n}), pressure = zeros({n, 2}), volume = zeros({n, 2});
    Holding<double> near{};
    for (std::size_t k = 0; k < n; ++k) {
        const Holding<double> at = hold(joint, angle.data()[k], fill, lowest, near);
        if (at.strain == at.strain) near = at;
        strain.data()[k] = at.strain;
        std::copy(at.pressure, at.pressure + 2, pressure.data() + 2 * k);
        std::copy(at.volume, at.volume + 2, volume.data() + 2 * k);
    }
    NamedArrays out;
    out["strain"] = strain;
    out["pressure"] = pressure;
    out["volume"] = volume;
    return out;
}

/// Bend, strain and volumes under pressures of both sides and an external moment.
static NamedArrays balanced_joint(const Input<1>& row, const Input<2>& pressure, const Input<1>& moment) {
    check_extent("pressure", pressure.shape(1), 2);
    check_extent("moment", moment.shape(0), pressure.shape(0));
    Joint<double> joint = joint_of(row);
    const std::size_t n = pressure.shape(0);
    Output angle = zeros({n}), strain = zeros({n}), volume = zeros({n, 2});
    Bent<double> bent{0, 0};
    for (std::size_t k = 0; k < n; ++k) {
        const auto oil = given_pressures(pressure.data()[2 * k], pressure.data()[2 * k + 1]);
        bent = joint_balance(joint, bent, oil, moment.data()[k]);
        const JointLoad<double> load = joint_load(joint, bent.angle, bent.strain, oil);
        angle.data()[k] = bent.angle;
        strain.data()[k] = bent.strain;
        std::copy(load.volume, load.volume + 2, volume.data() + 2 * k);
    }
    NamedArrays out;
    out["angle"] = angle;
    out["strain"] = strain;
    out["volume"] = volume;
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

/// Columns of a circuit's run, in order: name, and value at an instant.
struct CircuitColumn {
    const char* name;
    double (*of)(const CircuitState<double>&, const CircuitOutput<double>&);
};
#define HYPERTUNA_SEEN(name, value)                                                  \
    {name, [](const CircuitState<double>& state, const CircuitOutput<double>& out) { \
         return (void)state, (void)out, value;                                       \
     }}
#define HYPERTUNA_WORK(name, share) HYPERTUNA_SEEN("power_" #name, out.power.share),
#define HYPERTUNA_LOSS(name) HYPERTUNA_WORK(name, name)
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
    HYPERTUNA_SERVO_POWERS(HYPERTUNA_LOSS, HYPERTUNA_WORK) HYPERTUNA_SEEN("power", out.power.total),
};
#undef HYPERTUNA_WORK
#undef HYPERTUNA_LOSS

/// Run the pair of a joint through servo targets; one row before each interval and one after the last.
static NamedArrays run_pair(const Input<2>& rows, const Input<1>& joint, const Input<2>& target, double supply,
                            double interval, int steps) {
    check_extent("circuits", rows.shape(0), 2);
    check_extent("circuits", rows.shape(1), circuit_column_count);
    check_extent("target", target.shape(1), 2);
    const Pair<double> pair = make_pair(read_circuit<double>(rows.data()),
                                        read_circuit<double>(rows.data() + circuit_column_count), joint_of(joint));
    const std::size_t count = target.shape(0), columns = std::size(circuit_seen);
    std::vector<Output> seen;
    for (std::size_t c = 0; c < columns; ++c) seen.push_back(zeros({count + 1, 2}));
    Output bend = zeros({count + 1});
    {
        const nb::gil_scoped_release unlocked;
        PairState<double> state{};
        Bent<double> bent{0, 0};
        for (std::size_t k = 0; k <= count; ++k) {
            const double* const aim = target.data() + 2 * (k < count ? k : count - 1);
            bent = pair_balance(pair, state, bent);
            const PairRate<double> now = pair_rate(pair, state, aim, supply, bent);
            bend.data()[k] = bent.angle;
            for (std::size_t c = 0; c < columns; ++c)
                for (int s = 0; s < 2; ++s)
                    seen[c].data()[2 * k + s] = circuit_seen[c].of(state.side[s], now.output[s]);
            if (k == count) break;
            for (int i = 0; i < steps; ++i)
                state = runge_kutta_4(interval / steps, state, [&](int, const PairState<double>& at) {
                    bent = pair_balance(pair, at, bent);
                    return pair_rate(pair, at, aim, supply, bent).rate;
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

static double axle_stiffness_of(const Input<1>& row, double mobility) {
    return axle_stiffness(circuit_of(row).servo, mobility);
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
            "Diameters at rest, squared tangent of the braid's angle, thickness of matrix around, C1 and C2 of hose "
            "and matrix.")
        .def("at", &muscle, nb::arg("stretch"), nb::kw_only(), nb::arg("pressure"),
             "Energy and lumen per length at rest with their slopes, pull, pull by the printed equations, pressure "
             "that the walls carry and contact area, at every stretch.")
        .def(
            "closing_stretch", [](const DriveUnit<double>& unit, double left) { return closing_stretch(unit, left); },
            nb::arg("left"), "Stretch at which this part of the lumen at rest is left.");
    nb::class_<OwnedJoint>(m, "SoftJoint", "A soft joint: muscles on both sides of sections of matrix. Immutable.")
        .def(
            "__init__",
            [](OwnedJoint* self, const DriveUnit<double>& unit, double units, const std::pair<double, double>& lever,
               const Input<2>& sections, const std::pair<double, double>& axis) {
                new (self) OwnedJoint(make_joint(unit, units, lever, sections, axis));
            },
            nb::arg("unit"), nb::kw_only(), nb::arg("units"), nb::arg("lever"), nb::arg("sections"), nb::arg("axis"),
            "Muscles a side, lever of each side; length, area, second moment and thickness around a hose of each "
            "section; of what lies on the axis, its stiffness and the compressive strain at which it buckles.")
        .def("with_law", &with_law, nb::kw_only(), nb::arg("printed"), nb::arg("nominal_stress"),
             nb::arg("inner_balance"), nb::arg("passive"), nb::arg("shortens"), "The same joint by other equations.")
        .def("bend", &bend, nb::arg("pressure"),
             "Angle and strain of each section (times, sections, 2) along a path of the two sides' pressures (times, "
             "2) from rest.")
        .def("one_section", &one_section_of, nb::kw_only(), nb::arg("left"), nb::arg("right"),
             "Length, area, second moment and thickness around a hose of the one section that stands for all under "
             "these pressures.");
    m.def("joint_columns", &joint_names, "Numbers that describe a joint of one section, in the order of a row.");
    m.def("joint_load", &joint_loads, nb::arg("joint"), nb::kw_only(), nb::arg("angle"), nb::arg("strain"),
          nb::arg("pressure"),
          "Energy, moment, axial force, volumes and friction at every bend, strain relative to the filled joint, and "
          "pair of pressures.");
    m.def("hold_joint", &held_joint, nb::arg("joint"), nb::kw_only(), nb::arg("angle"), nb::arg("fill"),
          nb::arg("lowest"), "Strain, pressures around the filling one, and volumes that hold every angle.");
    m.def("balance_joint", &balanced_joint, nb::arg("joint"), nb::kw_only(), nb::arg("pressure"), nb::arg("moment"),
          "Angle, strain and volumes under pressures (n, 2) and moments of the surroundings (n,).");
}

static void bind_hydraulics(nb::module_& m) {
    m.attr("ATMOSPHERE") = atmosphere;
    m.attr("SERVO_LOOP_RATE") = servo_loop_rate;
    m.def("circuit_columns", &circuit_names, "Numbers that describe a circuit, in the order of a row.");
    m.def(
        "displaced", &displaced_by, nb::arg("circuit"), nb::arg("angle"),
        "Volume that a cylinder pushes out when its servo turns from zero to an angle, and its derivative by the angle "
        "[m^3, m^3/rad].");
    m.def(
        "run_pair", &run_pair, nb::arg("circuits"), nb::arg("joint"), nb::kw_only(), nb::arg("target"),
        nb::arg("supply"), nb::arg("interval"), nb::arg("steps"),
        "Run the two circuits of a joint in air from rest: servo targets are held for an interval each, in Runge-Kutta "
        "steps, and the joint, without mass, bends to where silicone and oil balance. What is seen at every interval, "
        "with one column per side.");
    m.def("circuit_stiffness", &stiffness_of, nb::arg("circuit"), nb::arg("pressure"), nb::arg("flow"),
          "Bound of a circuit's rates with the joint held, at a pressure and a flow [1/s]: Runge-Kutta steps must be "
          "shorter than 2.7 over it.");
    m.def("axle_stiffness", &axle_stiffness_of, nb::arg("circuit"), nb::arg("mobility"),
          "Bound of the rates of a circuit's servo on the axle of a joint with a mobility [rad/s^2 per N m, 1/s].");
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
