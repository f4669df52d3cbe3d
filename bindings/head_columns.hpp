/// Columns of the record of a run in space that tell how the head moves.
#pragma once

#include "owned_twin.hpp"
#include "plant6.hpp"

namespace hypertuna {

/// One of w, x, y, z.
inline double number(const Quaternion<double>& q, int i) {
    return i == 0 ? q.w : component(Vector<double>{q.x, q.y, q.z}, i - 1);
}

/// Columns of the head's motion in space.
template <int D, class Space = InSpace>
inline const std::vector<TwinColumn<D, Space>> head_columns = {
    HYPERTUNA_COLUMN("position", three, component(at.plant.pose.position, i)),
    HYPERTUNA_COLUMN("attitude", four, number(at.plant.pose.attitude, i)),
    HYPERTUNA_COLUMN("velocity", three, component(at.plant.xi.linear, i)),
    HYPERTUNA_COLUMN("turn_rate", three, component(at.plant.xi.angular, i)),
    HYPERTUNA_COLUMN("fin", two, at.plant.pose.fin[i]),
    HYPERTUNA_COLUMN("fin_target", two, at.targets.fin[i]),
    HYPERTUNA_COLUMN("rate_measured", three, tick.readings.robot.rate[i]),
    HYPERTUNA_COLUMN("acceleration_measured", three, tick.readings.robot.acceleration[i]),
    HYPERTUNA_COLUMN("charge", one, at.taken),
};

}  // namespace hypertuna
