/// Checks of a mission as a whole: a ground station may not upload what a mission file may not say (hypertuna.mission).
#pragma once

#include "app/vehicle/parameters.hpp"
#include "app/vehicle/refusal.hpp"
#include "app/vehicle/stored_mission.hpp"

namespace hypertuna::firmware {

using Place = Corner<float>;  // m east and north

/// Whether two line segments cross or touch.
inline bool cross(const Place& a, const Place& b, const Place& c, const Place& d) {
    const auto side = [](const Place& from, const Place& to, const Place& p) {
        return (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x);
    };
    const auto apart = [](float a, float b, float c, float d) {
        return max(a, b) < min(c, d) || max(c, d) < min(a, b);
    };
    if (apart(a.x, b.x, c.x, d.x) || apart(a.y, b.y, c.y, d.y)) return false;
    return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

inline const Place& corner_after(const Mission<float>& mission, int k) {
    return mission.corner[k + 1 < mission.corners ? k + 1 : 0];
}

/// Whether a straight course crosses no side of the fence. A circle holds every course between two places inside it.
inline bool holds_course(const Mission<float>& mission, const Place& from, const Place& to) {
    for (int k = 0; k < mission.corners; ++k)
        if (cross(from, to, mission.corner[k], corner_after(mission, k))) return false;
    return true;
}

/// Distance inside the fence [m].
inline float border_distance(const Mission<float>& mission, const Place& at) {
    return inside(mission, at.x, at.y).distance;
}

inline bool holds(const Mission<float>& mission, const Place& at) { return 0.0f < border_distance(mission, at); }

/// Whether a fence is a polygon whose sides do not cross.
inline bool is_polygon(const Mission<float>& mission) {
    bool has_area = mission.corners == 0;
    for (int i = 0; i < mission.corners; ++i) {
        const Place &a = mission.corner[i], &b = corner_after(mission, i),
                    &c = corner_after(mission, (i + 1) % mission.corners);
        if (a.x == b.x && a.y == b.y) return false;
        has_area = has_area || (b.x - a.x) * (c.y - a.y) != (b.y - a.y) * (c.x - a.x);
        for (int k = i + 2; k < mission.corners; ++k)
            if (k - i != mission.corners - 1 && cross(a, b, mission.corner[k], corner_after(mission, k))) return false;
    }
    return has_area;
}

/// Largest speed of a waypoint, relative to that of the fastest gait, which then is used: tables of speeds differ from
/// robot to robot.
inline constexpr float speed_excess = 2.0f;

/// Depth by which the nose may dip at the surface, and by which it may pass the depth that it dives to [m].
inline constexpr float dip = 0.5f, overshoot = 0.3f;
inline constexpr float rounding = 0.01f;  // m: rounding of places and depths in messages

/// What a robot can do: the largest depth that its sensor reads [m], the largest speed of a waypoint [m/s], the
/// smallest radius that fixes are accurate enough for [m], and the distance from the fence at which it turns [m].
struct Capability {
    float depth, speed, radius, margin;
};
inline Capability capability_of(const Model& model) {
    const Guidance<float>& guidance = model.pilot.guidance;
    const auto& table = guidance.steering.table;
    return {min(model.pilot.estimator.depth_high, model.limits.depth_max), speed_excess * table.speed[table.gaits - 1],
            guidance.error_fix - rounding, guidance.fence_margin - rounding};
}

/// Return why waypoint `k` is refused.
inline Breach check_waypoint(const Mission<float>& mission, int k, const Capability& robot) {
    const Waypoint<float>& to = mission.waypoint[k];
    const float deepest = mission.depth_max - overshoot, room_left = border_distance(mission, {to.x, to.y});
    if (deepest + rounding < to.depth) return {Refusal::too_deep, k, "depth", " m", to.depth, deepest};
    if (robot.speed < to.speed) return {Refusal::too_fast, k, "speed", " m/s", to.speed, robot.speed};
    if (to.radius < robot.radius) return {Refusal::too_small, k, "radius", " m", to.radius, robot.radius};
    if (robot.margin <= room_left) return {};
    return {Refusal::outside_fence, k, "fence margin", " m", room_left, robot.margin};
}

/// Return why a mission as a whole is refused: for its limit of depth, its speed home or its home.
inline Breach check_limits(const Mission<float>& mission, const Capability& robot) {
    const float depth = mission.depth_max, speed = mission.home_speed, radius = mission.home_radius;
    if (robot.depth < depth) return {Refusal::too_deep, -1, "limit of depth", " m", depth, robot.depth};
    if (depth + rounding < dip) return {Refusal::too_deep, -1, "limit of depth", " m", depth, dip};
    if (robot.speed < speed) return {Refusal::too_fast, -1, "home speed", " m/s", speed, robot.speed};
    if (radius < robot.radius) return {Refusal::too_small, -1, "home radius", " m", radius, robot.radius};
    return {holds(mission, mission.home) ? Refusal::none : Refusal::outside_fence};
}

/// Return why a mission is refused: its fence, places and legs outside the fence, depths beyond its limit or beyond the
/// sensor's range, speeds far beyond the fastest gait's, or radii smaller than the error of fixes.
HYPERTUNA_NOINLINE inline Breach check_mission(const Mission<float>& mission, const Capability& robot) {
    if (!is_polygon(mission)) return {Refusal::bad_fence};
    if (mission.waypoints == 0) return {};  // a fence
    if (const Breach breach = check_limits(mission, robot); breach != Refusal::none) return breach;
    Place at{};
    for (int k = 0; k < mission.waypoints; ++k) {
        const Place next{mission.waypoint[k].x, mission.waypoint[k].y};
        if (const Breach breach = check_waypoint(mission, k, robot); breach != Refusal::none) return breach;
        if (k > 0 && !holds_course(mission, at, next)) return {Refusal::leaves_fence, k};
        at = next;
    }
    return {!mission.stay && !holds_course(mission, at, mission.home) ? Refusal::leaves_fence : Refusal::none};
}

/// Return why a mission cannot begin from a place.
inline Refusal check_start(const Mission<float>& mission, const Place& from) {
    if (!holds(mission, from)) return Refusal::robot_outside;
    if (mission.waypoints == 0) return Refusal::none;
    const Place first{mission.waypoint[0].x, mission.waypoint[0].y};
    return holds_course(mission, from, first) ? Refusal::none : Refusal::leaves_fence;
}

}  // namespace hypertuna::firmware
