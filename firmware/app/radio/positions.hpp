/// Messages from which ground stations draw the map: position, satellites, home, and whether the robot is at the
/// surface.
///
/// Altitudes are relative to the water's surface, that of the robot minus its depth: neither the surface's height above
/// the sea nor the satellites' altitude is used.
#pragma once

#include "app/radio/fields.hpp"

namespace hypertuna::firmware {

inline constexpr std::uint32_t fix_lasts = 300;  // ticks for which a fix counts as present

/// Latitude and longitude of a place [1e-7 deg].
struct Degrees {
    std::int32_t latitude, longitude;
};
inline Degrees degrees_of(const Origin& origin, const Place& at) {
    const auto steps = [](float meters, float step) { return whole<std::int32_t>(meters / step, 1.0f); };
    std::int64_t longitude = std::int64_t(origin.longitude) + steps(at.x, origin.east);
    const std::int64_t turn = 3600000000, half = turn / 2;
    longitude += longitude < -half ? turn : half < longitude ? -turn : 0;
    return {origin.latitude + steps(at.y, origin.north), std::int32_t(longitude)};
}

inline std::uint16_t heading(const Snapshot& now) {
    const float yaw = angle_of(now.estimate.facing.x, now.estimate.facing.y);
    return std::uint16_t(whole<std::uint16_t>(yaw < 0.0f ? yaw + float(2 * pi) : yaw, centidegree) % 36000);
}

inline mavlink_local_position_ned_t local_position(const Snapshot& now) {
    const Estimate<float>& at = now.estimate;
    mavlink_local_position_ned_t m{};
    m.time_boot_ms = milliseconds(now);
    m.x = at.y, m.y = at.x, m.z = at.depth;
    m.vx = at.speed * at.facing.y + at.current[1], m.vy = at.speed * at.facing.x + at.current[0], m.vz = at.sink;
    return m;
}

inline mavlink_global_position_int_t global_position(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    const mavlink_local_position_ned_t local = local_position(now);
    const Degrees at = degrees_of(origin(vehicle), here(vehicle));
    const auto centi = [](float speed) { return whole<std::int16_t>(speed, 100.0f); };
    mavlink_global_position_int_t m{};
    m.time_boot_ms = milliseconds(now), m.lat = at.latitude, m.lon = at.longitude;
    m.alt = m.relative_alt = whole<std::int32_t>(-now.estimate.depth, 1000.0f);
    m.vx = centi(local.vx), m.vy = centi(local.vy), m.vz = centi(local.vz), m.hdg = heading(now);
    return m;
}

/// Message on whether the receiver has a fix, with the last fix and its time.
inline mavlink_gps_raw_int_t gps_raw(const Vehicle& vehicle) {
    const LastFix& fix = vehicle.fix;
    const bool present = fix.any && snapshot(vehicle).tick - fix.tick <= fix_lasts;
    mavlink_gps_raw_int_t m{};
    m.time_usec = (fix.any ? fix.tick : snapshot(vehicle).tick) * 10000ull;
    m.fix_type = std::uint8_t(present ? GPS_FIX_TYPE_3D_FIX : GPS_FIX_TYPE_NO_FIX);
    m.lat = fix.place[0], m.lon = fix.place[1], m.eph = m.epv = m.vel = m.cog = 0xFFFF;
    m.satellites_visible = present && fix.satellites != 0 ? fix.satellites : std::uint8_t(present ? 0xFF : 0);
    m.h_acc = std::uint32_t(fix.accuracy);
    return m;
}

inline mavlink_home_position_t home_position(const Vehicle& vehicle) {
    const Place home = home_of(vehicle);
    const Degrees at = degrees_of(origin(vehicle), home);
    mavlink_home_position_t m{};
    m.latitude = at.latitude, m.longitude = at.longitude, m.x = home.y, m.y = home.x, m.q[0] = 1.0f;
    m.time_usec = snapshot(vehicle).tick * 10000ull;
    return m;
}

/// Message on whether the robot has landed: at the surface and at rest; otherwise it is in the air.
inline mavlink_extended_sys_state_t extended_state(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    const bool up = now.estimate.depth < pilot(vehicle)->guidance.surface_depth;
    const bool rests = !now.armed() || now.state == State::rest;
    mavlink_extended_sys_state_t m{};
    m.landed_state = std::uint8_t(up && rests ? MAV_LANDED_STATE_ON_GROUND : MAV_LANDED_STATE_IN_AIR);
    return m;
}

inline mavlink_vfr_hud_t hud(const Vehicle& vehicle) {
    const Snapshot& now = snapshot(vehicle);
    const mavlink_local_position_ned_t local = local_position(now);
    mavlink_vfr_hud_t m{};
    m.airspeed = now.estimate.speed, m.groundspeed = sqrt(local.vx * local.vx + local.vy * local.vy);
    m.heading = std::int16_t(heading(now) / 100), m.alt = -now.estimate.depth, m.climb = -now.estimate.sink;
    m.throttle = whole<std::uint16_t>(now.command.frequency / pilot(vehicle)->controller.frequency_max, 100.0f);
    return m;
}

}  // namespace hypertuna::firmware
