/// Missions in non-volatile memory: plain words without pointers, and the checks of a mission.
#pragma once

#include <cstddef>
#include <cstring>
#include <initializer_list>

#include "app/vehicle/convert.hpp"
#include "app/vehicle/refusal.hpp"
#include "app/vehicle/store.hpp"

namespace hypertuna::firmware {

inline constexpr int max_waypoints = 64, max_corners = 32;
inline constexpr int max_items = 2 * max_waypoints + max_corners + 4;
inline constexpr float max_hold = 86400.0f;  // s: longest time to stay at a waypoint
inline constexpr std::uint32_t mission_layout =
    0x6d697304;  // layout of StoredMission: data of another layout is ignored

/// Kinds of items of a mission in MAVLink.
enum class ItemKind : std::uint8_t { bounds, declination, home, corner, circle, speed, waypoint, go_home };
inline constexpr int local_frame = 1;  // MAV_FRAME_LOCAL_NED

/// Form in which an item was given, so that it is sent back the same; its values are in the mission.
struct ItemForm {
    ItemKind kind;
    std::uint8_t frame, flags;  // MAV_FRAME; the bits below

    static constexpr std::uint8_t no_number = 1;  // bit k - 1: param k was NaN
    static constexpr std::uint8_t standard = 16, ground_speed = 32, no_throttle = 64;
};

/// Forms of a mission's items, and the frame of a fence that was uploaded apart.
struct MissionForm {
    std::int32_t items;
    float last_speed;  // m/s, from a speed item behind the last waypoint
    ItemForm item[max_items];
    std::int32_t fence_frame;

    bool has(ItemKind kind) const {
        for (int k = 0; k < items; ++k)
            if (item[k].kind == kind) return true;
        return false;
    }
    bool has_fence() const { return has(ItemKind::corner) || has(ItemKind::circle); }
    /// Remove the items of the fence.
    void drop_fence() {
        int kept = 0;
        for (int k = 0; k < items; ++k)
            if (item[k].kind != ItemKind::corner && item[k].kind != ItemKind::circle) item[kept++] = item[k];
        items = kept;
    }
};
static_assert(sizeof(MissionForm) == 4 * 3 + 3 * max_items);

/// The form in which a mission is sent that was not received as items: bounds, declination, home, fence, then speeds
/// and waypoints in order.
inline void standard_form(MissionForm& form, const Mission<float>& mission) {
    form = {};
    form.fence_frame = local_frame;
    const auto add = [&](ItemKind kind, int count = 1) {
        for (int k = 0; k < count; ++k) form.item[form.items++] = {kind, local_frame, 0};
    };
    if (mission.waypoints == 0) return;
    add(ItemKind::bounds), add(ItemKind::declination, mission.declination != 0.0f), add(ItemKind::home);
    add(ItemKind::corner, mission.corners), add(ItemKind::circle, mission.corners == 0 && 0.0f < mission.range);
    for (int k = 0; k < mission.waypoints; ++k) {
        const bool changes = k == 0 || mission.waypoint[k].speed != mission.waypoint[k - 1].speed;
        add(ItemKind::speed, changes), add(ItemKind::waypoint);
    }
}

/// A mission without pointers; its fence, from `form.fence_frame` on; and the origin of its coordinates.
struct StoredMission {
    std::int32_t waypoints, stay, silence_below;
    Corner<float> home;
    float home_radius, home_speed, depth_max, reserve, duration, surface_every, declination;
    Waypoint<float> waypoint[max_waypoints];
    MissionForm form;
    std::int32_t corners;
    Corner<float> center;
    float range;
    Corner<float> corner[max_corners];
    std::int32_t latitude, longitude, has_origin;  // origin [1e-7 deg], if known
};
static_assert(sizeof(StoredMission) == 4 * (7 + 4 + 8 + 6 * max_waypoints + 2 * max_corners) + sizeof(MissionForm));

/// Numbers that identify the mission and the fence on board: they differ after any change; 0 for none.
struct PlanNumbers {
    std::uint32_t mission, fence;
};

/// Numbers of a plan. A fence among the mission's items is a part of the mission.
inline PlanNumbers numbers_of(const StoredMission& plan) {
    constexpr int fence_at = int(offsetof(StoredMission, form) + offsetof(MissionForm, fence_frame));
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&plan);
    const std::uint32_t fence = crc32(bytes + fence_at, int(offsetof(StoredMission, latitude)) - fence_at);
    const std::uint32_t mission = crc32(bytes, fence_at, plan.form.has_fence() ? fence : 0);
    const bool fenced = 0 < plan.corners || 0.0f < plan.range;
    return {0 < plan.form.items ? mission | 1 : 0, fenced ? fence | 1 : 0};
}

/// View of a stored mission: waypoints and corners are not copied.
inline Mission<float> mission_of(const StoredMission& stored) {
    return {stored.waypoint,
            stored.waypoints,
            stored.corner,
            stored.corners,
            stored.center,
            stored.range,
            {},
            stored.home,
            stored.home_radius,
            stored.home_speed,
            stored.depth_max,
            stored.reserve,
            stored.duration,
            stored.surface_every,
            stored.stay != 0,
            stored.silence_below != 0,
            stored.declination};
}

/// Copy a mission without its origin; `form` of its items, if it was uploaded.
inline void pack_mission(StoredMission& stored, const Mission<float>& m, const MissionForm* form = nullptr) {
    std::memset(static_cast<void*>(&stored), 0, sizeof(stored));
    stored.waypoints = m.waypoints, stored.corners = m.corners, stored.stay = m.stay;
    stored.silence_below = m.silence_below, stored.declination = m.declination;
    stored.center = m.center, stored.home = m.home, stored.range = m.range;
    stored.home_radius = m.home_radius, stored.home_speed = m.home_speed, stored.depth_max = m.depth_max;
    stored.reserve = m.reserve, stored.duration = m.duration, stored.surface_every = m.surface_every;
    for (int k = 0; k < m.waypoints; ++k) stored.waypoint[k] = m.waypoint[k];
    for (int k = 0; k < m.corners; ++k) stored.corner[k] = m.corner[k];
    if (form != nullptr)
        stored.form = *form;
    else
        standard_form(stored.form, m);
}

/// Whether a mission of this size fits.
inline bool fits(int waypoints, int corners) {
    return 0 <= waypoints && waypoints <= max_waypoints && 0 <= corners && corners <= max_corners;
}

/// Whether there is an item for every waypoint, and for every corner of a fence among the items.
inline bool is_valid(const MissionForm& form, int waypoints, int corners) {
    if (form.items < 0 || max_items < form.items) return false;
    int count[int(ItemKind::go_home) + 1] = {};
    for (int k = 0; k < form.items; ++k) {
        if (ItemKind::go_home < form.item[k].kind) return false;
        ++count[int(form.item[k].kind)];
    }
    const int cornered = count[int(ItemKind::corner)];
    return count[int(ItemKind::waypoint)] == waypoints && (cornered == 0 || cornered == corners);
}

/// Whether a place is within 100 km of the origin.
inline bool is_near(float x, float y) { return abs(x) < 1e5f && abs(y) < 1e5f; }

/// A quantity beyond its bound, of a waypoint or (-1) of the mission as a whole.
struct Breach {
    Refusal refusal = Refusal::none;  // none: nothing is beyond its bound
    int waypoint = -1;
    const char *quantity = nullptr, *unit = nullptr;  // null where the refusal needs no more words
    float value = 0, bound = 0;

    operator Refusal() const { return refusal; }
};
inline constexpr float least = 0.01f;  // smallest speed [m/s] and radius [m]

/// A quantity and its range; NaN is beyond every range.
struct Ranged {
    const char *quantity, *unit;
    float value, low, high;
};
HYPERTUNA_NOINLINE inline Breach first_breach(std::initializer_list<Ranged> all, int waypoint = -1) {
    for (const auto& [quantity, unit, value, low, high] : all)
        if (!(low <= value && value <= high))
            return {Refusal::out_of_range, waypoint, quantity, unit, value, value < low ? low : high};
    return {};
}

/// Return the first number of waypoint `k` beyond its range. Depth is a negative altitude.
HYPERTUNA_NOINLINE inline Breach check_ranges(const Waypoint<float>& to, int k) {
    return first_breach({{"above the water: altitude", " m", 0.0f - to.depth, -1e4f, 0.0f},
                         {"east of the origin", " m", to.x, -1e5f, 1e5f},
                         {"north of the origin", " m", to.y, -1e5f, 1e5f},
                         {"speed", " m/s", to.speed, least, 10.0f},
                         {"radius", " m", to.radius, least, 1e5f},
                         {"time to stay", " s", to.hold, 0.0f, max_hold}},
                        k);
}

/// Return the first number of a mission beyond its range. A fence is a polygon or a circle, not both.
HYPERTUNA_NOINLINE inline Breach check_ranges(const Mission<float>& mission) {
    for (int k = 0; k < mission.waypoints; ++k)
        if (const Breach breach = check_ranges(mission.waypoint[k], k); breach != Refusal::none) return breach;
    bool near = is_near(mission.home.x, mission.home.y) && is_near(mission.center.x, mission.center.y);
    for (int k = 0; k < mission.corners; ++k) near = near && is_near(mission.corner[k].x, mission.corner[k].y);
    if (!near || (0 < mission.corners && (mission.corners < 3 || mission.range != 0.0f)))
        return {Refusal::out_of_range};
    return first_breach({{"home radius", " m", mission.home_radius, least, 1e5f},
                         {"home speed", " m/s", mission.home_speed, least, 10.0f},
                         {"limit of depth", " m", mission.depth_max, 0.0f, 1e4f},
                         {"reserve", "", mission.reserve, 0.0f, 1.0f},
                         {"duration", " s", mission.duration, 0.0f, 1e9f},
                         {"fix interval", " s", mission.surface_every, 0.0f, 1e9f},
                         {"declination", " rad", mission.declination, -3.15f, 3.15f},
                         {"fence radius", " m", mission.range, 0.0f, 1e6f}});
}

}  // namespace hypertuna::firmware
