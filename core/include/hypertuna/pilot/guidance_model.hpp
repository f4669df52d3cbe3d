/// Types of guidance: constants, state, input and output.
#pragma once

#include "hypertuna/pilot/reasons.hpp"
#include "hypertuna/pilot/steering.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct Guidance {
    Steering<T> steering;
    T surface_depth;  // m above which the robot counts as at the surface
    T fence_margin;   // m
    T error_max, error_near,
        error_lost;        // m, position errors: to come up for a fix; good enough near fence and goal; to go home
    T error_fix;           // m: position error that fixes attain
    T depth_tolerance;     // m from a waypoint's depth within which it is reached
    T arrival_timeout;     // s near or past a waypoint until the robot goes on
    T drift_error_max;     // m/s: largest growth of the position error at which a dive begins
    T fix_timeout, retry;  // s at the surface without a fix; s until the next attempt
    T sensor_timeout;      // s without a sensor until it counts as lost
    T compass_timeout;     // s on the way home without a compass until the robot holds
    T fin_tilt, fin_min, fin_after;   // sine of the roll, fin angle [rad] and time [s] from which a fin counts as lost
    T single_fin_max;                 // rad: largest angle of a fin that is left alone
    T response_time, response_depth;  // s to wait for the depth to answer; m of progress that count as an answer
    T blind_fin;                      // rad: angle for the ascent without depth or IMU
    T blind_speed;                    // m/s of the ascent without IMU
    T battery_empty, battery_span, battery_drop;  // V
    T endurance;                                  // s that a full battery lasts at full speed
    T overhead;                                   // s added to every way home
};

template <class T, class Visit>
void visit_fields(Guidance<T>& m, const Visit& visit) {
    visit_fields(m.steering, visit);
    visit("surface_depth", 0, m.surface_depth), visit("fence_margin", 0, m.fence_margin);
    visit("error_max", 0, m.error_max), visit("error_near", 0, m.error_near), visit("error_lost", 0, m.error_lost);
    visit("error_fix", 0, m.error_fix), visit("depth_tolerance", 0, m.depth_tolerance);
    visit("arrival_timeout", 0, m.arrival_timeout);
    visit("drift_error_max", 0, m.drift_error_max), visit("fix_timeout", 0, m.fix_timeout), visit("retry", 0, m.retry);
    visit("sensor_timeout", 0, m.sensor_timeout), visit("compass_timeout", 0, m.compass_timeout);
    visit("fin_tilt", 0, m.fin_tilt), visit("fin_min", 0, m.fin_min), visit("fin_after", 0, m.fin_after);
    visit("single_fin_max", 0, m.single_fin_max), visit("response_time", 0, m.response_time);
    visit("response_depth", 0, m.response_depth), visit("blind_fin", 0, m.blind_fin),
        visit("blind_speed", 0, m.blind_speed);
    visit("battery_empty", 0, m.battery_empty);
    visit("battery_span", 0, m.battery_span), visit("battery_drop", 0, m.battery_drop);
    visit("endurance", 0, m.endurance), visit("overhead", 0, m.overhead);
}

/// Ticks in a row without each sensor.
struct Blind {
    int depth, imu, compass, battery;
};

template <class T>
struct GuidanceState {
    Mode mode;
    Reasons reasons;
    SteeringState<T> steering;
    int leg;                     // current waypoint
    Corner<T> from;              // m: where the leg began
    int reached, passed;         // waypoints before `leg` that were reached and passed; all others were skipped
    int arriving, held, sought;  // ticks near or past the waypoint; ticks held there; fixes sought for it
    bool resting;                // whether the robot rests at the surface within a waypoint's radius
    bool swept, spent;           // the current carries the robot away from home; the battery's reserve is touched
    int ticks;                   // decisions so far
    int since_fix, waiting;      // ticks since the last fix, at the surface without one
    int surfaced;                // ticks at the surface for better fixes
    bool rising;                 // coming up for a fix
    int retry;                   // ticks until rising again makes sense
    Blind blind;
    int poor, drained,
        carried;     // ticks in a row of low charge, without a reserve, of a current too strong for the way home
    T fin_evidence;  // s: s of roll that show a lost fin: positive for starboard, negative for port
    int unanswered;  // ticks since the depth last answered to the fins
    bool answered;   // the depth has come nearer since; a held robot goes up and down with the swell
    T depth_error, depth_wanted;  // m: depth error when `unanswered` last began; depth that was wanted then
    T fin;                        // rad, last asked
};

template <class T>
struct Guided {
    GuidanceState<T> state;
    Command<T> command;
};

/// Input of guidance from the controller.
template <class T>
struct Onboard {
    T voltage;          // V, last valid reading
    bool voltage_lost;  // its sensor is faulty
    bool joint_lost;    // a joint was released at the hard limit
};

template <class T>
GuidanceState<T> init(const Guidance<T>&, const Mission<T>& mission) {
    GuidanceState<T> state{};
    state.from = mission.start;
    state.rising = true;  // a mission begins at the surface, with fixes
    return state;
}

template <class T>
T seconds(const Guidance<T>& model, int ticks) {
    return T(ticks) * model.steering.period;
}

/// Count ticks while a condition holds, and return whether it has held for `limit` seconds.
template <class T>
bool lasts(int& ticks, bool holds, T limit, T period) {
    ticks = !holds ? 0 : ticks < 1 << 30 ? ticks + 1 : ticks;  // on beyond the limit: longer ones ask as well
    return holds && limit <= T(ticks) * period;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
