/// Bindings of the whole robot, servo to wake.
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "controller.hpp"
#include "free_body.hpp"
#include "hypertuna/twin.hpp"

namespace hypertuna {

template <class Law, int D>
static void accelerate(FreeBody<Law, D>& body, const Input<3>& bend, const Input<2>& twist, const Input<2>& moment,
                       double* out) {
    for (std::size_t k = 0; k < bend.shape(0); ++k) {
        Bend<double, D> at;
        std::copy(bend.data() + 2 * D * k, bend.data() + 2 * D * k + D, at.angle);
        std::copy(bend.data() + 2 * D * k + D, bend.data() + 2 * D * (k + 1), at.rate);
        double push[D];
        std::copy(moment.data() + D * k, moment.data() + D * (k + 1), push);
        const double* xi = twist.data() + 3 * k;
        const TailAcceleration<double, D> got = tail_acceleration(body.tail, at, {xi[0], xi[1], xi[2]}, push);
        double* row = out + (3 + D) * k;
        row[0] = got.twist.x, row[1] = got.twist.y, row[2] = got.twist.z;
        std::copy(got.bend, got.bend + D, row + 3);
    }
}

static Output tail_accelerations(const Model& model, const Input<2>& share, const Input<3>& bend, const Input<2>& twist,
                                 const Input<2>& moment, bool clamped) {
    const std::size_t count = bend.shape(0), coordinates = share.shape(1);
    check_extent("bend", bend.shape(1), 2);
    check_extent("bend", bend.shape(2), coordinates);
    check_extent("twist", twist.shape(0), count);
    check_extent("twist", twist.shape(1), 3);
    check_extent("moment", moment.shape(0), count);
    check_extent("moment", moment.shape(1), coordinates);
    Output out = zeros({count, 3 + coordinates});
    with_free_body(model, share, clamped, [&](auto& body) { accelerate(body, bend, twist, moment, out.data()); });
    return out;
}

/// How many numbers a column of the record has in each tick.
enum class Extent { one, coordinates, joints, circuits, servos, conditions };

/// One column of the record of a run: the state at a tick's start, and what passed in the tick.
template <int D>
struct TwinColumn {
    const char* name;
    Extent extent;
    double (*of)(const TwinState<double, D>&, const Tick<double, D>&, int);
};
#define HYPERTUNA_COLUMN(name, extent, value)                                                                 \
    {name, Extent::extent, [](const TwinState<double, D>& at, const Tick<double, D>& tick, int i) -> double { \
         return (void)at, (void)tick, (void)i, value;                                                         \
     }}
template <int D>
inline constexpr TwinColumn<D> twin_columns[] = {
    HYPERTUNA_COLUMN("x", one, at.plant.pose.x),
    HYPERTUNA_COLUMN("y", one, at.plant.pose.y),
    HYPERTUNA_COLUMN("heading", one, at.plant.pose.heading),
    HYPERTUNA_COLUMN("surge", one, at.plant.xi.x),
    HYPERTUNA_COLUMN("sway", one, at.plant.xi.y),
    HYPERTUNA_COLUMN("yaw", one, at.plant.xi.z),
    HYPERTUNA_COLUMN("angle", coordinates, at.plant.bend.angle[i]),
    HYPERTUNA_COLUMN("rate", coordinates, at.plant.bend.rate[i]),
    HYPERTUNA_COLUMN("moment", coordinates, tick.seen.moment[i]),
    HYPERTUNA_COLUMN("angle_measured", joints, tick.readings.bend[i]),
    HYPERTUNA_COLUMN("angle_set", joints, tick.output.set[i]),
    HYPERTUNA_COLUMN("pump_pressure", circuits, tick.seen.circuit[i].pump.pressure),
    HYPERTUNA_COLUMN("unit_pressure", circuits, tick.seen.circuit[i].unit.pressure),
    HYPERTUNA_COLUMN("pump_pressure_high", circuits, tick.pump[i].high),
    HYPERTUNA_COLUMN("pump_pressure_low", circuits, tick.pump[i].low),
    HYPERTUNA_COLUMN("unit_pressure_high", circuits, tick.unit[i].high),
    HYPERTUNA_COLUMN("unit_pressure_low", circuits, tick.unit[i].low),
    HYPERTUNA_COLUMN("pressure_measured", circuits, tick.readings.pressure[i]),
    HYPERTUNA_COLUMN("servo_target", circuits, at.targets.angle[i]),
    HYPERTUNA_COLUMN("servo_angle", circuits, at.plant.circuit[i].angle),
    HYPERTUNA_COLUMN("servo_rate", circuits, at.plant.circuit[i].rate),
    HYPERTUNA_COLUMN("servo_torque", circuits, tick.seen.circuit[i].torque),
    HYPERTUNA_COLUMN("flow", circuits, at.plant.circuit[i].flow),
    HYPERTUNA_COLUMN("electrical_power", circuits, tick.power[i]),
    HYPERTUNA_COLUMN("current", circuits, tick.readings.current[i]),
    HYPERTUNA_COLUMN("power", one, tick.servo_power),
    HYPERTUNA_COLUMN("battery_voltage", one, at.battery.voltage),
    HYPERTUNA_COLUMN("pulse", servos, tick.output.pulse[i]),
    HYPERTUNA_COLUMN("status", one, tick.output.status.flags),
    HYPERTUNA_COLUMN("status_at", conditions, tick.output.status.at[i]),
};
#undef HYPERTUNA_COLUMN

/// The plant as Python hands it over.
struct PlantInput {
    const Model& model;
    const Input<2>& share;                // links, coordinates
    const std::vector<Input<2>>& points;  // joints: table points, columns of JointPoint
    const Input<2>& grid;                 // joints, 4: first, step, viscosity, stop
    const Input<2>& circuits;             // 2 joints, circuit columns
    const Input<1>& hinge;                // stiffness, damping
    const Input<1>& battery;              // columns of battery.hpp
    double idle;                          // W of what draws power beside the pumps' servos
    bool clamped;
};

/// A twin that owns its memory.
template <class Law, int D>
struct OwnedTwin {
    FreeBody<Law, D> body;
    std::vector<JointTable<double>> joint;
    std::vector<Circuit<double>> circuit;
    std::vector<double> unit_rest;
    Twin<double, Law, D> twin;

    OwnedTwin(const PlantInput& in, double tick, int steps) : body(in.model, in.share.data(), in.clamped) {
        for (std::size_t j = 0; j < in.points.size(); ++j) {
            const double* grid = in.grid.data() + 4 * j;
            joint.push_back({reinterpret_cast<const JointPoint<double>*>(in.points[j].data()),
                             static_cast<int>(in.points[j].shape(0)), grid[0], grid[1], grid[2], grid[3]});
            const JointLoad<double> straight = joint_load(joint.back(), 0.0);
            for (int side = 0; side < 2; ++side) {
                circuit.push_back(read_circuit<double>(in.circuits.data() + (2 * j + side) * circuit_column_count));
                unit_rest.push_back(straight.volume[side]);
            }
        }
        twin.plant = {body.tail,        static_cast<int>(joint.size()),          joint.data(), circuit.data(),
                      unit_rest.data(), {in.hinge.data()[0], in.hinge.data()[1]}};
        twin.battery = read_battery<double>(in.battery.data());
        twin.idle = in.idle;
        twin.step = tick / steps;
        twin.steps = steps;
    }
    OwnedTwin(const OwnedTwin&) = delete;
    OwnedTwin& operator=(const OwnedTwin&) = delete;
};

static void check_plant(const PlantInput& in) {
    const std::size_t joints = in.points.size();
    check_extent("share", in.share.shape(0), in.model.links);
    if (joints < 1 || joints > most_joints || in.share.shape(1) < joints || in.share.shape(1) > joints + 1)
        throw nb::value_error("share: must have one column per joint, and perhaps one for a hinge");
    for (const Input<2>& points : in.points) {
        check_extent("points", points.shape(1), sizeof(JointPoint<double>) / sizeof(double));
        if (points.shape(0) < 2) throw nb::value_error("points: a table has two points at least");
    }
    check_extent("grid", in.grid.shape(0), joints);
    check_extent("grid", in.grid.shape(1), 4);
    check_extent("circuits", in.circuits.shape(0), 2 * joints);
    check_extent("circuits", in.circuits.shape(1), circuit_column_count);
    check_extent("hinge", in.hinge.shape(0), 2);
    check_extent("battery", in.battery.shape(0), battery_column_count);
}

/// Call work with an owned twin of the input's water law and number of coordinates.
template <int D = 1, class Work>
static void with_twin(const PlantInput& in, double tick, int steps, const Work& work) {
    if constexpr (D > most_coordinates)
        throw nb::value_error("share: a tail has 1 to 5 coordinates");
    else if (in.share.shape(1) != D)
        with_twin<D + 1>(in, tick, steps, work);
    else if (in.model.law == WaterLaw::lumped) {
        OwnedTwin<Lumped<double>, D> owned(in, tick, steps);
        work(owned.twin, std::integral_constant<int, D>());
    } else {
        OwnedTwin<Strip<double>, D> owned(in, tick, steps);
        work(owned.twin, std::integral_constant<int, D>());
    }
}

static std::size_t extent_of(Extent extent, std::size_t coordinates, std::size_t joints) {
    switch (extent) {
        case Extent::coordinates:
            return coordinates;
        case Extent::joints:
            return joints;
        case Extent::circuits:
            return 2 * joints;
        case Extent::servos:
            return 2 * joints + 2;
        case Extent::conditions:
            return conditions;
        default:
            return 1;
    }
}

/// Run a twin for so many ticks and record each; ends early where the plant's state is none that a robot can have.
/// go(state, k) makes tick k.
template <class Law, int D, class Go>
static NamedArrays record_run(const Twin<double, Law, D>& twin, std::size_t ticks, const Input<1>& twist,
                              const Go& go) {
    const std::size_t joints = twin.plant.joints;
    std::vector<Output> columns;
    for (const TwinColumn<D>& column : twin_columns<D>) {
        const std::size_t extent = extent_of(column.extent, D, joints);
        columns.push_back(column.extent == Extent::one ? zeros({ticks}) : zeros({ticks, extent}));
    }
    std::size_t done = 0;
    {
        const nb::gil_scoped_release unlocked;
        TwinState<double, D> state = at_rest(twin);
        state.plant.xi = {twist.data()[0], twist.data()[1], twist.data()[2]};
        for (; done < ticks && plausible(state.plant); ++done) {
            const PlantState<double, D> start = state.plant;
            const Tick<double, D> tick = go(state, done);
            TwinState<double, D> shown = state;
            shown.plant = start;
            for (std::size_t c = 0; c < columns.size(); ++c) {
                const TwinColumn<D>& column = twin_columns<D>[c];
                const std::size_t extent = extent_of(column.extent, D, joints);
                double* row = columns[c].data() + extent * done;
                for (std::size_t i = 0; i < extent; ++i) row[i] = column.of(shown, tick, static_cast<int>(i));
            }
        }
    }
    NamedArrays out;
    for (std::size_t c = 0; c < columns.size(); ++c) out[twin_columns<D>[c].name] = columns[c];
    Output ended = zeros({1});
    ended.data()[0] = static_cast<double>(done);
    out["ticks"] = ended;
    return out;
}

static NamedArrays run_plant(const Model& model, const Input<2>& share, const std::vector<Input<2>>& points,
                             const Input<2>& grid, const Input<2>& circuits, const Input<1>& hinge,
                             const Input<1>& battery, double idle, bool clamped, const Input<1>& twist,
                             const Input<2>& target, double tick, int steps) {
    const PlantInput in{model, share, points, grid, circuits, hinge, battery, idle, clamped};
    check_plant(in);
    check_extent("twist", twist.shape(0), 3);
    check_extent("target", target.shape(1), 2 * points.size());
    NamedArrays out;
    with_twin(in, tick, steps, [&](auto& twin, auto D) {
        out = record_run(twin, target.shape(0), twist, [&](TwinState<double, D>& state, std::size_t k) {
            return driven_tick(twin, state, target.data() + k * target.shape(1));
        });
    });
    return out;
}

using NamedColumns = std::map<std::string, std::vector<double>>;
using FaultRow = std::tuple<std::string, int, int, double, double>;

static NamedArrays run_twin(const Model& model, const Input<2>& share, const std::vector<Input<2>>& points,
                            const Input<2>& grid, const Input<2>& circuits, const Input<1>& hinge,
                            const Input<1>& battery, double idle, bool clamped, const Input<1>& twist,
                            const NamedColumns& controller, const NamedColumns& sensors, std::uint64_t seed,
                            const std::vector<FaultRow>& faults, double frequency, const Input<2>& command,
                            double heard, std::size_t ticks, int steps) {
    const PlantInput in{model, share, points, grid, circuits, hinge, battery, idle, clamped};
    check_plant(in);
    check_extent("twist", twist.shape(0), 3);
    check_extent("command", command.shape(0), 3);
    check_extent("command", command.shape(1), points.size());
    const Controller<double> pilot = read_controller<double>(controller);
    const Sensors<double> senses = read_sensors<double>(sensors, seed);
    check_extent("joints", pilot.joints, points.size());
    std::vector<Fault<double>> failing;
    for (const auto& [kind, first, last, start, end] : faults)
        failing.push_back({fault_kind(kind), first, last, start, end});
    Command<double> wish{};
    wish.frequency = frequency;
    wish.armed = true;
    const double* rows = command.data();
    std::copy(rows, rows + pilot.joints, wish.amplitude);
    std::copy(rows + pilot.joints, rows + 2 * pilot.joints, wish.phase);
    std::copy(rows + 2 * pilot.joints, rows + 3 * pilot.joints, wish.bias);
    NamedArrays out;
    with_twin(in, pilot.tick, steps, [&](auto& twin, auto D) {
        twin.controller = pilot;
        SensorsState<double> sensing{};
        const auto go = [&](TwinState<double, D>& state, std::size_t k) {
            const double time = pilot.tick * double(k);
            wish.fresh = time < heard;
            return twin_tick(twin, state, wish, [&](const Readings<double>& truth) {
                const auto sensed = sense(senses, sensing, truth, failing.data(), int(failing.size()), time);
                sensing = sensed.state;
                return sensed.readings;
            });
        };
        out = record_run(twin, ticks, twist, go);
    });
    return out;
}

void bind_twin(nb::module_& m) {
    m.def("tail_acceleration", &tail_accelerations, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("bend"),
          nb::arg("twist"), nb::arg("moment"), nb::arg("clamped"),
          "Accelerations (states, 3 + D) of head and D coordinates, `share` (links, D) of which each joint takes, at "
          "bend (states, 2, D: angle and rate) and twist (states, 3) under moments (states, D) on the coordinates.");
    m.def("run_plant", &run_plant, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("points"),
          nb::arg("grid"), nb::arg("circuits"), nb::arg("hinge"), nb::arg("battery"), nb::arg("idle"),
          nb::arg("clamped"), nb::arg("twist"), nb::arg("target"), nb::arg("tick"), nb::arg("steps"),
          "Drive the servos to targets (ticks, 2 joints), each held for a tick: the record of a run, one row a tick.");
    m.def(
        "run_twin", &run_twin, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("points"), nb::arg("grid"),
        nb::arg("circuits"), nb::arg("hinge"), nb::arg("battery"), nb::arg("idle"), nb::arg("clamped"),
        nb::arg("twist"), nb::arg("controller"), nb::arg("sensors"), nb::arg("seed"), nb::arg("faults"),
        nb::arg("frequency"), nb::arg("command"), nb::arg("heard"), nb::arg("ticks"), nb::arg("steps"),
        "Run plant, sensors and controller under one command, rows amplitude, phase and bias (3, joints), heard until "
        "a time: the record of a run, one row a tick; `ticks` says how many were made.");
}

}  // namespace hypertuna
