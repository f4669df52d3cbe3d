/// The mission on board as a list of items: bounds, home, fence, then speeds and waypoints in their order.
#pragma once

#include "app/radio/messages.hpp"

namespace hypertuna::firmware {

inline constexpr int max_items = 2 * max_waypoints + max_corners + 3;

/// Call visit(item) for every item, and return their number. Positions are in MAV_FRAME_LOCAL_NED.
template <class Visit>
int visit_items(const Mission<float>& mission, const Visit& visit) {
    if (mission.waypoints == 0) return 0;
    mavlink_mission_item_int_t item{};
    item.frame = MAV_FRAME_LOCAL_NED, item.autocontinue = 1;
    const auto add = [&](std::uint16_t command, const Corner<float>& at, float z, float first, float second) {
        item.command = command, item.param1 = first, item.param2 = second, item.z = z;
        item.x = whole<std::int32_t>(at.y, 1e4f), item.y = whole<std::int32_t>(at.x, 1e4f);
        visit(item);
        ++item.seq;
    };
    item.param3 = mission.duration, item.param4 = mission.surface_every;
    const Corner<float> rest{0.01f * mission.home_radius,
                             1e-4f * float(mission.stay + 2 * mission.silence_below)};  // 100 cm, 1: as positions
    add(HYPERTUNA_CMD_BOUNDS, rest, mission.home_speed, mission.depth_max, mission.reserve);
    item.param3 = item.param4 = 0.0f;
    if (mission.declination != 0.0f)
        add(HYPERTUNA_CMD_DECLINATION, {}, 0.0f, mission.declination * float(180 / pi), 0.0f);
    add(MAV_CMD_DO_SET_HOME, mission.home, 0.0f, 0.0f, 0.0f);
    for (int k = 0; k < mission.corners; ++k)
        add(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mission.corner[k], 0.0f, float(mission.corners), 0.0f);
    if (mission.corners < 3 && 0.0f < mission.range)
        add(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, mission.center, 0.0f, mission.range, 0.0f);
    float speed = 0.0f;
    for (int k = 0; k < mission.waypoints; ++k) {
        const Waypoint<float>& w = mission.waypoint[k];
        if (w.speed != speed) add(MAV_CMD_DO_CHANGE_SPEED, {}, 0.0f, 0.0f, w.speed);
        speed = w.speed;
        add(MAV_CMD_NAV_WAYPOINT, {w.x, w.y}, w.depth, w.hold, w.radius);
    }
    return item.seq;
}

/// Current item: the waypoint that the robot swims to.
inline mavlink_mission_current_t mission_current(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    mavlink_mission_current_t m{};
    int waypoints = 0;
    m.total = std::uint16_t(visit_items(mission(vehicle), [&](const mavlink_mission_item_int_t& item) {
        if (item.command == MAV_CMD_NAV_WAYPOINT && waypoints++ <= now.leg) m.seq = item.seq;
    }));
    const bool runs = now.state == State::mission, done = now.mode == Mode::done;
    m.mission_state = MISSION_STATE_NO_MISSION;
    if (0 < m.total) m.mission_state = MISSION_STATE_NOT_STARTED;
    if (0 < m.total && runs) m.mission_state = MISSION_STATE_ACTIVE;
    if (0 < m.total && now.state == State::paused) m.mission_state = MISSION_STATE_PAUSED;
    if (0 < m.total && done) m.mission_state = MISSION_STATE_COMPLETE;
    return m;
}

}  // namespace hypertuna::firmware
