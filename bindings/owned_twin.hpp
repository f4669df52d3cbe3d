/// A twin with the memory that it needs, and the record of its run: common to those in the plane and in space.
#pragma once

#include <nanobind/stl/tuple.h>

#include <tuple>

#include "controller.hpp"
#include "free_body.hpp"
#include "hypertuna/simulation/twin.hpp"

namespace hypertuna {

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

/// A twin and what it has beside its body.
template <class Body>
struct OwnedTwin {
    std::vector<JointTable<double>> joint;
    std::vector<Circuit<double>> circuit;
    std::vector<double> unit_rest;
    Twin<Body> twin;

    OwnedTwin(const Body& body, const PlantInput& in, double tick, int steps) {
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
        twin.plant = {body,
                      static_cast<int>(joint.size()),
                      joint.data(),
                      circuit.data(),
                      unit_rest.data(),
                      {in.hinge.data()[0], in.hinge.data()[1]}};
        twin.battery = read_battery<double>(in.battery.data());
        twin.idle = in.idle;
        twin.step = tick / steps;
        twin.steps = steps;
    }
    OwnedTwin(const OwnedTwin&) = delete;
    OwnedTwin& operator=(const OwnedTwin&) = delete;
};

inline void check_plant(const PlantInput& in) {
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

using FaultRow = std::tuple<std::string, int, int, double, double>;

inline std::vector<Fault<double>> read_faults(const std::vector<FaultRow>& rows) {
    std::vector<Fault<double>> found;
    for (const auto& [kind, first, last, start, end] : rows)
        found.push_back({fault_kind(kind), first, last, start, end});
    return found;
}

/// An armed command from its frequency and its rows amplitude, phase and bias (3, joints).
inline Command<double> read_command(double frequency, const Input<2>& rows, int joints) {
    check_extent("command", rows.shape(0), 3);
    check_extent("command", rows.shape(1), joints);
    Command<double> wish{};
    wish.frequency = frequency;
    wish.armed = true;
    std::copy(rows.data(), rows.data() + joints, wish.amplitude);
    std::copy(rows.data() + joints, rows.data() + 2 * joints, wish.phase);
    std::copy(rows.data() + 2 * joints, rows.data() + 3 * joints, wish.bias);
    return wish;
}

/// How many numbers a column of the record has in each tick.
enum class Extent { one, two, three, four, coordinates, joints, circuits, servos, conditions };

/// One column of the record of a run: the state at a tick's start, and what passed in the tick.
template <int D, class Space>
struct TwinColumn {
    const char* name;
    Extent extent;
    double (*of)(const TwinState<double, D, Space>&, const Tick<double, D, Space>&, int);
};
#define HYPERTUNA_COLUMN(name, extent, value)                                                                \
    TwinColumn<D, Space> {                                                                                   \
        name, Extent::extent,                                                                                \
            [](const TwinState<double, D, Space>& at, const Tick<double, D, Space>& tick, int i) -> double { \
                return (void)at, (void)tick, (void)i, value;                                                 \
            }                                                                                                \
    }

/// Columns of what is not the head's motion.
template <int D, class Space>
inline const std::vector<TwinColumn<D, Space>> inner_columns = {
    HYPERTUNA_COLUMN("angle", coordinates, at.plant.bend.angle[i]),
    HYPERTUNA_COLUMN("rate", coordinates, at.plant.bend.rate[i]),
    HYPERTUNA_COLUMN("moment", coordinates, tick.seen.moment[i]),
    HYPERTUNA_COLUMN("angle_measured", joints, of_robot(tick.readings).bend[i]),
    HYPERTUNA_COLUMN("angle_set", joints, tick.output.set[i]),
    HYPERTUNA_COLUMN("pump_pressure", circuits, tick.seen.circuit[i].pump.pressure),
    HYPERTUNA_COLUMN("unit_pressure", circuits, tick.seen.circuit[i].unit.pressure),
    HYPERTUNA_COLUMN("pump_pressure_high", circuits, tick.pump[i].high),
    HYPERTUNA_COLUMN("pump_pressure_low", circuits, tick.pump[i].low),
    HYPERTUNA_COLUMN("unit_pressure_high", circuits, tick.unit[i].high),
    HYPERTUNA_COLUMN("unit_pressure_low", circuits, tick.unit[i].low),
    HYPERTUNA_COLUMN("pressure_measured", circuits, of_robot(tick.readings).pressure[i]),
    HYPERTUNA_COLUMN("servo_target", circuits, at.targets.angle[i]),
    HYPERTUNA_COLUMN("servo_angle", circuits, at.plant.circuit[i].angle),
    HYPERTUNA_COLUMN("servo_rate", circuits, at.plant.circuit[i].rate),
    HYPERTUNA_COLUMN("servo_torque", circuits, tick.seen.circuit[i].torque),
    HYPERTUNA_COLUMN("flow", circuits, at.plant.circuit[i].flow),
    HYPERTUNA_COLUMN("electrical_power", circuits, tick.power[i]),
    HYPERTUNA_COLUMN("current", circuits, of_robot(tick.readings).current[i]),
    HYPERTUNA_COLUMN("power", one, tick.servo_power),
    HYPERTUNA_COLUMN("battery_voltage", one, at.battery.voltage),
    HYPERTUNA_COLUMN("pulse", servos, tick.output.pulse[i]),
    HYPERTUNA_COLUMN("status", one, tick.output.status.flags),
    HYPERTUNA_COLUMN("status_at", conditions, tick.output.status.at[i]),
};

inline std::size_t extent_of(Extent extent, std::size_t coordinates, std::size_t joints) {
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
        case Extent::two:
            return 2;
        case Extent::three:
            return 3;
        case Extent::four:
            return 4;
        default:
            return 1;
    }
}

/// Run a twin for so many ticks and record every so many of them, and the columns of the head's motion beside the
/// others; ends early where the plant's state is none that a robot can have. go(state, k) makes tick k.
template <class Body, class Head, class Go>
NamedArrays record_run(const Twin<Body>& twin, std::size_t ticks, std::size_t every, TwinStateOf<Body> state,
                       const Head& head, const Go& go) {
    constexpr int D = Body::coordinates;
    using Space = typename Body::Space;
    const std::size_t joints = twin.plant.joints, rows = (ticks + every - 1) / every;
    std::vector<TwinColumn<D, Space>> columns(head.begin(), head.end());
    columns.insert(columns.end(), inner_columns<D, Space>.begin(), inner_columns<D, Space>.end());
    std::vector<Output> record;
    for (const TwinColumn<D, Space>& column : columns) {
        const std::size_t extent = extent_of(column.extent, D, joints);
        record.push_back(column.extent == Extent::one ? zeros({rows}) : zeros({rows, extent}));
    }
    std::size_t done = 0;
    {
        const nb::gil_scoped_release unlocked;
        for (; done < ticks && plausible(state.plant); ++done) {
            const PlantStateOf<Body> start = state.plant;
            const TickOf<Body> tick = go(state, done);
            if (done % every != 0) continue;
            TwinStateOf<Body> shown = state;
            shown.plant = start;
            for (std::size_t c = 0; c < columns.size(); ++c) {
                const std::size_t extent = extent_of(columns[c].extent, D, joints);
                double* row = record[c].data() + extent * (done / every);
                for (std::size_t i = 0; i < extent; ++i) row[i] = columns[c].of(shown, tick, static_cast<int>(i));
            }
        }
    }
    NamedArrays out;
    for (std::size_t c = 0; c < columns.size(); ++c) out[columns[c].name] = record[c];
    Output ended = zeros({1});
    ended.data()[0] = static_cast<double>(done);
    out["ticks"] = ended;
    return out;
}

}  // namespace hypertuna
