/// Legs: when a waypoint is reached, when the robot goes on without it, and how it holds there.
///
/// A waypoint is reached where three conditions hold. The estimated position is within the radius; the position error,
/// one standard deviation, is at most the radius; and the depth is the waypoint's within a tolerance. The robot
/// surfaces for a fix or circles until the depth is right, and passes the waypoint where neither helps.
#pragma once

#include "hypertuna/pilot/guidance_model.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Begin a leg from a place, after a pause or by the ground's order. Waypoints that this leaves out count as skipped;
/// after an order back, earlier waypoints that were passed or skipped remain so.
template <class T>
void begin_leg(GuidanceState<T>& state, const Mission<T>& mission, int leg, const Corner<T>& from) {
    const int missed = state.leg - state.reached, to = leg < 0 ? 0 : leg < mission.waypoints ? leg : mission.waypoints;
    if (to < state.leg) state.reached = to < missed ? 0 : to - missed;
    if (to < state.reached + state.passed) state.passed = to - state.reached;
    state.leg = to, state.mode = Mode::idle;
    state.from = from;
    state.arriving = state.held = state.sought = 0, state.resting = false;
    state.steering.turn_sum = state.steering.climb_sum = T(0);
    state.reasons.set(Reason::skipped, state.reached + state.passed < state.leg);
    if (state.leg < mission.waypoints) state.reasons.clear(Reason::all_reached);
}

/// Whether the robot knows its position well enough to say that it is within a radius.
template <class T>
bool knows(const Guidance<T>& model, const Estimate<T>& at, T radius) {
    return at.position_error <= max(radius, model.error_fix);
}

/// Where the robot is relative to a waypoint, by the estimate.
template <class T>
struct Arrival {
    T away;             // m, estimated distance
    bool near;          // estimated to be within the radius
    bool past;          // estimated to be abeam of the waypoint or beyond, within the position error
    bool deep, placed;  // whether it is at its depth; whether the position is known to within the radius
};

template <class T>
Arrival<T> arrival(const Guidance<T>& model, const GuidanceState<T>& state, const Estimate<T>& at,
                   const Waypoint<T>& next) {
    const T dx = next.x - at.x, dy = next.y - at.y, away = sqrt(dx * dx + dy * dy);
    const Leg<T> leg = line_of_sight(state.from, {next.x, next.y}, at.x, at.y, model.steering.lookahead, {T(0), T(1)});
    return {away, away < next.radius,
            leg.length < leg.along && abs(leg.across) < next.radius + T(2) * at.position_error,
            at.depths && abs(at.depth - next.depth) < model.depth_tolerance, at.position_error <= next.radius};
}

inline constexpr int fixes_sought = 3;  // per waypoint: on the way there, and there

/// Position error above which the robot surfaces on its way to a waypoint: near the waypoint this is its radius, as far
/// as fixes are that accurate.
template <class T>
T error_limit(const Guidance<T>& model, const GuidanceState<T>& state, const Estimate<T>& at,
              const Mission<T>& mission) {
    if (mission.waypoints <= state.leg || fixes_sought <= state.sought) return model.error_max;
    const Waypoint<T>& next = mission.waypoint[state.leg];
    const Arrival<T> arrived = arrival(model, state, at, next);
    // Distance swum on the way up for a fix and down again.
    const T ways = T(2) * min(next.depth, mission.depth_max) / model.steering.climb_max;
    const bool at_waypoint = arrived.near || arrived.past;
    const bool soon = state.sought == 0 ? arrived.away < next.radius + T(2) * at.position_error + ways : at_waypoint;
    return soon || at_waypoint ? min(model.error_max, max(next.radius, model.error_fix)) : model.error_max;
}

/// Position error with which a robot may dive to a waypoint: with the error that the dive adds it stays within a limit,
/// as far as fixes are that accurate.
template <class T>
T error_to_dive(const Guidance<T>& model, const Estimate<T>& at, const Mission<T>& mission, const Waypoint<T>& next,
                T limit) {
    const T rate = T(0.5) * model.steering.climb_max * max(next.speed, model.steering.speed_min);
    const T loss = at.drift_error * min(next.depth, mission.depth_max) / rate;
    return limit <= loss ? limit : max(T(0.87) * model.error_fix, sqrt(limit * limit - loss * loss));
}

/// Begin the next leg where a waypoint is reached, passed or out of bounds.
template <class T>
void follow_legs(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission) {
    if (mission.waypoints <= state.leg) return;
    const Waypoint<T>& next = mission.waypoint[state.leg];
    const Arrival<T> arrived = arrival(model, state, at, next);
    const T period = model.steering.period;
    const bool at_waypoint = arrived.near && arrived.deep && arrived.placed;
    if (at_waypoint && T(state.held) * period < next.hold) ++state.held;
    const bool reached = at_waypoint && next.hold <= T(state.held) * period;
    if (at_waypoint) state.sought = 0;
    // Time spent waiting for a fix does not count.
    if ((arrived.near || arrived.past) && !at_waypoint && state.mode == Mode::transit) ++state.arriving;
    const bool vain = !arrived.placed && !state.rising &&
                      (0 < state.retry || next.radius < model.error_fix || fixes_sought <= state.sought);
    const bool passed =
        ((arrived.near || arrived.past) && arrived.deep && vain) || model.arrival_timeout <= T(state.arriving) * period;
    const bool beyond = inside(mission, next.x, next.y).distance < model.fence_margin;
    state.resting = next.depth < model.surface_depth && T(0) < next.hold && at_waypoint &&
                    (state.resting || arrived.away < T(0.5) * next.radius);
    if (!reached && !passed && !beyond) return;
    state.reached += reached, state.passed += !reached && !beyond;
    state.reasons.set(Reason::passed, !reached && !beyond);
    state.reasons.set(Reason::skipped, !reached && beyond);
    state.from = {next.x, next.y};
    state.arriving = state.held = state.sought = 0, state.resting = false;
    state.reasons.set(Reason::all_reached, ++state.leg == mission.waypoints && state.reached == mission.waypoints);
}

/// Place that the robot swims to: home, or the present waypoint.
template <class T>
Corner<T> target_of(const GuidanceState<T>& state, const Mission<T>& mission) {
    const int last = mission.waypoints - 1;
    if (state.mode == Mode::home || last < 0) return mission.home;
    const Waypoint<T>& to = mission.waypoint[state.leg < last ? state.leg : last];
    return {to.x, to.y};
}

/// Course around a waypoint: on a circle within its radius, no tighter than the tail turns.
template <class T>
Course<T> circle(const Guidance<T>& model, const Estimate<T>& at, const Waypoint<T>& around) {
    const T dx = around.x - at.x, dy = around.y - at.y, away = sqrt(dx * dx + dy * dy);
    const T ring = max(T(0.5) * around.radius, T(1.2) / model.steering.curvature);
    const Course<T> in = toward(dx, dy, {T(0), T(1)});
    const T pull = clamp((away - ring) / ring, T(-1), T(1));
    return toward(in.y + pull * in.x, pull * in.y - in.x, in);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
