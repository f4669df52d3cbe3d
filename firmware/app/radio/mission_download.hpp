/// The mission on board as a list of items, in the form in which they were given: the same number, frames and values.
#pragma once

#include "app/radio/positions.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint16_t item_command[] = {HYPERTUNA_CMD_BOUNDS,
                                                 HYPERTUNA_CMD_DECLINATION,
                                                 MAV_CMD_DO_SET_HOME,
                                                 MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
                                                 MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
                                                 MAV_CMD_DO_CHANGE_SPEED,
                                                 MAV_CMD_NAV_WAYPOINT,
                                                 MAV_CMD_NAV_RETURN_TO_LAUNCH};  // command of each ItemKind

using Item = mavlink_mission_item_int_t;

inline void put_place(Item& item, const Origin& origin, const Place& at, float depth = 0.0f) {
    if (item.frame == local_frame) {
        item.x = whole<std::int32_t>(at.y, 1e4f), item.y = whole<std::int32_t>(at.x, 1e4f), item.z = depth;
    } else {
        const Degrees degrees = degrees_of(origin, at);
        item.x = degrees.latitude, item.y = degrees.longitude, item.z = 0.0f - depth;
    }
}

/// Write a mission's bounds: depth, reserve, duration, interval of fixes; whether it stays, and whether silence counts
/// below; home's radius [cm] and speed.
inline void put_bounds(Item& item, const Mission<float>& mission) {
    item.param1 = mission.depth_max, item.param2 = mission.reserve;
    item.param3 = mission.duration, item.param4 = mission.surface_every;
    item.x = mission.stay + 2 * mission.silence_below, item.z = mission.home_speed;
    item.y = whole<std::int32_t>(mission.home_radius, 100.0f);
}

inline void put_waypoint(Item& item, const ItemForm& form, const Origin& origin, const Waypoint<float>& to) {
    put_place(item, origin, {to.x, to.y}, to.depth);
    item.param1 = to.hold, item.param2 = form.flags & ItemForm::standard ? 0.0f : to.radius;
}

inline void put_speed(Item& item, const ItemForm& form, float speed) {
    item.param1 = form.flags & ItemForm::ground_speed ? 1.0f : 0.0f, item.param2 = speed;
    item.param3 = form.flags & ItemForm::no_throttle ? -1.0f : 0.0f;
}

/// Item `number` of the mission; `waypoint` and `corner` are the numbers of waypoints and corners before it.
inline Item item_of(const Vehicle& vehicle, int number, int waypoint, int corner) {
    const Mission<float>& mission = vehicle.mission;
    const MissionForm& forms = vehicle.plan.form;
    const ItemForm& form = forms.item[number];
    Item item{};
    item.seq = std::uint16_t(number), item.frame = form.frame, item.autocontinue = 1;
    item.command = item_command[int(form.kind)];
    switch (form.kind) {
        case ItemKind::bounds:
            put_bounds(item, mission);
            break;
        case ItemKind::declination:
            item.param1 = mission.declination * float(180 / pi);
            break;
        case ItemKind::home:
            put_place(item, vehicle.origin, mission.home);
            break;
        case ItemKind::corner:
            item.param1 = float(mission.corners);
            put_place(item, vehicle.origin, mission.corner[corner]);
            break;
        case ItemKind::circle:
            item.param1 = mission.range;
            put_place(item, vehicle.origin, mission.center);
            break;
        case ItemKind::speed:
            put_speed(item, form, waypoint < mission.waypoints ? mission.waypoint[waypoint].speed : forms.last_speed);
            break;
        case ItemKind::waypoint:
            put_waypoint(item, form, vehicle.origin, mission.waypoint[waypoint]);
            break;
        default:
            break;
    }
    float* param[4] = {&item.param1, &item.param2, &item.param3, &item.param4};
    for (int k = 0; k < 4; ++k)
        if (form.flags >> k & 1) *param[k] = std::numeric_limits<float>::quiet_NaN();
    return item;
}

/// Call visit(item) for every item of the mission, and return their number.
template <class Visit>
int visit_items(const Vehicle& vehicle, const Visit& visit) {
    const MissionForm& form = vehicle.plan.form;
    int waypoint = 0, corner = 0;
    for (int k = 0; k < form.items; ++k) {
        visit(item_of(vehicle, k, waypoint, corner));
        waypoint += form.item[k].kind == ItemKind::waypoint, corner += form.item[k].kind == ItemKind::corner;
    }
    return form.items;
}

/// Number of items of the fence: the corners of a polygon, or a circle.
inline int fence_items(const Vehicle& vehicle) {
    const Mission<float>& mission = vehicle.mission;
    return 0 < mission.corners ? mission.corners : 0.0f < mission.range;
}

/// Item `number` of the fence, in a list of its own.
inline Item fence_item(const Vehicle& vehicle, int number) {
    const Mission<float>& mission = vehicle.mission;
    const bool polygon = 0 < mission.corners;
    Item item{};
    item.seq = std::uint16_t(number), item.frame = std::uint8_t(vehicle.plan.form.fence_frame);
    item.mission_type = MAV_MISSION_TYPE_FENCE, item.autocontinue = 1;
    item.command = item_command[int(polygon ? ItemKind::corner : ItemKind::circle)];
    item.param1 = polygon ? float(mission.corners) : mission.range;
    put_place(item, vehicle.origin, polygon ? mission.corner[number] : mission.center);
    return item;
}

/// Number of the waypoint of an item, or of the next waypoint after it.
inline int leg_of_item(const Vehicle& vehicle, int number) {
    int leg = 0;
    for (int k = 0; k < number && k < vehicle.plan.form.items; ++k)
        leg += vehicle.plan.form.item[k].kind == ItemKind::waypoint;
    return number < vehicle.plan.form.items ? leg : -1;
}

/// Number of the mission or of the fence on board; 0 for none, and for other types.
inline std::uint32_t plan_number(const Vehicle& vehicle, std::uint8_t type) {
    return type == MAV_MISSION_TYPE_MISSION ? vehicle.numbers.mission
           : type == MAV_MISSION_TYPE_FENCE ? vehicle.numbers.fence
                                            : 0;
}

/// Current item: the waypoint that the robot swims to.
inline mavlink_mission_current_t mission_current(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    const MissionForm& form = vehicle.plan.form;
    mavlink_mission_current_t m{};
    m.total = std::uint16_t(form.items);
    m.mission_id = vehicle.numbers.mission, m.fence_id = vehicle.numbers.fence;
    int waypoints = 0;
    for (int k = 0; k < form.items; ++k)
        if (form.item[k].kind == ItemKind::waypoint && waypoints++ <= vehicle.leg) m.seq = std::uint16_t(k);
    const bool runs = now.state == State::mission, done = now.mode == Mode::done;
    m.mission_state = MISSION_STATE_NO_MISSION;
    if (0 < m.total) m.mission_state = MISSION_STATE_NOT_STARTED;
    if (0 < m.total && runs) m.mission_state = MISSION_STATE_ACTIVE;
    if (0 < m.total && now.state == State::paused) m.mission_state = MISSION_STATE_PAUSED;
    if (0 < m.total && done) m.mission_state = MISSION_STATE_COMPLETE;
    return m;
}

}  // namespace hypertuna::firmware
