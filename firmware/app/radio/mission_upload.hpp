/// Items of a mission that comes in (mission_list.hpp has those of one on board), one checked after another.
///
/// Places are in MAV_FRAME_LOCAL_NED, m north, east and down of the origin, or in degrees, which the origin turns into
/// m.
#pragma once

#include "app/radio/radio_state.hpp"

namespace hypertuna::firmware {

inline constexpr float local_step = 1e-4f;  // m of an item's x and y

/// Defaults, as in a mission file [m/s, m, m, 1].
inline constexpr float standard_speed = 0.3f, standard_radius = 3.0f, standard_depth = 5.0f, standard_reserve = 0.1f;

inline void begin_mission(Upload& upload, const Snapshot& now) {
    upload.mission = {};
    upload.mission.waypoint = upload.waypoint, upload.mission.corner = upload.corner;
    upload.mission.start = upload.mission.home = {now.estimate.x, now.estimate.y};
    upload.mission.home_radius = standard_radius, upload.mission.home_speed = standard_speed;
    upload.mission.depth_max = standard_depth, upload.mission.reserve = standard_reserve;
    upload.speed = standard_speed;
}

/// Position of an item [m east and north]; false for a frame that is not supported.
inline bool place_of(const Vehicle& vehicle, const mavlink_mission_item_int_t& m, Corner<float>& place) {
    if (m.frame == MAV_FRAME_LOCAL_NED) {
        place = {float(m.y) * local_step, float(m.x) * local_step};
        return true;
    }
    const bool global = m.frame == MAV_FRAME_GLOBAL || m.frame == MAV_FRAME_GLOBAL_RELATIVE_ALT ||
                        m.frame == MAV_FRAME_GLOBAL_INT || m.frame == MAV_FRAME_GLOBAL_RELATIVE_ALT_INT;
    if (!global || !origin(vehicle).known) return false;
    place = local(origin(vehicle), m.x, m.y);
    return true;
}

/// Depth of an item: z is down in the local frame, and up in the others.
inline float depth_of(const mavlink_mission_item_int_t& m) { return m.frame == MAV_FRAME_LOCAL_NED ? m.z : -m.z; }

inline bool has_place(std::uint16_t command) {
    return command == MAV_CMD_NAV_WAYPOINT || command == MAV_CMD_DO_SET_HOME ||
           command == MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION || command == MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION;
}

inline std::uint8_t add_waypoint(Upload& upload, const mavlink_mission_item_int_t& m, const Corner<float>& place) {
    Mission<float>& mission = upload.mission;
    if (mission.waypoints == max_waypoints) return MAV_MISSION_NO_SPACE;
    const float radius = 0.0f < m.param2 ? m.param2 : standard_radius;
    upload.waypoint[mission.waypoints++] = {place.x, place.y, depth_of(m), upload.speed, radius, m.param1};
    return MAV_MISSION_ACCEPTED;
}

inline std::uint8_t add_corner(Upload& upload, const Corner<float>& place) {
    if (upload.mission.corners == max_corners) return MAV_MISSION_NO_SPACE;
    upload.corner[upload.mission.corners++] = place;
    return MAV_MISSION_ACCEPTED;
}

inline std::uint8_t set_bounds(Mission<float>& mission, const mavlink_mission_item_int_t& m) {
    if (0.0f < m.param1) mission.depth_max = m.param1;
    if (0.0f < m.param2) mission.reserve = m.param2;
    mission.duration = m.param3, mission.surface_every = m.param4, mission.stay = (m.x & 1) != 0;
    mission.silence_below = (m.x & 2) != 0;
    if (0 < m.y) mission.home_radius = 0.01f * float(m.y);
    if (0.0f < m.z) mission.home_speed = m.z;
    return MAV_MISSION_ACCEPTED;
}

/// Add an item to the mission being uploaded; return a MAV_MISSION_RESULT.
inline std::uint8_t add_item(Upload& upload, const Vehicle& vehicle, const mavlink_mission_item_int_t& m) {
    Corner<float> place{};
    if (!is_finite(m.param1) || !is_finite(m.param2) || !is_finite(m.param3) || !is_finite(m.z))
        return MAV_MISSION_INVALID;  // param4 may be NaN: no heading
    if (has_place(m.command) && m.frame != MAV_FRAME_LOCAL_NED && !is_place(m.x, m.y))
        return MAV_MISSION_INVALID_PARAM5_X;
    if (has_place(m.command) && !place_of(vehicle, m, place)) return MAV_MISSION_UNSUPPORTED_FRAME;
    Mission<float>& mission = upload.mission;
    switch (m.command) {
        case MAV_CMD_NAV_WAYPOINT:
            return add_waypoint(upload, m, place);
        case MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION:
            return add_corner(upload, place);
        case MAV_CMD_DO_SET_HOME:
            mission.home = place;
            return MAV_MISSION_ACCEPTED;
        case MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION:
            if (!(0.0f < m.param1)) return MAV_MISSION_INVALID_PARAM1;
            mission.center = place, mission.range = m.param1;
            return MAV_MISSION_ACCEPTED;
        case MAV_CMD_DO_CHANGE_SPEED:
            if (!(0.0f < m.param2)) return MAV_MISSION_INVALID_PARAM2;
            upload.speed = m.param2;
            return MAV_MISSION_ACCEPTED;
        case HYPERTUNA_CMD_DECLINATION:
            mission.declination = m.param1 * float(pi / 180);
            return MAV_MISSION_ACCEPTED;
        case HYPERTUNA_CMD_BOUNDS:
            return is_finite(m.param4) ? set_bounds(mission, m) : std::uint8_t(MAV_MISSION_INVALID_PARAM4);
        default:
            return MAV_MISSION_UNSUPPORTED;
    }
}

}  // namespace hypertuna::firmware
