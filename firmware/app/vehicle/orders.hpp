/// Orders: the only entrance to the state. `give` looks up the table of states.hpp, checks who orders and what must
/// hold, and enters the next state.
#pragma once

#include "app/vehicle/vehicle.hpp"

namespace hypertuna::firmware {

/// Command that brings the tail to rest and levels the fins.
inline Command<float> rest() {
    Command<float> command{};
    command.fresh = command.armed = true;
    return command;
}

// --- conditions of orders

/// Return why the mission on board cannot begin here at its current waypoint. The whole mission is checked as on its
/// upload: parameters and home may have changed since.
inline Refusal check_leg(const Vehicle& vehicle) {
    Mission<float> rest_of_it = vehicle.mission;
    rest_of_it.home = home_of(vehicle);
    const Refusal refusal = check_mission(rest_of_it, capability_of(vehicle.model));
    if (refusal != Refusal::none) return refusal;
    rest_of_it.waypoint += vehicle.leg, rest_of_it.waypoints -= vehicle.leg;
    return check_start(rest_of_it, here(vehicle));
}

/// Present faults; a lost key among them.
inline Faults arming_faults(const Vehicle& vehicle) {
    Faults set = vehicle.memory.present;
    set.set(Fault::key_lost, vehicle.locked);
    return set;
}

/// Return why an order was refused, as a sentence: where a fault is the reason, the fault's own.
inline const char* sentence(const Vehicle& vehicle, Refusal refusal) {
    if (refusal != Refusal::faulty) return sentence(refusal);
    const Answer answer = vehicle.now.answer;
    const Fault fault =
        vehicle.now.armed()
            ? first_fault(vehicle.now.faults,
                          [&](const FaultText& text) { return answer_to(text, limits(vehicle)) == answer; })
            : forbidding(arming_faults(vehicle));
    return fault == Fault::count ? sentence(refusal) : fault_texts[int(fault)].sentence;
}

/// Whether the depth is plausible for arming: its zero was measured, or can be measured now.
inline bool depth_plausible(const Vehicle& vehicle) {
    const Estimate<float>& at = vehicle.now.estimate;
    const Estimator<float>& model = vehicle.model.pilot.estimator;
    const float reading = at.depth + vehicle.state.estimator.zero;
    return at.depths &&
           (at.zeroed ? -depth_error_max < at.depth : model.air_low <= reading && reading <= model.air_high);
}

/// Return why a need is not met; `none` if it is.
inline Refusal check(const Vehicle& vehicle, Need need) {
    const Snapshot& now = vehicle.now;
    const auto unless = [](bool good, Refusal why) { return good ? Refusal::none : why; };
    switch (need) {
        case Need::sound:
            return unless(forbidding(arming_faults(vehicle)) == Fault::count, Refusal::faulty);
        case Need::stored:
            return unless(
                settled(vehicle.store) && settled(vehicle.missions) && settled(vehicle.stamps) && settled(vehicle.keys),
                Refusal::busy);
        case Need::attitude:
            return unless(now.estimate.attitude, Refusal::not_ready);
        case Need::depth:
            return unless(depth_plausible(vehicle), Refusal::no_depth);
        case Need::inside:
            return unless(!vehicle.fixed || holds(vehicle.mission, here(vehicle)), Refusal::robot_outside);
        case Need::obeys:
            return unless(now.answer < Answer::home, Refusal::faulty);
        case Need::rises:
            return unless(now.answer <= Answer::home, Refusal::faulty);
        case Need::upright:
            return unless(now.answer < Answer::rest, Refusal::faulty);
        case Need::mission:
            return unless(vehicle.has_mission, Refusal::no_mission);
        case Need::start:
            return check_leg(vehicle);
        default:
            return Refusal::unknown;
    }
}

/// Whether a station may give an order.
inline bool may_give(const Vehicle& vehicle, Who who, Station from) {
    return who != Who::pilot || in_control(vehicle, from);
}

/// Return why an order would be refused now.
HYPERTUNA_NOINLINE inline Refusal check(const Vehicle& vehicle, Order order, Station from) {
    if (Order::count <= order || rule_of(order).who == Who::board) return Refusal::unknown;
    const Rule& rule = rule_of(order);
    const Cell& cell = rule.next[int(vehicle.now.state)];
    if (cell.refusal != Refusal::none) return cell.refusal;
    if (!may_give(vehicle, rule.who, from)) return Refusal::other_pilot;
    for (int k = 0; cell.changes() && k < int(Need::count); ++k) {
        const Refusal refusal = rule.needs >> k & 1 ? check(vehicle, Need(k)) : Refusal::none;
        if (refusal != Refusal::none) return refusal;
    }
    return Refusal::none;
}

// --- entering a state

/// Collect all faults, and the response to them.
inline void evaluate_faults(Vehicle& vehicle) {
    Snapshot& now = vehicle.now;
    now.faults = all_faults(vehicle.memory);
    now.faults.set(Fault::watchdog, vehicle.watchdog_reset);
    now.faults.set(Fault::defaults, vehicle.defaults);
    now.faults.set(Fault::memory, vehicle.store.failed || vehicle.missions.failed || vehicle.stamps.failed ||
                                      vehicle.keys.failed || vehicle.surfaces.failed);
    now.faults.set(Fault::key_lost, vehicle.locked);
    now.answer = answer_to(now.faults, limits(vehicle));
}

/// The mission that the pilot follows.
inline Mission<float>& flown(Vehicle& vehicle) { return vehicle.on_detour ? vehicle.detour : vehicle.mission; }

/// Restart guidance on the mission on board or the detour, from the robot's position.
inline void begin_mission(Vehicle& vehicle, bool detour) {
    vehicle.on_detour = detour;
    Mission<float>& mission = flown(vehicle);
    mission.start = here(vehicle);
    if (!detour && !vehicle.has_home) mission.home = vehicle.home;
    vehicle.state.guidance = init(vehicle.model.pilot.guidance, mission);
    vehicle.state.wait = 0;
    if (detour) return;
    GuidanceState<float>& guidance = vehicle.state.guidance;
    guidance.leg = vehicle.progress.leg;
    guidance.reached = vehicle.progress.reached, guidance.passed = vehicle.progress.passed;
    begin_leg(guidance, mission, vehicle.leg, mission.start);
}

/// The mission on board begins anew at its first waypoint.
inline void rewind(Vehicle& vehicle) { vehicle.leg = 0, vehicle.progress = {}; }

/// Begin a detour without waypoints: guidance heads for a place, or circles if the radius is that of all places, with
/// the fins up, and handles the loss of IMU, depth or a fin.
inline void begin_detour(Vehicle& vehicle, Place home, float radius, float speed) {
    vehicle.detour = {};
    vehicle.detour.home = home, vehicle.detour.home_radius = radius;
    vehicle.detour.home_speed = speed, vehicle.detour.depth_max = 1e4f;
    begin_mission(vehicle, true);
    vehicle.state.guidance.rising = false;  // do not wait for a fix
    vehicle.state.guidance.reasons.set(Reason::recalled);
}

/// Begin the way home: by the mission on board or, without one, straight.
inline void begin_way_home(Vehicle& vehicle, State before) {
    const bool under_way = (before == State::mission || before == State::paused) && !vehicle.on_detour;
    if (vehicle.has_mission && vehicle.way_home) {
        if (!under_way) begin_mission(vehicle, false);
        vehicle.state.guidance.reasons.set(Reason::recalled);
    } else {
        begin_detour(vehicle, vehicle.home, detour_radius, vehicle.model.pilot.guidance.blind_speed);
    }
}

/// Begin an ascent at the present place.
inline void begin_ascent(Vehicle& vehicle) {
    const Guidance<float>& guidance = vehicle.model.pilot.guidance;
    begin_detour(vehicle, here(vehicle), 1e4f, guidance.blind_speed);
    const float limit = clamp(time_home(guidance, vehicle.now.estimate, vehicle.detour), 0.0f, 3600.0f);
    vehicle.ascent_deadline = vehicle.now.tick + std::uint32_t(limit / vehicle.model.pilot.controller.tick);
}

/// Set home to the place of arming, unless an order has set it. An order of the ground also clears the faults since the
/// last arming.
inline void on_arming(Vehicle& vehicle, Order order) {
    vehicle.recalled = vehicle.ascent_failed = false;
    if (!vehicle.home_set) vehicle.home = here(vehicle);
    vehicle.silence = 0;
    if (order != Order::arm) return;
    // A robot that is armed near the surface is at the surface; one that is armed in a tank's depth keeps its zero.
    const Estimator<float>& estimator = vehicle.model.pilot.estimator;
    if (!vehicle.now.estimate.zeroed || abs(vehicle.now.estimate.depth) < estimator.fix_depth)
        zero_depth(estimator, vehicle.state.estimator);
    if (!vehicle.has_home) vehicle.mission.home = vehicle.home;
    rewind(vehicle);
    vehicle.memory.latched = {};
    vehicle.memory.present.set(Fault::link_gone, false);  // the ground is in contact: it arms
    vehicle.watchdog_reset = vehicle.was_armed = false;
    evaluate_faults(vehicle);
}

/// Actions on entering a state.
inline void on_entry(Vehicle& vehicle, State before, Order order) {
    GuidanceState<float>& guidance = vehicle.state.guidance;
    vehicle.requested = rest();
    vehicle.requested_at = vehicle.now.tick;
    vehicle.centered = false;
    if (before == State::disarmed) on_arming(vehicle, order);
    if (before == State::held) return;
    switch (vehicle.now.state) {
        case State::disarmed:
            vehicle.pilot = {}, vehicle.home_set = false;
            break;
        case State::rest:
        case State::manual:
        case State::gait:
            if (order != Order::complete && order != Order::arrive) guidance.mode = Mode::idle;
            break;
        case State::mission:
            if (before != State::paused) begin_mission(vehicle, false);
            vehicle.way_home = true;
            break;
        case State::home:
            if (order != Order::end) begin_way_home(vehicle, before);
            break;
        case State::surface:
            begin_ascent(vehicle);
            break;
        default:
            break;
    }
}

/// Follow an order that was checked.
HYPERTUNA_NOINLINE inline void enter(Vehicle& vehicle, Order order) {
    const Cell& cell = rule_of(order).next[int(vehicle.now.state)];
    if (!cell.changes()) return;
    const State before = vehicle.now.state;
    vehicle.now.state = cell.back ? vehicle.before : cell.next;
    vehicle.before = before;
    on_entry(vehicle, before, order);
}

/// Follow an order of a station, or return why it is refused.
inline Refusal give(Vehicle& vehicle, Order order, Station from) {
    const Refusal refusal = check(vehicle, order, from);
    if (refusal != Refusal::none) return refusal;
    if (rule_of(order).who == Who::taker) vehicle.pilot = from;
    enter(vehicle, order);
    return Refusal::none;
}

/// Follow an event on board.
inline void give(Vehicle& vehicle, Order event) { enter(vehicle, event); }

}  // namespace hypertuna::firmware
