/// Record of a run: one row every few ticks, with the state at a tick's start and the quantities of that tick.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "hypertuna/simulation/twin6.hpp"

namespace hypertuna {

struct RecordColumn {
    std::string name;
    std::size_t width;  // numbers in a row
    bool scalar;        // a number, not a vector of one
    std::vector<double> values;
};

struct Record {
    std::vector<RecordColumn> columns;
    std::size_t ticks = 0;  // number of ticks that were made
};

/// Number of a column's numbers in a row.
enum class Extent { one, two, three, four, coordinates, joints, circuits, servos, conditions };

constexpr std::size_t extent_of(Extent extent, int coordinates, int joints) {
    switch (extent) {
        case Extent::coordinates:
            return coordinates;
        case Extent::joints:
            return joints;
        case Extent::circuits:
            return 2 * joints;
        case Extent::servos:
            return servos_of(joints);
        case Extent::conditions:
            return conditions;
        default:
            return std::size_t(extent) + 1;
    }
}

/// A column's name and extent, and a function that returns its i-th number; `Source...` is the data of a row.
template <class... Source>
struct Recorded {
    const char* name;
    Extent extent;
    double (*of)(const Source&..., int);
};

/// Append a column of zeros; not inlined, because many tables call it.
HYPERTUNA_NOINLINE inline void add_column(Record& record, const char* name, Extent extent, std::size_t rows,
                                          int coordinates, int joints) {
    const std::size_t width = extent_of(extent, coordinates, joints);
    record.columns.push_back({name, width, extent == Extent::one, std::vector<double>(rows * width)});
}

/// Append columns of zeros for a number of rows; returns the place of the first one.
template <class Table>
std::size_t add_columns(Record& record, const Table& table, std::size_t rows, int coordinates, int joints) {
    const std::size_t first = record.columns.size();
    for (const auto& column : table) add_column(record, column.name, column.extent, rows, coordinates, joints);
    return first;
}

/// Write a row into the columns from the place `first`.
template <class Table, class... Source>
void write_row(Record& record, std::size_t first, const Table& table, std::size_t row, const Source&... source) {
    for (const auto& column : table) {
        RecordColumn& to = record.columns[first++];
        for (std::size_t i = 0; i < to.width; ++i) to.values[to.width * row + i] = column.of(source..., int(i));
    }
}

#define HYPERTUNA_COLUMN(name, extent, value) \
    {name, Extent::extent,                    \
     [](const State& at, const Tick& tick, int i) -> double { return (void)at, (void)tick, (void)i, value; }}

#define HYPERTUNA_LOSS(name, from, sentence) HYPERTUNA_COLUMN("loss_" #name, one, tick.losses.name),

/// Component of a quaternion: w, x, y or z.
inline double number(const Quaternion<double>& q, int i) {
    return i == 0 ? q.w : component(Vector<double>{q.x, q.y, q.z}, i - 1);
}

/// Columns of a twin's run: the head's motion, in the plane or in space, and the quantities within the robot.
template <int D, class Space>
struct TwinColumns {
    using State = TwinState<double, D, Space>;
    using Tick = hypertuna::Tick<double, D, Space>;
    using Column = Recorded<State, Tick>;

    static auto head() {
        if constexpr (std::is_same_v<Space, InPlane>)
            return std::to_array<Column>({
                HYPERTUNA_COLUMN("x", one, at.plant.pose.x),
                HYPERTUNA_COLUMN("y", one, at.plant.pose.y),
                HYPERTUNA_COLUMN("heading", one, at.plant.pose.heading),
                HYPERTUNA_COLUMN("surge", one, at.plant.xi.x),
                HYPERTUNA_COLUMN("sway", one, at.plant.xi.y),
                HYPERTUNA_COLUMN("yaw", one, at.plant.xi.z),
            });
        else
            return std::to_array<Column>({
                HYPERTUNA_COLUMN("position", three, component(at.plant.pose.position, i)),
                HYPERTUNA_COLUMN("attitude", four, number(at.plant.pose.attitude, i)),
                HYPERTUNA_COLUMN("velocity", three, component(at.plant.xi.linear, i)),
                HYPERTUNA_COLUMN("turn_rate", three, component(at.plant.xi.angular, i)),
                HYPERTUNA_COLUMN("fin", two, at.plant.pose.fin[i]),
                HYPERTUNA_COLUMN("fin_target", two, at.targets.fin[i]),
                HYPERTUNA_COLUMN("rate_measured", three, tick.readings.robot.rate[i]),
                HYPERTUNA_COLUMN("acceleration_measured", three, tick.readings.robot.acceleration[i]),
                HYPERTUNA_COLUMN("charge", one, at.taken),
            });
    }
    static auto robot() {
        return std::to_array<Column>({
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
            HYPERTUNA_COLUMN("battery_current", one, at.battery.current),
            HYPERTUNA_LOSSES(HYPERTUNA_LOSS) HYPERTUNA_COLUMN("pulse", servos, tick.output.pulse[i]),
            HYPERTUNA_COLUMN("status", one, tick.output.status.flags),
            HYPERTUNA_COLUMN("status_at", conditions, tick.output.status.at[i]),
        });
    }

    /// Add columns for a robot with this number of coordinates, D or fewer.
    static void add(Record& record, std::size_t rows, int coordinates, int joints) {
        add_columns(record, head(), rows, coordinates, joints);
        add_columns(record, robot(), rows, coordinates, joints);
    }
    static void write(Record& record, std::size_t row, const State& state, const Tick& tick) {
        write_row(record, 0, head(), row, state, tick);
        write_row(record, head().size(), robot(), row, state, tick);
    }
};
#undef HYPERTUNA_LOSS
#undef HYPERTUNA_COLUMN

#define HYPERTUNA_COLUMN(name, extent, value)                                   \
    {name, Extent::extent, [](const PilotStep<double>& step, int i) -> double { \
         const Estimate<double>& at = step.estimate;                            \
         return (void)at, (void)i, value;                                       \
     }}
/// Columns of the pilot's results in a tick.
inline constexpr auto pilot_columns = std::to_array<Recorded<PilotStep<double>>>({
    HYPERTUNA_COLUMN("attitude_estimated", four, number(at.q, i)),
    HYPERTUNA_COLUMN("position_estimated", two, i == 0 ? at.x : at.y),
    HYPERTUNA_COLUMN("depth_estimated", one, at.depth),
    HYPERTUNA_COLUMN("speed_estimated", one, at.speed),
    HYPERTUNA_COLUMN("current_estimated", two, at.current[i]),
    HYPERTUNA_COLUMN("factor_estimated", one, at.factor),
    HYPERTUNA_COLUMN("position_error", one, at.position_error),
    HYPERTUNA_COLUMN("frequency_commanded", one, step.command.frequency),
    HYPERTUNA_COLUMN("bias_commanded", joints, step.command.bias[i]),
    HYPERTUNA_COLUMN("fin_commanded", two, step.command.fin[i]),
    HYPERTUNA_COLUMN("mode", one, double(int(step.mode))),
    HYPERTUNA_COLUMN("reasons", one, double(step.reasons.flags)),
    HYPERTUNA_COLUMN("leg", one, double(step.state.guidance.leg)),
    HYPERTUNA_COLUMN("reached", one, double(step.state.guidance.reached)),
    HYPERTUNA_COLUMN("passed", one, double(step.state.guidance.passed)),
});
#undef HYPERTUNA_COLUMN

}  // namespace hypertuna
