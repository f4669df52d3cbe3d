/// Failsafe: the events on board that change the state, from the faults and from the pilot's mode.
#pragma once

#include "app/vehicle/requests.hpp"

namespace hypertuna::firmware {

inline constexpr float boot_window = 10.0f;  // s after boot in which the robot may be found under water
inline constexpr float boot_silence =
    5.0f;  // s without the ground station after which a robot at boot may count as under water
inline constexpr float surface_change =
    0.05f;  // m: least difference from the stored surface for which it is stored again

/// Whether the robot is at the surface, as far as its depth is known.
inline bool is_up(const Vehicle& vehicle) {
    const Estimate<float>& at = vehicle.now.estimate;
    return at.depths && at.depth < vehicle.model.pilot.guidance.surface_depth;
}

/// Whether a robot without a way home must ascend: in open water, where fixes come, from depths that no radio reaches;
/// in a tank from below rise_depth. The depth is the last plausible one.
inline bool is_deep(const Vehicle& vehicle) {
    const float tank = vehicle.model.limits.rise_depth;
    return (vehicle.fixed ? min(radio_depth, tank) : tank) < vehicle.now.estimate.depth;
}

/// Whether there is a way home: by the mission on board, or by fixes to the place of arming.
inline bool knows_home(const Vehicle& vehicle) { return (vehicle.has_mission && vehicle.way_home) || vehicle.fixed; }

/// Follow a call home: swim the way home; without one, ascend from depth, otherwise rest.
inline void follow_recall(Vehicle& vehicle) {
    const bool first = !vehicle.recalled;
    vehicle.recalled = true;
    if (first && knows_home(vehicle)) return give(vehicle, Order::recall);
    const bool stops = !knows_home(vehicle) || vehicle.now.state == State::rest;
    if (!stops) return;
    give(vehicle, Order::stop);
    if (is_deep(vehicle) && !vehicle.ascent_failed) give(vehicle, Order::ascend);
}

/// Follow a call to the surface: ascend, and stay there. With an empty battery, disarm at the surface, or where the
/// ascent failed.
inline void follow_call_up(Vehicle& vehicle, bool disarm) {
    const Snapshot& now = vehicle.now;
    const bool rests = now.state == State::rest && now.estimate.depths && now.estimate.depth < radio_depth;
    const bool over = is_up(vehicle) || rests || vehicle.ascent_failed;
    if (!over) return give(vehicle, Order::ascend);
    give(vehicle, disarm ? Order::spend : Order::halt);
}

/// Store the depth sensor's reading at the surface: a robot that hears the ground has its antenna out of the water.
inline void remember_surface(Vehicle& vehicle) {
    const EstimatorState<float>& at = vehicle.state.estimator;
    const float tick = vehicle.model.pilot.controller.tick;
    const bool hears = sensor_after < float(vehicle.now.tick) * tick && float(vehicle.silence) * tick < sensor_after;
    if (!hears || !at.zeroed || (0 <= vehicle.surfaces.kept && abs(at.zero - vehicle.surface) < surface_change)) return;
    if (!settled(vehicle.surfaces)) return;
    vehicle.surface = at.zero;
    begin_write(vehicle.surfaces);
}

/// Whether the robot booted under water: the word that was kept over the reset says armed, and the robot is not at the
/// surface; or the sensor shows more than any air pressure, or more than at the stored surface in any weather while
/// no ground is heard. Somebody who carries the robot has it in the air at boot.
inline bool is_under_water(Vehicle& vehicle) {
    const Estimate<float>& at = vehicle.now.estimate;
    const float tick = vehicle.model.pilot.controller.tick;
    if (boot_window < float(vehicle.now.tick) * tick) return false;
    const bool armed = vehicle.was_armed && (!at.depths || radio_depth < at.depth);
    const EstimatorState<float>& estimator = vehicle.state.estimator;
    const float reading = at.depth + estimator.zero;
    const bool certain = vehicle.model.pilot.estimator.air_high < reading;
    const bool likely = estimator.air_max < reading && boot_silence < float(vehicle.silence) * tick;
    const bool cold = at.depths && !at.zeroed && (certain || likely);
    return lasting(vehicle.submerged, armed || cold, sensor_after, tick);
}

/// Give the orders that respond to the present faults.
inline void respond(Vehicle& vehicle) {
    const Snapshot& now = vehicle.now;
    if (now.state == State::disarmed) {
        if (is_under_water(vehicle)) give(vehicle, Order::revive);
        return;
    }
    if (is_up(vehicle)) vehicle.ascent_failed = false;
    give(vehicle, now.answer == Answer::rest ? Order::hold : Order::release);
    if (now.faults.has(Fault::link_lost)) give(vehicle, Order::stop);
    if (now.answer < Answer::home) vehicle.recalled = false;
    if (now.answer == Answer::surface || now.answer == Answer::disarm)
        follow_call_up(vehicle, now.answer == Answer::disarm);
    else if (now.answer == Answer::stop)
        give(vehicle, Order::halt);
    else if (now.answer == Answer::home && now.state != State::held)
        follow_recall(vehicle);
}

/// Give the orders that follow from the mode of the pilot on board.
inline void follow_pilot(Vehicle& vehicle) {
    const GuidanceState<float>& guidance = vehicle.state.guidance;
    const State& state = vehicle.now.state;
    const bool done = guidance.mode == Mode::done, over = has_ended(guidance.mode);
    if (!vehicle.on_detour && guidance.leg < vehicle.mission.waypoints)
        vehicle.leg = guidance.leg, vehicle.progress = {guidance.leg, guidance.reached, guidance.passed};
    if (state == State::mission && (guidance.reasons.end() || (over && !done))) give(vehicle, Order::end);
    if (state == State::mission && done) {
        rewind(vehicle), give(vehicle, Order::complete);
    } else if (state == State::home && over) {
        give(vehicle, done ? Order::complete : Order::arrive);
    } else if (state == State::surface) {
        const bool late = 0 <= std::int32_t(vehicle.now.tick - vehicle.ascent_deadline);
        if (is_up(vehicle)) return give(vehicle, Order::emerge);
        if (late || guidance.mode == Mode::hold) vehicle.ascent_failed = true, give(vehicle, Order::fail);
    }
}

}  // namespace hypertuna::firmware
