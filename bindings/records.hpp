/// Runs from Python's numbers, and their records as arrays.
#pragma once

#include <optional>

#include "controller.hpp"
#include "hypertuna/host/simulate.hpp"

namespace hypertuna {

inline constexpr std::size_t twist_numbers = 6, pose_numbers = 9;

/// A twist as a row: linear, then angular.
inline SpatialTwist<double> read_twist(const double* row) {
    return {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
}
/// A pose as a row: position, attitude w x y z, fins.
inline Pose6<double> read_pose(const double* row) {
    return {{row[0], row[1], row[2]}, normalized(Quaternion<double>{row[3], row[4], row[5], row[6]}), {row[7], row[8]}};
}

inline NamedArrays arrays_of(Record&& record) {
    NamedArrays out;
    for (RecordColumn& column : record.columns) {
        auto* values = new std::vector<double>(std::move(column.values));
        nb::capsule owner(values, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
        const std::size_t rows = values->size() / column.width, shape[] = {rows, column.width};
        out[column.name.c_str()] = Output(values->data(), column.scalar ? 1 : 2, shape, owner);
    }
    Output ticks = zeros({1});
    ticks.data()[0] = double(record.ticks);
    out["ticks"] = ticks;
    return out;
}

inline Run run_of(std::size_t ticks, std::size_t every, double tick, int steps, const Input<1>& twist,
                  const std::optional<Input<1>>& pose, double charge) {
    check_extent("twist", twist.shape(0), twist_numbers);
    if (pose) check_extent("pose", pose->shape(0), pose_numbers);
    if (every < 1) throw nb::value_error("every: must be one tick or more");
    if (steps < 1) throw nb::value_error("steps: must be one or more");
    return {ticks, every, tick, steps, read_twist(twist.data()), pose ? read_pose(pose->data()) : Pose6<double>{},
            charge};
}

}  // namespace hypertuna
