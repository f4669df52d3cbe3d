/// A vehicle on a board of memory, for the tests: booted, armed, with gaits and missions.
#pragma once

#include <cmath>
#include <vector>

#include "../../../core/tests/allocations.hpp"
#include "../../../core/tests/check.hpp"
#include "memory_board.hpp"

using namespace hypertuna::firmware;
using hypertuna::Command;
using hypertuna::Mission;
using hypertuna::Mode;
using hypertuna::Reason;
using hypertuna::Waypoint;

inline Vehicle v;
inline MemoryBoard board;

inline void begin() {
    board = {}, board.flash.begin(), board.card = 1 << 16;
    boot(v, robot::description, board);
}

/// Afloat, and armed.
inline void begin_armed() {
    begin();
    float_on(v, board, 100);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
}

/// A tick with a satellite fix [1e-7 deg].
inline void fix(std::int32_t latitude, std::int32_t longitude) {
    float_upright(board, v, int(snapshot(v).tick));
    board.raw.fixed = true, board.raw.fix[0] = latitude, board.raw.fix[1] = longitude;
    tick(v, board);
    board.raw.fixed = false;
}

/// Float without a depth sensor, the ground in contact.
inline void blind(int ticks) {
    for (int k = 0; k < ticks; ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        board.raw.channel[hypertuna::first_channel("depth")] = {};
        tick(v, board);
    }
}

/// Float with the ground in contact.
inline void contact(int ticks) {
    for (int k = 0; k < ticks; ++k) on_ground_contact(v, ground), float_on(v, board, 1);
}

/// Float with this voltage of the battery, and the ground in contact.
inline void drain(float volts, int ticks) {
    const int channel = hypertuna::first_channel("voltage");
    const Calibration& c = v.model.calibration;
    for (int k = 0; k < ticks; ++k) {
        on_ground_contact(v, ground);
        float_upright(board, v, int(snapshot(v).tick));
        board.raw.channel[channel] = {};
        board.raw.channel[channel].add(std::int32_t(volts / c.scale[channel] + c.zero[channel]) + k % 3);
        tick(v, board);
    }
}

inline int index_of(const char* name) {
    for (int k = 0; k < parameter_count(v); ++k)
        if (std::strcmp(parameter(v, k).name, name) == 0) return k;
    return -1;
}

inline Command<float> beat(float frequency = 2) {
    Command<float> c = rest();
    c.frequency = frequency, c.amplitude[0] = 0.2f, c.amplitude[1] = 0.3f;
    return c;
}

/// Largest amplitude that the controller approaches.
inline bool beats() { return 0.1f < v.state.controller.target.amplitude[0]; }

inline Waypoint<float> way[2] = {{0, -40, 0, 0.3f, 2, 0}, {0, -80, 0, 0.3f, 2, 0}};
inline Mission<float> plan() {
    Mission<float> m{};
    m.waypoint = way, m.waypoints = 2;
    m.home_radius = 3, m.home_speed = 0.3f, m.depth_max = 4, m.reserve = 0.1f;
    return m;
}

/// A mission with a fence; all of its numbers differ from those of another `which`.
inline Mission<float> numbered(int which) {
    static Waypoint<float> to[max_waypoints];
    static hypertuna::Corner<float> corner[max_corners];
    Mission<float> m = plan();
    m.waypoint = to, m.corner = corner;
    m.waypoints = 3 + 40 * which, m.corners = 4 + which, m.stay = which == 1;
    m.home = {1.0f + float(which), 2.0f + float(which)}, m.reserve = 0.2f + 0.1f * float(which);
    for (int k = 0; k < m.waypoints; ++k)
        to[k] = {float(k + which), float(2 * k - which), 1.0f + float(which), 0.3f, 2.0f + float(which), float(which)};
    for (int k = 0; k < m.corners; ++k) {  // around all of it
        const float angle = 2 * float(hypertuna::pi) * float(k) / float(m.corners), far = 400 + float(which);
        corner[k] = {far * std::cos(angle), far * std::sin(angle)};
    }
    return m;
}

inline bool same(const Mission<float>& a, const Mission<float>& b) {
    return a.waypoints == b.waypoints && a.corners == b.corners && a.stay == b.stay && a.home.x == b.home.x &&
           a.home.y == b.home.y && a.reserve == b.reserve && a.depth_max == b.depth_max &&
           std::memcmp(a.waypoint, b.waypoint, sizeof(a.waypoint[0]) * std::size_t(a.waypoints)) == 0 &&
           std::memcmp(a.corner, b.corner, sizeof(a.corner[0]) * std::size_t(a.corners)) == 0;
}

/// Choose the response to a fault.
inline void choose(const char* parameter, Answer answer) {
    begin();
    set_parameter(v, ground, index_of(parameter), float(answer));
    float_on(v, board, 300);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
}
