/// Missions as they are kept: words alone, so that they last, and what a mission must be to be followed.
#pragma once

#include <cstring>

#include "app/vehicle/convert.hpp"

namespace hypertuna::firmware {

inline constexpr int most_waypoints = 64, most_corners = 32;
inline constexpr std::uint32_t mission_layout = 0x6d697301;  // of KeptMission: another one is not taken

/// A mission without pointers, and where its coordinates count from.
struct KeptMission {
    std::int32_t waypoints, corners, stay;
    std::int32_t latitude, longitude, placed;  // 1e-7 deg of the origin, if it was known
    Corner<float> center, home;
    float range, home_radius, home_speed, depth_most, reserve, duration, surface_every;
    Waypoint<float> waypoint[most_waypoints];
    Corner<float> corner[most_corners];
};
static_assert(sizeof(KeptMission) == 4 * (6 + 4 + 7 + 5 * most_waypoints + 2 * most_corners));

/// The mission that is kept; its waypoints and corners stay where they are.
inline Mission<float> mission_of(const KeptMission& kept) {
    return {kept.waypoint,
            kept.waypoints,
            kept.corner,
            kept.corners,
            kept.center,
            kept.range,
            {},
            kept.home,
            kept.home_radius,
            kept.home_speed,
            kept.depth_most,
            kept.reserve,
            kept.duration,
            kept.surface_every,
            kept.stay != 0};
}

/// Keep a mission, but for where it counts from.
inline void take_mission(KeptMission& kept, const Mission<float>& m) {
    std::memset(static_cast<void*>(&kept), 0, sizeof(kept));
    kept.waypoints = m.waypoints, kept.corners = m.corners, kept.stay = m.stay;
    kept.center = m.center, kept.home = m.home, kept.range = m.range;
    kept.home_radius = m.home_radius, kept.home_speed = m.home_speed, kept.depth_most = m.depth_most;
    kept.reserve = m.reserve, kept.duration = m.duration, kept.surface_every = m.surface_every;
    for (int k = 0; k < m.waypoints; ++k) kept.waypoint[k] = m.waypoint[k];
    for (int k = 0; k < m.corners; ++k) kept.corner[k] = m.corner[k];
}

/// Whether there is room for all of it.
inline bool fits(int waypoints, int corners) {
    return 0 <= waypoints && waypoints <= most_waypoints && 0 <= corners && corners <= most_corners;
}

/// Whether a mission is made of numbers that make sense.
inline bool sound(const Mission<float>& mission) {
    const auto place = [](float x, float y) { return abs(x) < 1e5f && abs(y) < 1e5f; };
    bool good = place(mission.home.x, mission.home.y) && place(mission.center.x, mission.center.y);
    good = good && 0 < mission.home_radius && mission.home_radius < 1e5f && 0 < mission.home_speed;
    good = good && mission.home_speed < 10 && 0 <= mission.depth_most && mission.depth_most < 1e4f;
    good = good && 0 <= mission.reserve && mission.reserve <= 1 && 0 <= mission.duration && 0 <= mission.surface_every;
    good = good && 0 <= mission.range && mission.range < 1e6f;
    for (int k = 0; k < mission.waypoints; ++k) {
        const Waypoint<float>& to = mission.waypoint[k];
        good = good && place(to.x, to.y) && 0 <= to.depth && to.depth < 1e4f && 0 < to.speed && to.speed < 10 &&
               0 < to.radius && to.radius < 1e5f;
    }
    for (int k = 0; k < mission.corners; ++k) good = good && place(mission.corner[k].x, mission.corner[k].y);
    // A fence is a polygon or a circle: the pilot keeps one of them.
    return good && (mission.corners == 0 || (mission.corners >= 3 && mission.range == 0.0f));
}

}  // namespace hypertuna::firmware
