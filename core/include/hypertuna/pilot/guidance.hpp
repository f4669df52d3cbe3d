/// Guidance: what the robot does next, and why. Ten times a second it weighs the mission, its bounds and what has
/// failed, and asks for a beat, a tail bias and fin angles.
///
/// Every failure has one rule (docs/pilot.md). Those that end a mission are latched: what was lost once is not trusted
/// for more than the way home.
#pragma once

#include "hypertuna/pilot/legs.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr float no_way = 0.05f, slow_way = 0.1f;  // m/s made good toward home: below the first there is no way
                                                         // home, below the second the robot swims faster

/// Speed made good toward home [m/s], at the speed for the way home, or at the fastest gait's where that makes too
/// little way.
template <class T>
T way_made(const Guidance<T>& model, const Estimate<T>& at, const Mission<T>& mission) {
    const Course<T> home = toward(mission.home.x - at.x, mission.home.y - at.y, {T(1), T(0)});
    const T top = model.steering.table.speed[model.steering.table.gaits - 1];
    const T calm = made_good(home, at.current, T(0.9) * min(mission.home_speed, top));
    return calm < slow_way ? made_good(home, at.current, top * min(at.factor, T(1))) : calm;
}

/// Time to get home from here [s], including the ascent and a margin of a fifth.
template <class T>
T time_home(const Guidance<T>& model, const Estimate<T>& at, const Mission<T>& mission) {
    const T dx = mission.home.x - at.x, dy = mission.home.y - at.y, away = sqrt(dx * dx + dy * dy);
    const T speed = T(0.9) * min(mission.home_speed, model.steering.table.speed[model.steering.table.gaits - 1]);
    const T ground =
        max(way_made(model, at, mission), T(no_way));  // at a lower speed over ground the robot counts as swept away
    const T climb = max(T(0), at.depth) / (T(0.5) * speed * model.steering.climb_max);
    return T(1.2) * ((away + T(2) * at.position_error) / ground + climb) + model.overhead;
}

/// Set the reason `swept` where the current leaves no way home, or carries a robot that holds and cannot swim, as soon
/// as fixes show the current.
template <class T>
void weigh_current(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at,
                   const Mission<T>& mission) {
    const bool known = at.drift_error < T(2) * model.drift_error_max;
    const T drift = sqrt(at.current[0] * at.current[0] + at.current[1] * at.current[1]);
    const bool carried = state.mode == Mode::hold
                             ? T(no_way) < drift
                             : way_made(model, at, mission) < (state.swept ? T(slow_way) : T(no_way));
    if (known) state.swept = lasts(state.carried, carried, T(10), model.steering.period) || (state.swept && carried);
    state.reasons.set(Reason::swept, state.swept);
}

/// Set the reasons that follow from battery, time and sensors.
template <class T>
void weigh(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Onboard<T>& onboard,
           const Mission<T>& mission) {
    const T period = model.steering.period, back = time_home(model, at, mission);
    Reasons& why = state.reasons;
    const T charge = (onboard.voltage + model.battery_drop - model.battery_empty) / model.battery_span;
    const bool poor = charge < mission.reserve + back / model.endurance;
    if (!onboard.voltage_lost) why.set(Reason::low_battery, lasts(state.poor, poor, T(5), period));
    const bool drained = onboard.voltage_lost || charge < mission.reserve;
    state.spent = state.spent || lasts(state.drained, drained, T(5), period);
    why.set(Reason::time_up, T(0) < mission.duration && mission.duration < seconds(model, state.ticks) + back);
    const auto lost = [&](Reason reason, int& ticks, bool now) {
        why.set(reason, lasts(ticks, now, model.sensor_timeout, period));
    };
    lost(Reason::depth_lost, state.blind.depth, !at.depths);
    lost(Reason::imu_lost, state.blind.imu, !at.attitude);
    lost(Reason::compass_lost, state.blind.compass, !at.compass);
    why.set(Reason::compass_off, at.compass_off);
    why.clear(Reason::fixes_refused), why.set(Reason::fixes_refused, at.fixes_refused);
    lost(Reason::battery_lost, state.blind.battery, onboard.voltage_lost);
    why.set(Reason::tail_lost, onboard.joint_lost);
}

/// Largest fin angle: small where only one fin works, because it rolls the robot; full where small angles did not
/// change the depth.
template <class T>
T single_fin_limit(const Guidance<T>& model, const Reasons& why) {
    const bool alone = why.has(Reason::port_fin_lost) || why.has(Reason::starboard_fin_lost);
    const T limit = model.steering.fin_max;
    return alone && !why.has(Reason::no_answer) ? min(model.single_fin_max, limit) : limit;
}

inline constexpr float sinks_fast = 0.02f;  // m/s

/// Detect lost fins: where one does not follow its command, the other rolls the robot; where neither does, the depth
/// does not answer.
template <class T>
void weigh_fins(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission,
                T wanted) {
    const T period = model.steering.period, tilt = state.steering.beat.mean.tilt;
    Reasons& why = state.reasons;
    const bool rolled = model.fin_tilt < abs(tilt) && model.fin_min < abs(state.fin) && at.attitude;
    const T sign = (T(0) < tilt) == (T(0) < state.fin) ? T(1) : T(-1);
    const T limit = model.fin_after;
    if (rolled)
        state.fin_evidence = clamp(state.fin_evidence + sign * period, -limit, limit);
    else
        state.fin_evidence -= T(0.2) * period * clamp(state.fin_evidence, T(-1), T(1));
    if (!why.has(Reason::port_fin_lost) && !why.has(Reason::starboard_fin_lost)) {
        why.set(Reason::port_fin_lost, state.fin_evidence <= -limit);
        why.set(Reason::starboard_fin_lost, limit <= state.fin_evidence);
    }
    const T error = abs(at.depth - wanted);
    const bool anew = abs(wanted - state.depth_wanted) > model.response_depth;
    state.depth_wanted = wanted;
    const T near = T(0) < wanted ? model.response_depth : model.surface_depth;
    if (!at.depths || error < near)
        state.unanswered = 0;
    else if (anew || state.unanswered == 0)
        state.unanswered = 1, state.depth_error = error, state.answered = false;
    else if (error < state.depth_error - model.response_depth)
        state.unanswered = 1, state.depth_error = error, state.answered = true;
    else if (++state.unanswered;
             !state.answered)  // progress counts from the largest error: while a beat begins, the nose dips
        state.depth_error = max(state.depth_error, error);
    // Below the depth limit there is no time to wait: a robot that sinks with its fins up is driven down.
    const bool deep = mission.depth_max < at.depth && T(sinks_fast) < at.sink;
    const T allowed = deep ? T(0.2) * model.response_time : model.response_time;
    if (seconds(model, state.unanswered) < allowed) return;
    // A robot that still rises, however slowly, goes on.
    const bool rises = error < state.depth_error - T(0.3) * model.response_depth;
    why.set(Reason::stranded, (deep || (why.has(Reason::no_answer) && !rises)) && model.surface_depth < at.depth);
    why.set(Reason::no_answer);
    state.unanswered = 0;
}

/// Whether position and current are known well enough to dive to the next waypoint; on the way home no dive follows.
template <class T>
bool knows_to_dive(const Guidance<T>& model, const GuidanceState<T>& state, const Estimate<T>& at,
                   const Mission<T>& mission, T limit) {
    if (state.mode == Mode::home || mission.waypoints <= state.leg) return true;
    return at.drift_error <= model.drift_error_max &&
           at.position_error <= error_to_dive(model, at, mission, mission.waypoint[state.leg], limit);
}

/// Decide whether to come up for a fix, and whether to stay at the surface for it.
template <class T>
void weigh_fixes(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission,
                 bool near_fence) {
    const T period = model.steering.period;
    Reasons& why = state.reasons;
    const bool up = at.depth < model.surface_depth || !at.depths;
    if (at.fix) state.since_fix = 0, state.waiting = 0, state.retry = 0, why.clear(Reason::no_fix);
    const T age = seconds(model, state.since_fix);
    if (state.since_fix < 1 << 30) ++state.since_fix;
    if (state.retry > 0) --state.retry;
    // Near the fence, at home and near a waypoint the position must be known better.
    T limit = near_fence ? model.error_near : error_limit(model, state, at, mission);
    if (state.mode == Mode::home) limit = min(model.error_near, max(mission.home_radius, model.error_fix));
    const bool vague = limit < at.position_error;
    const bool due = T(0) < mission.surface_every && mission.surface_every < age;
    const bool drifts = state.mode == Mode::hold || has_ended(state.mode);
    if (!state.rising && state.retry == 0 && (vague || due) && !drifts) {
        state.rising = true, state.waiting = state.surfaced = 0;
        state.sought += vague && !near_fence && at.position_error <= model.error_max;
        why.set(vague ? Reason::uncertain : Reason::fix_due);
    }
    if (!state.rising) return;
    if (up) ++state.surfaced, state.waiting += !at.fix;
    const bool enough = at.fix && !vague && knows_to_dive(model, state, at, mission, limit);
    const bool none = model.fix_timeout <= T(state.waiting) * period;
    if (none) why.set(Reason::no_fix);
    // Fixes that do not get better are accepted.
    const bool vain = none || T(3) * model.fix_timeout <= T(state.surfaced) * period;
    if (vain) state.retry = int(model.retry / period);
    if (!enough && !vain) return;
    state.rising = false;
    why.clear(Reason::uncertain), why.clear(Reason::fix_due);
}

/// Mode at the goal: done or ended where the robot is home, or up at the last waypoint of a mission that stays, and
/// knows that it is there.
template <class T>
Mode at_goal(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission,
             bool back, bool up) {
    Reasons& why = state.reasons;
    Waypoint<T> goal{mission.home.x, mission.home.y, T(0), mission.home_speed, mission.home_radius, T(0)};
    if (!back) goal = mission.waypoint[mission.waypoints - 1];
    const T dx = goal.x - at.x, dy = goal.y - at.y, radius = goal.radius;
    const bool within = dx * dx + dy * dy < radius * radius, known = knows(model, at, radius);
    why.clear(Reason::adrift), why.set(Reason::adrift, why.has(Reason::no_fix) && !known);
    // While the position is uncertain, the robot stays where the goal should be, as long as battery and time allow.
    const bool must_end = why.has(Reason::low_battery) || why.has(Reason::time_up);
    if (!within || !up || state.rising || !(known || must_end)) return back ? Mode::home : Mode::surface;
    const bool done = known && why.has(Reason::all_reached) && !why.has(Reason::recalled);
    return done ? Mode::done : Mode::ended;
}

/// The mode that follows from the reasons.
template <class T>
Mode mode_of(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission) {
    if (has_ended(state.mode)) return state.mode;
    const Reasons& why = state.reasons;
    const bool up = at.depths ? at.depth < model.surface_depth : at.fix;
    if (why.has(Reason::stranded)) return Mode::hold;
    // Without an IMU the robot cannot steer: it comes up and waits there.
    if (why.has(Reason::imu_lost) && !at.attitude)
        return up || model.fix_timeout <= seconds(model, state.blind.imu) ? Mode::hold : Mode::surface;
    if (why.has(Reason::compass_lost) && !at.compass && model.compass_timeout <= seconds(model, state.blind.compass))
        return up ? Mode::hold : Mode::surface;
    // The robot swims against a current that is too strong as long as the charge lasts; then it drifts and reports
    // where it is.
    if (state.swept && state.spent) return up ? Mode::hold : Mode::surface;
    const bool all_passed = 0 < mission.waypoints && mission.waypoints <= state.leg;
    const bool unknown = why.has(Reason::no_fix) && model.error_lost < at.position_error;
    const bool back = why.end() || unknown || (all_passed && !mission.stay);
    if (back || all_passed) return at_goal(model, state, at, mission, back, up);
    return state.rising ? Mode::surface : mission.waypoints > 0 ? Mode::transit : Mode::idle;
}

/// Distance to the fence at which to turn: the less the position is known, the larger. Where it is known, and on the
/// way home, the target itself stays within bounds; otherwise the robot keeps to the middle until a fix comes.
template <class T>
T margin_of(const Guidance<T>& model, const GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission) {
    const T margin = model.fence_margin + T(2) * at.position_error;
    if (state.mode != Mode::home && model.error_near < at.position_error) return margin;
    const Corner<T> target = target_of(state, mission);
    return min(margin, max(model.fence_margin, T(0.8) * inside(mission, target.x, target.y).distance));
}

/// Course over ground: to the point ahead on the leg, or home; near the fence toward its inside. A fence that does not
/// contain both the robot and home does not stop the way home.
template <class T>
Course<T> course_of(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission,
                    const Inside<T>& border) {
    const Course<T> present = toward(at.facing.x, at.facing.y, {T(0), T(1)});
    const Corner<T> target = target_of(state, mission);
    const bool straight_home = state.mode == Mode::home || mission.waypoints <= state.leg;
    const Course<T> course =
        straight_home    ? toward(target.x - at.x, target.y - at.y, present)
        : 0 < state.held ? circle(model, at, mission.waypoint[state.leg])
                         : line_of_sight(state.from, target, at.x, at.y, model.steering.lookahead, present).course;
    const T margin = margin_of(model, state, at, mission);
    if (margin <= border.distance) return course;
    state.reasons.set(Reason::fence, T(0) <= border.distance);
    const bool both_inside = T(0) < border.distance && T(0) < inside(mission, mission.home.x, mission.home.y).distance;
    if (state.mode == Mode::home && !both_inside) return course;
    const T in = course.x * border.x + course.y * border.y;
    const T push = clamp((margin - border.distance) / model.fence_margin, T(0), T(1)) + max(T(0), -in);
    return toward(course.x + push * border.x, course.y + push * border.y, course);
}

inline constexpr float fix_awaited = 3;  // s since the last fix, after which a robot at the surface presses on upward

/// Depth to steer for. At the surface, as long as no fix comes, the robot presses on upward: so the antenna comes out
/// of the water even where the depth's zero is some cm off, and a zero that was taken under water is found out.
template <class T>
T steered_depth(const Guidance<T>& model, const GuidanceState<T>& state, T wanted) {
    const bool awaited = T(fix_awaited) < seconds(model, state.since_fix);
    return wanted == T(0) && awaited ? -model.surface_depth : wanted;
}

/// Set the fin angles for a wanted depth, with the fins that still work.
template <class T>
void steer_depth(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, T wanted,
                 Command<T>& command) {
    const Steering<T>& steering = model.steering;
    const Reasons& why = state.reasons;
    const bool blind = !at.attitude || !at.depths;
    const T fin = blind ? model.blind_fin : fins_for(steering, at, climb_for(steering, state.steering, at, wanted));
    const bool port = why.has(Reason::port_fin_lost), starboard = why.has(Reason::starboard_fin_lost);
    const T limit = single_fin_limit(model, why);
    state.fin = clamp(fin, -limit, limit);
    command.fin[0] = port ? T(0) : state.fin;
    command.fin[1] = starboard ? T(0) : state.fin;
}

/// Depth that is wanted now.
template <class T>
T depth_of(const Guidance<T>& model, GuidanceState<T>& state, const Estimate<T>& at, const Mission<T>& mission) {
    const int last = mission.waypoints - 1;
    const T asked = state.mode == Mode::transit ? mission.waypoint[state.leg < last ? state.leg : last].depth : T(0);
    const T limit = mission.depth_max;
    state.reasons.clear(Reason::depth_limit);
    if (limit < asked || limit < at.depth + T(0.1)) state.reasons.set(Reason::depth_limit);
    // Keep `surface_depth` above the limit: a robot that dives needs it to level out.
    return clamp(asked, T(0), max(T(0), limit - model.surface_depth));
}

/// One decision of guidance: the new state and the command.
template <class T>
Guided<T> guide(const Guidance<T>& model, const GuidanceState<T>& before, const Estimate<T>& at,
                const Onboard<T>& onboard, const Mission<T>& mission) {
    Guided<T> out{before, {}};
    GuidanceState<T>& state = out.state;
    const Steering<T>& steering = model.steering;
    const Inside<T> border = inside(mission, at.x, at.y);
    state.reasons.clear(Reason::fence), state.reasons.clear(Reason::outside);
    state.reasons.set(Reason::outside, border.distance < T(0));
    weigh(model, state, at, onboard, mission);
    weigh_current(model, state, at, mission);
    weigh_fixes(model, state, at, mission, border.distance < margin_of(model, state, at, mission));
    if (state.mode == Mode::transit || state.mode == Mode::surface) follow_legs(model, state, at, mission);
    state.mode = mode_of(model, state, at, mission);
    ++state.ticks;

    Command<T>& command = out.command;
    command.fresh = command.armed = true;
    const T depth = depth_of(model, state, at, mission);
    const bool moves = state.mode == Mode::transit || state.mode == Mode::surface || state.mode == Mode::home;
    if (!moves || (state.resting && state.mode != Mode::home)) {
        state.fin = T(0);
        beat_into(steering, command, steering.speed_min, T(0));
        for (int j = 0; j < steering.joints; ++j) command.amplitude[j] = T(0);
        return out;
    }
    const Course<T> course = course_of(model, state, at, mission, border);
    const bool home = state.mode == Mode::home;
    const int leg = state.leg < mission.waypoints ? state.leg : mission.waypoints - 1;
    T speed = home || leg < 0 ? mission.home_speed : mission.waypoint[leg].speed;
    // On the way up the fins need the flow of a gait.
    if (state.mode == Mode::surface && model.surface_depth < at.depth) speed = max(speed, steering.table.speed[0]);
    const T steered = steered_depth(model, state, depth), fastest = steering.table.speed[steering.table.gaits - 1];
    // Lift grows as the square of the speed: a robot that is too deep and whose depth does not answer swims its
    // fastest, unless its fins drive it down. So does one in a current that leaves no speed over ground.
    const bool lift = state.reasons.has(Reason::no_answer) && model.surface_depth < at.depth - steered;
    if ((lift && at.sink < T(sinks_fast)) || made_good(course, at.current, speed) < T(slow_way)) speed = fastest;
    T bias = T(0);
    if (at.attitude) {
        bias = bias_for(steering, state.steering, crab(course, at.current, max(speed, steering.speed_min)), at.speed);
    } else {
        speed = model.blind_speed;
    }
    // The gait's speed is corrected by the factor that fixes showed.
    beat_into(steering, command, max(speed, steering.speed_min) / at.factor, bias);
    steer_depth(model, state, at, steered, command);
    weigh_fins(model, state, at, mission, depth);
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
