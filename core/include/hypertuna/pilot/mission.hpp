/// Mission: where to go, within which bounds, and when to come home.
#pragma once

#include "hypertuna/control/safety.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A waypoint: m east and north, depth in m, speed through the water in m/s, radius in m within which it counts as
/// reached (legs.hpp), and s to stay there.
template <class T>
struct Waypoint {
    T x, y, depth, speed, radius, hold;
};

template <class T>
struct Corner {
    T x, y;  // m
};

template <class T>
struct Mission {
    const Waypoint<T>* waypoint;
    int waypoints;
    const Corner<T>* corner;  // corners of the fence in order, either way around; the last is joined to the first
    int corners;              // fewer than three: a circle
    Corner<T> center;
    T range;                // m, radius of that circle; 0 for no fence
    Corner<T> start, home;  // m
    T home_radius;          // m
    T home_speed;           // m/s through the water on the way home
    T depth_max;            // m
    T reserve;              // part of the battery's charge that must be left at home
    T duration;             // s after which it should be home; 0 for no end
    T surface_every;        // s after the last fix to come up for the next; 0 for only when needed
    bool stay;              // after the last waypoint, surface there instead of going home
    bool silence_below;     // the ground station's silence counts under water, too
    T declination;          // rad of magnetic from true north, east positive
};

/// Call visit(name, index, field) for every number of a mission except the lists of waypoints and corners.
template <class T, class Visit>
void visit_fields(Mission<T>& m, const Visit& visit) {
    visit("start", 0, m.start.x), visit("start", 1, m.start.y), visit("home", 0, m.home.x), visit("home", 1, m.home.y);
    visit("home_radius", 0, m.home_radius), visit("home_speed", 0, m.home_speed);
    visit("depth_max", 0, m.depth_max), visit("reserve", 0, m.reserve), visit("duration", 0, m.duration);
    visit("surface_every", 0, m.surface_every), visit("stay", 0, m.stay);
    visit("silence_below", 0, m.silence_below), visit("declination", 0, m.declination);
}

/// Distance of a place inside the fence, and the direction inward from the nearest border.
template <class T>
struct Inside {
    T distance;  // m, negative outside
    T x, y;      // unit vector
};

template <class T>
Inside<T> inside(const Mission<T>& mission, T x, T y) {
    const T far = T(1e6);
    if (mission.corners < 3) {
        if (!(T(0) < mission.range)) return {far, T(0), T(0)};
        const T dx = mission.center.x - x, dy = mission.center.y - y, away = sqrt(dx * dx + dy * dy);
        const T scale = T(1) / max(away, T(1e-6));
        return {mission.range - away, dx * scale, dy * scale};
    }
    T nearest = far * far, to_x = T(0), to_y = T(0);
    bool within = false;
    for (int k = 0; k < mission.corners; ++k) {
        const Corner<T>&a = mission.corner[k], &b = mission.corner[k + 1 < mission.corners ? k + 1 : 0];
        const T ex = b.x - a.x, ey = b.y - a.y, px = x - a.x, py = y - a.y;
        // A ray toward east crosses the edges of a fence an odd number of times from within.
        if ((y < a.y) != (y < b.y) && (px * ey < py * ex) == (T(0) < ey)) within = !within;
        const T part = clamp((px * ex + py * ey) / max(ex * ex + ey * ey, T(1e-12)), T(0), T(1));
        const T dx = part * ex - px, dy = part * ey - py, square = dx * dx + dy * dy;
        if (square < nearest) nearest = square, to_x = dx, to_y = dy;
    }
    const T away = sqrt(nearest), side = within ? T(1) : T(-1), scale = -side / max(away, T(1e-6));
    return {side * away, to_x * scale, to_y * scale};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
