/// Way: the robot's position by dead reckoning, and its uncertainty.
///
/// Under water nothing measures the velocity: its size is the gait's, its direction the compass'. So a Kalman filter
/// estimates position, current and a complex factor on that velocity (way_filter.hpp). A fix after a dive shows the
/// current by the error of the position, and two headings tell the current from the factor. It begins with a sound
/// compass, so it takes an error for a current for long. A second filter begins with any angle of the compass and a
/// strong current, and alone decides whether the compass is off; then its estimate takes the place of the first.
#pragma once

#include "hypertuna/pilot/attitude.hpp"
#include "hypertuna/pilot/way_filter.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct WayModel {
    T position_walk, current_walk,
        factor_walk;  // m, m/s, 1 per root of a second: random walks of position, current and factors
    T start_error, current_error, factor_error;  // standard deviations at the start
    T fix_noise, fix_offset;                     // m: noise of a fix; error that successive fixes share
    T fix_error_max;                             // m: largest error by the receiver with which a fix is used
};

template <class T, class Visit>
void visit_fields(WayModel<T>& m, const Visit& visit) {
    visit("position_walk", 0, m.position_walk), visit("current_walk", 0, m.current_walk);
    visit("factor_walk", 0, m.factor_walk), visit("start_error", 0, m.start_error);
    visit("current_error", 0, m.current_error), visit("factor_error", 0, m.factor_error);
    visit("fix_noise", 0, m.fix_noise), visit("fix_offset", 0, m.fix_offset);
    visit("fix_error_max", 0, m.fix_error_max);
}

/// Fixes that were refused since the last one that was used.
template <class T>
struct RefusedFixes {
    int count;       // number of fixes in a row
    bool reached;    // the robot can have come to the place of the last one
    Complex<T> off;  // m: place of the last one relative to the estimate
    T since, agree;  // s since the last one; s for which they have agreed on one place
};

/// Vectors are east + i north.
template <class T>
struct WayState {
    WayFilter<T> filter;   // the estimate
    WayFilter<T> compass;  // the filter that begins with any angle of the compass
    Complex<T> moved;      // m swum through the water since the last `carry`, by gait and compass
    int ticks;             // ticks since the last `carry`
    Complex<T> swim;       // m/s: mean velocity through the water over some beats
    T suspected;           // variance given to the factor because of an apparent current
    T apart;               // rad by which the field has turned relative to the gyroscope, beyond the gyroscope's offset
    Complex<T> from;       // m: place of the last fix that was taken
    T reach;               // m: how far from it the robot can be
    RefusedFixes<T> refused;
    T astray;             // m swum since the attitude was lost
    Complex<T> shown;     // m: mean place of the fixes of the last seconds
    Complex<T> moved_to;  // m: the same where the present piece of the path began
    T swum;               // m swum since then
    bool held;            // the robot did not move on the previous piece
};

/// Largest squared deviation of a fix that is believed, in variances: all but one fix in 1000 keep it; and while fixes
/// are refused.
inline constexpr double fix_gate = 14, refused_gate = 5;
inline constexpr float reach_gate = 3.74f,
                       speed_factor_max = 1.7f;  // root of fix_gate; largest factor on the gait's speed

/// Standard deviation of the second filter's factor at the start, in which any angle has room; the same of its current,
/// over the usual.
inline constexpr float any_factor = 1.5f, any_current = 3;

template <class T>
WayState<T> init(const WayModel<T>& model, const T (&start)[2]) {
    WayState<T> way{};
    way.from = way.shown = way.moved_to = {start[0], start[1]};
    way.filter = init_filter(way.from, model.start_error, model.current_error, model.factor_error);
    way.compass = init_filter(way.from, model.start_error, T(any_current) * model.current_error, T(any_factor));
    way.reach = T(reach_gate) * model.start_error;
    return way;
}

inline constexpr float swim_rate = 0.3f;  // 1/s: how fast the mean of the velocity through the water follows

/// Carry both filters on over the way swum since the last call.
template <class T>
void carry(const WayModel<T>& model, WayState<T>& way, T tick) {
    const T dt = T(way.ticks) * tick;
    const T walk[3] = {model.position_walk, model.current_walk, model.factor_walk};
    T noise[3];
    for (int k = 0; k < 3; ++k) noise[k] = walk[k] * walk[k] * dt;
    carry(way.filter, dt, way.moved, noise);
    carry(way.compass, dt, way.moved, noise);
    const T rate = min(T(swim_rate), T(1) / max(dt, tick));
    way.swim = way.swim + rate * (way.moved - dt * way.swim);
    const T current = abs(way.filter.current.re) + abs(way.filter.current.im) + T(reach_gate) * model.current_error;
    const T length = sqrt(square(way.moved));
    way.reach += T(speed_factor_max) * length + current * dt;
    way.swum += length;
    way.refused.since += dt;
    way.moved = {T(0), T(0)};
    way.ticks = 0;
}

/// Add to the uncertainty while the robot swims without an attitude: the position becomes as uncertain as that way is
/// long.
template <class T>
void go_astray(WayState<T>& way, T swum, bool known) {
    way.astray = known ? T(0) : way.astray + abs(swum);
    if (!known) way.reach += T(speed_factor_max) * abs(swum);
    const T more = T(2) * way.astray * abs(swum);
    way.filter.position_square += more, way.compass.position_square += more;
}

/// Speed through the water over that of the gait.
template <class T>
T factor_of(const WayState<T>& way) {
    return max(T(0.3), sqrt(square(way.filter.factor)));
}

template <class T>
void bound_factor(WayState<T>& way) {
    way.filter.factor = min(T(1), T(speed_factor_max) / factor_of(way)) * way.filter.factor;
}

// --- the compass

inline constexpr float suspected_part =
    0.25f;  // part of the factor's variance that would explain the whole apparent current
/// rad by which the field turned relative to the gyroscope, beyond which a compass is off.
inline constexpr float off_turn = 0.35f;

/// Make the factor uncertain where there seems to be a current. On one heading a compass that is off looks like one, v
/// over ground minus U f; but a current stays where it is, and the compass' error turns with the robot. The current
/// becomes uncertain along with the factor, so that the velocity on the present heading remains known. Each amount is
/// added once: what fixes on two headings showed does not become uncertain again.
template <class T>
void suspect_compass(WayState<T>& way) {
    if (!(T(0.01) < square(way.swim))) return;
    const T drift = drift_error(way.filter, way.swim);
    const Complex<T> extra = way.filter.current + way.filter.factor * way.swim - way.swim;
    const T excess = (square(extra) - T(2) * drift * drift) / square(way.swim);
    const T more = T(suspected_part) * min(excess, T(4)) - way.suspected;
    if (!(T(0) < more)) return;
    way.suspected += more;
    doubt_factor(way.filter, way.swim, more);
}

/// Sum up how far the field turns relative to the gyroscope, beyond the gyroscope's largest offset. If it does, iron on
/// board turns with the robot, so corrections of the compass from other headings no longer hold, and its uncertainty
/// grows.
template <class T>
void compare_gyroscope(const AttitudeModel<T>& frame, WayState<T>& way, T pulled) {
    const T excess_turn = frame.tick * (abs(pulled) - frame.drift_max), apart_before = way.apart;
    way.apart = max(T(0), apart_before + excess_turn);
    if (excess_turn < T(0)) return;
    const T more = (apart_before + way.apart) * excess_turn;
    way.filter.factor_square += more, way.compass.factor_square += more;
}

/// m swum without moving by twice the noise of a fix, after which a robot may be held: at 40 % of its speed.
inline constexpr float held_swum = 7.5f;
inline constexpr float shown_time = 5;  // s over which fixes are averaged to show it

/// Judge by fixes whether the robot moves, anew on each piece of the path: it ends where the robot has moved, or after
/// `held_swum`.
template <class T>
void watch_progress(const WayModel<T>& model, WayState<T>& way, Complex<T> fix) {
    way.shown = way.shown + min(T(1), way.refused.since / T(shown_time)) * (fix - way.shown);
    const bool moves = T(4) * model.fix_noise * model.fix_noise < square(way.shown - way.moved_to);
    if (!moves && way.swum < T(held_swum)) return;
    way.held = !moves;
    way.moved_to = way.shown, way.swum = T(0);
}

/// Whether the second filter finds the compass off. The course of a robot that may be held shows nothing: it makes no
/// way on any heading, which looks like a current that turns.
template <class T>
bool course_is_off(const WayState<T>& way) {
    return !way.held && is_off(way.compass);
}

/// Whether the compass is off, by the course over ground or against the gyroscope.
template <class T>
bool compass_is_off(const WayState<T>& way) {
    return course_is_off(way) || T(off_turn) < way.apart;
}

/// Correct the direction that the robot faces by the compass, in place, by the error that fixes showed.
template <class T>
void face_by_course(const WayState<T>& way, Vector<T>& facing) {
    const T size = sqrt(square(way.filter.factor));
    if (!(T(0.05) < size)) return;
    const Complex<T> turned = way.filter.factor * Complex<T>{facing.x, facing.y};
    facing.x = turned.re / size, facing.y = turned.im / size;
}

// --- fixes

/// s for which refused fixes must agree on one place until the estimate counts as wrong; longest pause between two of
/// them that counts [s]. Reflected signals last some seconds.
inline constexpr float refused_time = 30, refused_pause = 1;

/// Record a refused fix. The longer fixes agree within `near` [m^2], the less the estimate is believed.
template <class T>
void refuse(RefusedFixes<T>& refused, Complex<T> off, T near) {
    const bool agrees = 0 < refused.count && square(off - refused.off) < near;
    refused.agree = agrees ? refused.agree + min(refused.since, T(refused_pause)) : T(0);
    refused.off = off;
    if (refused.count < 1 << 30) ++refused.count;
    refused.since = T(0);
}

/// Use a fix if it is plausible, and return whether it was used. A fix must agree with the estimate within the
/// deviations, and lie no farther from the last one than the robot can have come. Others leave the filters unchanged,
/// until they have agreed for long: then the robot was carried there, or its estimate was wrong. `accuracy` [m] is the
/// receiver's own; 0 where unknown.
template <class T>
bool take_fix(const WayModel<T>& model, WayState<T>& way, const T (&place)[2], T accuracy) {
    const Complex<T> fix{place[0], place[1]}, off = fix - way.filter.position;
    const T deviation = max(model.fix_noise, accuracy);
    // NaN is refused as well.
    if (!(abs(off.re) < T(1e5) && abs(off.im) < T(1e5) && deviation <= model.fix_error_max)) return false;
    const T noise = deviation * deviation, extra = noise + model.fix_offset * model.fix_offset;
    const T gate = 0 < way.refused.count ? T(refused_gate) : T(fix_gate);
    const T far = way.reach + T(reach_gate) * sqrt(extra);
    const bool reached = square(fix - way.from) <= far * far;
    if (reached && square(off) <= gate * (way.filter.position_square + extra)) {
        take_fix(way.filter, fix, noise), take_fix(way.compass, fix, noise);
        suspect_compass(way);
        watch_progress(model, way, fix);
        if (course_is_off(way)) way.filter = way.compass;
        bound_factor(way);
    } else {
        refuse(way.refused, off, T(2 * fix_gate) * noise);
        way.refused.reached = reached;
        if (way.refused.agree < T(refused_time)) return false;
        for (WayFilter<T>* filter : {&way.filter, &way.compass}) begin_at(*filter, fix, noise, model.current_error);
    }
    way.refused = {};
    way.reach = T(reach_gate) * deviation;
    way.from = way.filter.position;
    return true;
}

/// Standard deviation of the position on one axis [m]. It includes the error that all fixes share, and refused fixes
/// add to it the longer they agree on a place that the robot can have come to.
template <class T>
T position_error(const WayModel<T>& model, const WayState<T>& way) {
    const T agree = way.refused.reached ? way.refused.agree / T(refused_time) : T(0);
    const T contradicted = agree * square(way.refused.off) / T(refused_gate);
    return sqrt(way.filter.position_square + model.fix_offset * model.fix_offset + contradicted);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
