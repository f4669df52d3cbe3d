/// Requests: orders with data. Each is checked by the table of states first, then carried out exactly or refused.
#pragma once

#include "app/vehicle/orders.hpp"

namespace hypertuna::firmware {

// --- parameters

/// Set and store a parameter.
inline Refusal set_parameter(Vehicle& vehicle, Station from, int k, float to) {
    const Description& robot = *vehicle.robot;
    if (k < 0 || k >= robot.parameters) return Refusal::unknown;
    const Refusal refusal = check(vehicle, Order::set_parameter, from);
    if (refusal != Refusal::none) return refusal;
    const ParameterInfo& info = robot.parameter[k];
    if (!in_range(info, to)) return Refusal::out_of_range;
    if (to == vehicle.value[k] && !vehicle.store.failed) return Refusal::none;  // no need to write the memory
    const float before = vehicle.value[k];
    vehicle.value[k] = to;
    configure(vehicle.model, robot, vehicle.value, info.field);
    if (!consistent(vehicle.model) || (vehicle.model.limits.sign == 1.0f && vehicle.secret.present == 0)) {
        vehicle.value[k] = before;
        configure(vehicle.model, robot, vehicle.value, info.field);
        return Refusal::inconsistent;
    }
    std::memcpy(vehicle.stored + 4 * k, &to, 4);
    begin_write(vehicle.store);
    return Refusal::none;
}

/// Store a key; zeros delete it.
inline Refusal set_key(Vehicle& vehicle, Station from, const std::uint8_t (&to)[key_size]) {
    const Refusal refusal = check(vehicle, Order::set_key, from);
    if (refusal != Refusal::none) return refusal;
    vehicle.secret.present = 0;
    for (std::uint8_t byte : to) vehicle.secret.present |= byte != 0;
    std::memcpy(vehicle.secret.key, to, key_size);
    begin_write(vehicle.keys);
    return Refusal::none;
}

/// Take the present depth as the surface; refused under water, where the depth is larger than the weather can make it.
inline Refusal take_surface(Vehicle& vehicle, Station from) {
    const Refusal refusal = check(vehicle, Order::zero_depth, from);
    if (refusal != Refusal::none) return refusal;
    const Estimate<float>& at = vehicle.now.estimate;
    const bool deep = at.zeroed && weather_max < at.depth;
    if (!deep && zero_depth(vehicle.model.pilot.estimator, vehicle.state.estimator)) return Refusal::none;
    return 0.0f < at.depth && at.depths ? Refusal::submerged : Refusal::no_depth;
}

// --- gait and sticks

/// Whether a command is within the controller's limits.
inline bool within(const Controller<float>& model, const Command<float>& command) {
    const auto in = [](float low, float x, float high) { return low <= x && x <= high; };
    bool good = in(0, command.frequency, model.frequency_max);
    for (int j = 0; j < model.joints; ++j) {
        const float limit = model.joint[j].amplitude, turn = float(2 * pi);
        good = good && in(0, command.amplitude[j], limit) && in(-turn, command.phase[j], turn) &&
               in(-limit, command.bias[j], limit);
    }
    for (int k = 0; k < 2; ++k) good = good && in(-model.fin_max, command.fin[k], model.fin_max);
    return good;
}

/// Follow a gait as long as the ground is in contact.
inline Refusal set_gait(Vehicle& vehicle, Station from, const Command<float>& command) {
    const Refusal refusal = check(vehicle, Order::gait, from);
    if (refusal != Refusal::none) return refusal;
    if (!within(vehicle.model.pilot.controller, command)) return Refusal::out_of_range;
    give(vehicle, Order::gait, from);
    vehicle.requested = command;
    vehicle.requested.armed = true;
    return Refusal::none;
}

/// Clamp a command to the controller's limits.
inline void clamp_command(const Controller<float>& model, Command<float>& command) {
    command.frequency = min(command.frequency, model.frequency_max);
    for (int j = 0; j < model.joints; ++j) {
        const float limit = model.joint[j].amplitude;
        command.amplitude[j] = min(command.amplitude[j], limit);
        command.bias[j] = clamp(command.bias[j], -limit, limit);
    }
    for (float& fin : command.fin) fin = clamp(fin, -model.fin_max, model.fin_max);
}

/// Deflection of a stick beyond its dead band.
inline float beyond_band(float axis) {
    const float beyond = max(0.0f, abs(axis) - stick_band) / (1.0f - stick_band);
    return axis < 0.0f ? -beyond : beyond;
}

/// Follow the sticks, once they were centered, until they are silent for manual_timeout: ahead from 0 to 1 of the top
/// speed (no robot swims backward), turn to port and climb from -1 to 1, by the gait table and clamped to the limits.
/// At ahead = 0 the tail straightens instead of stopping in mid-beat.
inline Refusal sticks(Vehicle& vehicle, Station from, float ahead, float turn, float climb) {
    const Refusal refusal = check(vehicle, Order::sticks, from);
    if (refusal != Refusal::none) return refusal;
    if (!(abs(ahead) <= 1 && abs(turn) <= 1 && abs(climb) <= 1)) return Refusal::out_of_range;
    ahead = max(0.0f, beyond_band(ahead)), turn = beyond_band(turn), climb = beyond_band(climb);
    vehicle.centered = vehicle.centered || (ahead == 0.0f && turn == 0.0f && climb == 0.0f);
    if (!vehicle.centered) return Refusal::not_centered;
    const Steering<float>& steering = vehicle.model.pilot.guidance.steering;
    Command<float> command = rest();
    const float top = steering.table.speed[steering.table.gaits - 1];
    beat_into(steering, command, ahead * top, -turn);
    for (int j = 0; j < max_joints && ahead == 0.0f; ++j) command.amplitude[j] = 0.0f;
    command.fin[0] = command.fin[1] = climb * steering.fin_max;
    clamp_command(vehicle.model.pilot.controller, command);
    vehicle.requested = command;
    vehicle.requested_at = vehicle.now.tick;
    return Refusal::none;
}

// --- missions

/// Make the plan the mission and the fence on board.
HYPERTUNA_NOINLINE inline void adopt_plan(Vehicle& vehicle) {
    const StoredMission& plan = vehicle.plan;
    vehicle.mission = mission_of(plan);
    vehicle.has_mission = 0 < plan.waypoints, vehicle.has_home = plan.form.has(ItemKind::home);
    vehicle.numbers = numbers_of(plan);
}

/// Forget mission and fence on board, but not the stored ones.
inline void forget_mission(Vehicle& vehicle) {
    std::memset(static_cast<void*>(&vehicle.plan), 0, sizeof(vehicle.plan));
    adopt_plan(vehicle);
}

/// Store the mission on board and its origin. The memory is written while disarmed.
inline void store_mission(Vehicle& vehicle) {
    const Origin& origin = vehicle.origin;
    vehicle.plan.has_origin = origin.known, vehicle.plan.latitude = origin.latitude;
    vehicle.plan.longitude = origin.longitude;
    begin_write(vehicle.missions);
}

/// Copy a mission on board; an invalid mission is refused as a whole.
inline Breach set_mission(Vehicle& vehicle, Station from, const Mission<float>& mission,
                          const MissionForm* form = nullptr) {
    const Refusal forbidden = check(vehicle, Order::upload, from);
    if (forbidden != Refusal::none) return {forbidden};
    if (mission.waypoints > max_waypoints || mission.corners > max_corners) return {Refusal::too_many};
    if (!fits(mission.waypoints, mission.corners)) return {Refusal::out_of_range};
    Breach breach = check_ranges(mission);
    if (breach == Refusal::none) breach = check_mission(mission, capability_of(vehicle.model));
    if (breach != Refusal::none) return breach;
    pack_mission(vehicle.plan, mission, form);
    adopt_plan(vehicle);
    vehicle.way_home = true;
    rewind(vehicle);
    store_mission(vehicle);
    return {};
}

/// Delete the mission on board and the stored one, the fence, or both. A fence among the mission's items goes with it.
inline Refusal clear_mission(Vehicle& vehicle, Station from, bool waypoints = true, bool fence = true) {
    const Refusal refusal = check(vehicle, Order::clear, from);
    StoredMission& plan = vehicle.plan;
    if (refusal != Refusal::none || !has_plan(vehicle)) return refusal;
    fence = fence || (waypoints && plan.form.has_fence());
    if (waypoints) plan.waypoints = plan.form.items = 0;
    if (fence) plan.corners = 0, plan.range = 0.0f, plan.form.drop_fence();
    adopt_plan(vehicle);
    begin_write(vehicle.missions);
    return Refusal::none;
}

/// Set home: the home of the mission on board, if it has one, or else home until the robot is disarmed.
inline Refusal set_home(Vehicle& vehicle, Station from, const Place& to) {
    const Refusal forbidden = check(vehicle, Order::set_home, from);
    if (forbidden != Refusal::none) return forbidden;
    if (!is_near(to.x, to.y)) return Refusal::out_of_range;
    Mission<float> mission = vehicle.mission;
    mission.home = to;
    const Refusal refusal =
        holds(mission, to) ? check_mission(mission, capability_of(vehicle.model)) : Breach{Refusal::outside_fence};
    if (refusal != Refusal::none) return refusal;
    vehicle.mission.home = vehicle.home = to, vehicle.home_set = true;
    if (!vehicle.has_home) return Refusal::none;
    vehicle.plan.home = to;
    adopt_plan(vehicle), store_mission(vehicle);
    return Refusal::none;
}

/// Set the waypoint at which the mission begins or resumes, or to which it swims at once.
inline Refusal set_leg(Vehicle& vehicle, Station from, int leg) {
    const Refusal refusal = check(vehicle, Order::set_leg, from);
    if (refusal != Refusal::none) return refusal;
    if (!vehicle.has_mission) return Refusal::no_mission;
    if (leg < 0 || vehicle.mission.waypoints <= leg) return Refusal::out_of_range;
    vehicle.leg = leg;
    const State state = vehicle.now.state;
    if (state == State::mission || state == State::paused)
        begin_leg(vehicle.state.guidance, vehicle.mission, leg, here(vehicle));
    return Refusal::none;
}

// --- origin and position

/// Restart the position estimate at a place.
inline void reset_position(Vehicle& vehicle, const Place& to) {
    const float start[2] = {to.x, to.y};
    const Place before = here(vehicle);
    vehicle.state.estimator.way = init(vehicle.model.pilot.estimator.way, start);
    vehicle.home = {vehicle.home.x + to.x - before.x, vehicle.home.y + to.y - before.y};
    vehicle.now.estimate.x = to.x, vehicle.now.estimate.y = to.y;
}

/// Whether a place is in the water that the origin belongs to.
inline bool is_of_origin(const Place& at) { return abs(at.x) < max_origin_distance && abs(at.y) < max_origin_distance; }

/// Set the origin of local coordinates. An origin that would move the mission on board is refused, and so is one far
/// from the robot. The robot's place in it is that of the next fix or, where a fix came before, is carried over.
inline Refusal set_origin(Vehicle& vehicle, Station from, std::int32_t latitude, std::int32_t longitude) {
    const Refusal refusal = check(vehicle, Order::set_origin, from);
    if (refusal != Refusal::none) return refusal;
    if (!is_place(latitude, longitude)) return Refusal::out_of_range;
    const Origin before = vehicle.origin;
    const bool same = before.known && before.latitude == latitude && before.longitude == longitude;
    if (same) return Refusal::none;
    if (has_plan(vehicle) && before.known) return Refusal::elsewhere;
    const Origin after = origin_at(latitude, longitude);
    const Place shift = local(after, before.latitude, before.longitude), at = here(vehicle);
    const Place moved = {at.x + shift.x, at.y + shift.y};
    if (vehicle.fixed && !is_of_origin(moved)) return Refusal::far_origin;
    vehicle.origin = after;
    if (has_plan(vehicle)) store_mission(vehicle);
    if (!vehicle.fixed) return vehicle.unplaced = true, Refusal::none;
    reset_position(vehicle, moved);
    return Refusal::none;
}

/// Return the origin in which a fix is at the robot's estimated place.
inline Origin origin_of_fix(const std::int32_t (&fix)[2], const Place& at) {
    const Origin there = origin_at(fix[0], fix[1]);
    return origin_at(fix[0] - std::int32_t(at.y / there.north), fix[1] - std::int32_t(at.x / there.east));
}

/// Handle the first fix since boot. In a given origin it is the robot's place; a mission that is too far away is
/// dropped. Without an origin the robot's place is kept, and the mission with it: the origin follows from both.
inline void on_first_fix(Vehicle& vehicle, const std::int32_t (&fix)[2]) {
    vehicle.fixed = true;
    if (vehicle.unplaced) {
        vehicle.unplaced = false;
        const Corner<float> at = local(vehicle.origin, fix[0], fix[1]);
        if (is_of_origin(at)) {
            reset_position(vehicle, at);
            if (vehicle.leg == 0) vehicle.state.guidance.from = at;
            return;
        }
        vehicle.origin.known = false;
        forget_mission(vehicle);
        give(vehicle, Order::drop);
    }
    if (vehicle.origin.known) return;
    vehicle.origin = origin_of_fix(fix, here(vehicle));
    if (has_plan(vehicle)) store_mission(vehicle);
}

/// Whether the next fix may begin the position anew, at a place to which the robot cannot have come.
inline bool may_begin_anew(const Vehicle& vehicle) {
    const auto& refused = vehicle.state.estimator.way.refused;
    return !refused.reached && refused_time - refused_pause <= refused.agree;
}

/// Count how long fixes have agreed: after refused_time the place of arming is known as home. Where other fixes begin
/// the position anew before that, those of arming were false: home, which is where the robot was, moves along from the
/// place `before`.
inline void follow_fixes(Vehicle& vehicle, const Place& before, bool anew) {
    const Snapshot& now = vehicle.now;
    const int ticks_to_trust = int(refused_time / vehicle.model.pilot.controller.tick);
    if (now.armed() && vehicle.agreed == ticks_to_trust) return;
    const bool lately = vehicle.fix.any && float(now.tick - vehicle.fix.tick) * vehicle.model.pilot.controller.tick < 1;
    if (now.estimate.fixes_refused)
        vehicle.agreed = 0;
    else if (lately && vehicle.agreed < ticks_to_trust)
        ++vehicle.agreed;
    if (!now.armed() || vehicle.home_set || !anew || !now.estimate.fix) return;
    const Place at = here(vehicle);
    for (Place* place : {&vehicle.home, &vehicle.detour.home, &vehicle.state.guidance.from})
        *place = {place->x + at.x - before.x, place->y + at.y - before.y};
    if (!vehicle.has_home) vehicle.mission.home = vehicle.home;
    vehicle.agreed = ticks_to_trust;
}

}  // namespace hypertuna::firmware
