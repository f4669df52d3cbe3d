/// Items of an uploaded mission or fence (mission_download.hpp has those on board), checked one after another.
///
/// Places are in MAV_FRAME_LOCAL_NED, m north, east and down from the origin, or in degrees, which the origin turns
/// into m; altitudes are relative to the water's surface (positions.hpp). A number that an item does not use may be
/// NaN.
#pragma once

#include "app/radio/radio_state.hpp"

namespace hypertuna::firmware {

inline constexpr float local_step = 1e-4f;  // m per step of an item's x and y

/// Defaults, as in a mission file [m/s, m, m, 1].
inline constexpr float standard_speed = 0.3f, standard_radius = 3.0f, standard_depth = 5.0f, standard_reserve = 0.1f;

/// Begin the upload of a mission, which keeps the fence on board unless it brings its own, or of a fence for the
/// mission on board.
inline void begin_upload(Upload& upload, const Vehicle& vehicle) {
    const Mission<float>& old = mission(vehicle);
    Mission<float>& mission = upload.mission;
    for (int k = 0; k < old.waypoints; ++k) upload.waypoint[k] = old.waypoint[k];
    for (int k = 0; k < old.corners; ++k) upload.corner[k] = old.corner[k];
    mission = old, upload.form = vehicle.plan.form, upload.fenced = false;
    mission.waypoint = upload.waypoint, mission.corner = upload.corner;
    if (upload.fence) {
        mission.corners = 0, mission.range = 0.0f, upload.form.drop_fence();
        return;
    }
    if (upload.form.has_fence()) upload.form.fence_frame = local_frame;
    upload.form.items = 0, mission.waypoints = 0;
    mission.start = here(vehicle), mission.home = own_home(vehicle);
    mission.home_radius = standard_radius, mission.home_speed = standard_speed;
    mission.depth_max = standard_depth, mission.reserve = standard_reserve;
    mission.duration = mission.surface_every = mission.declination = 0.0f;
    mission.stay = mission.silence_below = false;
    upload.speed = standard_speed;
}

inline bool is_global(std::uint8_t frame) {
    return frame == MAV_FRAME_GLOBAL || frame == MAV_FRAME_GLOBAL_RELATIVE_ALT || frame == MAV_FRAME_GLOBAL_INT ||
           frame == MAV_FRAME_GLOBAL_RELATIVE_ALT_INT;
}

/// Depth of an item: z is down in the local frame, and up in the others.
inline float depth_of(const Item& m) { return m.frame == local_frame ? m.z : 0.0f - m.z; }

inline int kind_of_command(std::uint16_t command) {
    for (int k = 0; k <= int(ItemKind::go_home); ++k)
        if (item_command[k] == command) return k;
    return -1;
}

inline bool has_place(ItemKind kind) {
    return kind == ItemKind::waypoint || kind == ItemKind::home || kind == ItemKind::corner || kind == ItemKind::circle;
}

/// Position of an item [m east and north], or why it has none.
inline Breach place_of(const Vehicle& vehicle, const Item& m, Place& place) {
    if (m.frame == local_frame) {
        place = {float(m.y) * local_step, float(m.x) * local_step};
        return {};
    }
    if (!is_global(m.frame)) return {Refusal::bad_frame};
    if (!is_place(m.x, m.y)) {
        Breach breach = first_breach({{"latitude", " deg", 1e-7f * float(m.x), -89.99f, 89.99f},
                                      {"longitude", " deg", 1e-7f * float(m.y), -180.0f, 180.0f}});
        breach.refusal = Refusal::out_of_range;  // also where only the last digit of the integer is beyond the range
        return breach;
    }
    if (!origin(vehicle).known) return {Refusal::not_placed};
    place = local(origin(vehicle), m.x, m.y);
    return {};
}

inline Breach add_waypoint(Upload& upload, ItemForm& form, const Item& m, const Place& place) {
    Mission<float>& mission = upload.mission;
    if (mission.waypoints == max_waypoints)
        return {Refusal::too_many, -1, "waypoints", "", max_waypoints + 1, max_waypoints};
    const bool standard = m.param2 == 0.0f;
    if (standard) form.flags |= ItemForm::standard;
    Waypoint<float>& to = upload.waypoint[mission.waypoints++];
    to = {place.x, place.y, depth_of(m), upload.speed, standard ? standard_radius : m.param2, m.param1};
    return check_ranges(to, mission.waypoints - 1);
}

/// Add a corner or a circle, which replaces the fence on board.
inline Breach add_fence(Upload& upload, ItemKind kind, const Item& m, const Place& place) {
    Mission<float>& mission = upload.mission;
    if (!upload.fenced) mission.corners = 0, mission.range = 0.0f, upload.form.fence_frame = m.frame;
    upload.fenced = true;
    const bool circle = kind == ItemKind::circle;
    // Each corner of a polygon names the number of its corners.
    if (0.0f < mission.range || (circle && 0 < mission.corners)) return {Refusal::one_fence};
    if (0 < mission.corners && m.param1 != upload.corners) return {Refusal::one_fence};
    if (mission.corners == max_corners) return {Refusal::too_many, -1, "corners", "", max_corners + 1, max_corners};
    const Breach breach = first_breach({{circle ? "radius" : "corners", "", m.param1, least, 1e6f}});
    if (breach != Refusal::none) return breach;
    if (circle)
        mission.center = place, mission.range = m.param1;
    else if (0 < mission.corners && float(mission.corners) == upload.corners)
        return {Refusal::one_fence};
    else
        upload.corner[mission.corners++] = place, upload.corners = m.param1;
    return {};
}

inline Breach set_speed(Upload& upload, ItemForm& form, const Item& m) {
    const Breach breach = first_breach({{"speed", " m/s", m.param2, least, 10.0f}});
    if (breach != Refusal::none) return breach;
    if (m.param1 == 1.0f) form.flags |= ItemForm::ground_speed;
    if (m.param3 == -1.0f) form.flags |= ItemForm::no_throttle;
    upload.speed = upload.form.last_speed = m.param2;
    return {};
}

inline void set_bounds(Mission<float>& mission, const Item& m) {
    if (0.0f < m.param1) mission.depth_max = m.param1;
    if (0.0f < m.param2) mission.reserve = m.param2;
    mission.duration = m.param3, mission.surface_every = m.param4, mission.stay = (m.x & 1) != 0;
    mission.silence_below = (m.x & 2) != 0;
    if (0 < m.y) mission.home_radius = 0.01f * float(m.y);
    if (0.0f < m.z) mission.home_speed = m.z;
}

/// Note which numbers of an item are NaN, and replace them by zero. A place without a depth is refused.
inline Breach drop_nan(Item& m, ItemForm& form, ItemKind kind) {
    float* param[4] = {&m.param1, &m.param2, &m.param3, &m.param4};
    for (int k = 0; k < 4; ++k) {
        if (is_finite(*param[k])) continue;
        form.flags = std::uint8_t(form.flags | ItemForm::no_number << k), *param[k] = 0.0f;
    }
    const bool needs_height = kind == ItemKind::waypoint || kind == ItemKind::bounds;
    const Breach breach = needs_height ? first_breach({{"altitude", " m", m.z, -1e9f, 1e9f}}) : Breach{};
    if (!is_finite(m.z)) m.z = 0.0f;
    return breach;
}

/// Add an item to the mission or the fence being uploaded.
inline Breach add_item(Upload& upload, const Vehicle& vehicle, Item m) {
    const int number = kind_of_command(m.command);
    const bool excludes =
        m.command == MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION || m.command == MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION;
    if (excludes) return {Refusal::one_fence};
    const ItemKind kind = ItemKind(number);
    const bool of_fence = kind == ItemKind::corner || kind == ItemKind::circle;
    if (number < 0 || (upload.fence && !of_fence)) return {Refusal::not_taken};
    ItemForm form{kind, m.frame, 0};
    Breach breach = drop_nan(m, form, kind);
    if (kind == ItemKind::home && m.param1 == 1.0f) {  // the current position
        m.frame = form.frame = local_frame;
        m.x = whole<std::int32_t>(here(vehicle).y, 1e4f), m.y = whole<std::int32_t>(here(vehicle).x, 1e4f);
    }
    Place place{};
    if (breach == Refusal::none && has_place(kind)) breach = place_of(vehicle, m, place);
    Mission<float>& mission = upload.mission;
    if (breach != Refusal::none) return breach;
    if (kind == ItemKind::waypoint) breach = add_waypoint(upload, form, m, place);
    if (of_fence) breach = add_fence(upload, kind, m, place);
    if (kind == ItemKind::speed) breach = set_speed(upload, form, m);
    if (kind == ItemKind::bounds) set_bounds(mission, m);
    if (kind == ItemKind::home) mission.home = place;
    if (kind == ItemKind::declination) mission.declination = m.param1 * float(pi / 180);
    if (breach == Refusal::none && !upload.fence) upload.form.item[upload.form.items++] = form;
    return breach;
}

/// Check that the way home, if it is an item, is the last one, of a mission that does not stay.
inline Refusal check_end(const Upload& upload) {
    const MissionForm& form = upload.form;
    for (int k = 0; k < form.items; ++k)
        if (form.item[k].kind == ItemKind::go_home && (k + 1 < form.items || upload.mission.stay))
            return Refusal::way_home;
    return Refusal::none;
}

}  // namespace hypertuna::firmware
