/// Way: where the robot is by dead reckoning, and how far off that is.
///
/// Under water nothing measures speed: the gait says it, and the compass says where to. So position, current, a factor
/// on the gait's speed and the error of the compass are estimated together by a Kalman filter, x' = c + U (a f + b
/// f_left) with the facing direction f: a fix after a dive tells the current from the error of the way, and two
/// headings tell it from the factors. A compass that is off by an angle has a = cos, b = sin of it.
#pragma once

#include "hypertuna/pilot/attitude.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Where the numbers of the way's state begin: position x, y, current x, y, factors ahead and to the left.
enum WayPlace { way_position = 0, way_current = 2, way_along = 4, way_across, way_states };

template <class T>
struct WayModel {
    T position_walk, current_walk, factor_walk;  // m, m/s, 1 per root of a second: what the way is uncertain by
    T start_error, current_error, factor_error;  // standard deviations at the start
    T fix_noise, fix_offset;                     // m: noise of a fix, and what many of them share
    T fix_error_max;                             // m: a receiver that tells more has no fix
};

template <class T, class Visit>
void visit_fields(WayModel<T>& m, const Visit& visit) {
    visit("position_walk", 0, m.position_walk), visit("current_walk", 0, m.current_walk);
    visit("factor_walk", 0, m.factor_walk), visit("start_error", 0, m.start_error);
    visit("current_error", 0, m.current_error), visit("factor_error", 0, m.factor_error);
    visit("fix_noise", 0, m.fix_noise), visit("fix_offset", 0, m.fix_offset);
    visit("fix_error_max", 0, m.fix_error_max);
}

/// Fixes that were refused since the last that was taken.
template <class T>
struct Doubt {
    int fixes;       // in a row
    bool reached;    // the robot can have come to the last of them
    T off[2];        // m from the estimate, of the last of them
    T since, agree;  // s since that one; for which they have been at one place
};

template <class T>
struct WayState {
    T at[way_states];
    T spread[way_states][way_states];  // covariance
    T moved[2];                        // m through the water since the covariance was carried on, by gait and compass
    int ticks;                         // since then
    T swim[2];                         // m/s: its mean over some beats
    T suspected;                       // variance of the factors for what looks like a current
    T apart;                           // rad by which field and gyroscope turned apart, beyond the gyroscope's offset
    T from[2], reach;                  // m: place of the last fix that was taken, and how far from it the robot can be
    Doubt<T> doubt;
    T astray;  // m swum since the attitude was lost
};

/// Squares of the deviations within which a fix is believed, all but one in 1000; and while fixes are refused.
inline constexpr double fix_gate = 14, doubt_gate = 5;
inline constexpr float reach_gate = 3.74f,
                       speed_factor_max = 1.7f;  // root of the first; of the speed that the gait says

template <class T>
WayState<T> init(const WayModel<T>& model, const T (&start)[2]) {
    WayState<T> way{};
    for (int k = 0; k < 2; ++k) way.at[way_position + k] = way.from[k] = start[k];
    way.at[way_along] = T(1);
    const T error[way_states] = {model.start_error,   model.start_error,  model.current_error,
                                 model.current_error, model.factor_error, model.factor_error};
    for (int k = 0; k < way_states; ++k) way.spread[k][k] = error[k] * error[k];
    way.reach = T(reach_gate) * model.start_error;
    return way;
}

/// What a way through the water adds to the position: its derivatives by current and factors, for each coordinate.
template <class T>
struct WaySlope {
    T of[2][way_states - way_current];

    WaySlope(T time, T x, T y) : of{{time, T(0), x, -y}, {T(0), time, y, x}} {}
    HYPERTUNA_NOINLINE T along(int i, const T* row) const {
        T sum = T(0);
        for (int j = 0; j < way_states - way_current; ++j) sum += of[i][j] * row[j];
        return sum;
    }
};

inline constexpr float swim_rate = 0.3f;  // 1/s: how fast the mean of the velocity through the water follows

/// Carry position and covariance on by what was swum since the last time: P <- F P F' + Q, F = 1 but for the rows of
/// the position.
template <class T>
void carry(const WayModel<T>& model, WayState<T>& way, T tick) {
    const T dt = T(way.ticks) * tick;
    const WaySlope<T> slope(dt, way.moved[0], way.moved[1]);
    for (int i = 0; i < 2; ++i) way.at[i] += slope.along(i, way.at + way_current);
    for (const bool columns : {false, true}) {  // after the rows
        T added[2][way_states];
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < way_states; ++k) added[i][k] = slope.along(i, way.spread[k] + way_current);
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < way_states; ++k) (columns ? way.spread[k][i] : way.spread[i][k]) += added[i][k];
    }
    const T rate = min(T(swim_rate), T(1) / max(dt, tick));
    for (int i = 0; i < 2; ++i) way.swim[i] += rate * (way.moved[i] - dt * way.swim[i]);
    const T noise[3] = {model.position_walk, model.current_walk, model.factor_walk};
    for (int k = 0; k < way_states; ++k) way.spread[k][k] += noise[k / 2] * noise[k / 2] * dt;
    const T current = abs(way.at[way_current]) + abs(way.at[way_current + 1]) + T(reach_gate) * model.current_error;
    way.reach += T(speed_factor_max) * sqrt(way.moved[0] * way.moved[0] + way.moved[1] * way.moved[1]) + current * dt;
    way.doubt.since += dt;
    way.moved[0] = way.moved[1] = T(0);
    way.ticks = 0;
}

/// Swim on without knowing where to: after a way of that kind the position is as uncertain as the way is long.
template <class T>
void go_astray(WayState<T>& way, T swum, bool known) {
    way.astray = known ? T(0) : way.astray + abs(swum);
    if (!known) way.reach += T(speed_factor_max) * abs(swum);
    for (int axis = 0; axis < 2; ++axis) way.spread[axis][axis] += T(2) * way.astray * abs(swum);
}

/// Speed through the water over that of the gait.
template <class T>
T factor_of(const WayState<T>& way) {
    return max(T(0.3), sqrt(way.at[way_along] * way.at[way_along] + way.at[way_across] * way.at[way_across]));
}

/// One coordinate of a fix whose noise has this variance [m^2].
template <class T>
void take_fix(WayState<T>& way, int axis, T innovation, T noise) {
    const T variance = way.spread[axis][axis] + noise;
    T gain[way_states], row[way_states];
    for (int k = 0; k < way_states; ++k) gain[k] = way.spread[k][axis] / variance, row[k] = way.spread[axis][k];
    for (int i = 0; i < way_states; ++i) {
        way.at[i] += gain[i] * innovation;
        for (int k = 0; k < way_states; ++k) way.spread[i][k] -= gain[i] * row[k];
    }
    const T size = factor_of(way), scale = min(T(1), T(speed_factor_max) / size);
    way.at[way_along] *= scale, way.at[way_across] *= scale;
    for (int i = 0; i < way_states; ++i) {
        for (int k = 0; k < i; ++k)  // rounding leaves it symmetric
            way.spread[i][k] = way.spread[k][i] = T(0.5) * (way.spread[i][k] + way.spread[k][i]);
        way.spread[i][i] = max(way.spread[i][i], T(1e-8));
    }
}

/// Standard deviation of the velocity over ground at a velocity through the water, of its worse component: how fast a
/// dive loses its way.
template <class T>
T drift_error(const WayState<T>& way, T ahead_x, T ahead_y) {
    const WaySlope<T> slope(T(1), ahead_x, ahead_y);
    T largest = T(0);
    for (int i = 0; i < 2; ++i) {
        T row[way_states - way_current];
        for (int j = 0; j < way_states - way_current; ++j)
            row[j] = slope.along(i, way.spread[way_current + j] + way_current);
        largest = max(largest, slope.along(i, row));
    }
    return sqrt(largest);
}

// --- the compass

inline constexpr float suspected_part = 0.25f;  // of the variance of the factors that would explain a whole current
/// Tangent of the angle to the course beyond which a compass is off, 20 deg; by how many standard deviations; rad of it
/// against the gyroscope.
inline constexpr float off_slope = 0.364f, off_deviations = 3, off_turn = 0.35f;

/// On one heading a compass that is off looks like a current, v over ground less U f: a current stays where it is, the
/// other turns with the robot. So the factors become uncertain by what looks like a current, and the current with them,
/// such that what is known of the present heading remains known. Once: what two headings told is not doubted again.
template <class T>
void suspect_compass(WayState<T>& way) {
    const T x = way.swim[0], y = way.swim[1], square = x * x + y * y;
    if (!(T(0.01) < square)) return;
    const WaySlope<T> slope(T(1), x, y);
    const T drift = drift_error(way, x, y);
    const T extra[2] = {slope.along(0, way.at + way_current) - x, slope.along(1, way.at + way_current) - y};
    const T seen = (extra[0] * extra[0] + extra[1] * extra[1] - T(2) * drift * drift) / square;
    const T more = T(suspected_part) * min(seen, T(4)) - way.suspected;
    if (!(T(0) < more)) return;
    way.suspected += more;
    // What changes nothing of the velocity x' = c + a U f + b U f_left on this heading.
    const T alike[2][way_states - way_current] = {{-x, -y, T(1), T(0)}, {y, -x, T(0), T(1)}};
    for (const auto& change : alike)
        for (int i = way_current; i < way_states; ++i)
            for (int k = way_current; k < way_states; ++k)
                way.spread[i][k] += more * change[i - way_current] * change[k - way_current];
}

/// A field that turns the attitude faster than any offset of the gyroscope is not the Earth's alone: iron on board
/// turns with the robot. What fixes said of the compass on another heading then no longer holds.
template <class T>
void compare_gyroscope(const AttitudeModel<T>& frame, WayState<T>& way, T pulled) {
    const T turned = frame.tick * (abs(pulled) - frame.drift_max), before = way.apart;
    way.apart = max(T(0), before + turned);
    if (turned < T(0)) return;
    for (int k = way_along; k < way_states; ++k) way.spread[k][k] += (before + way.apart) * turned;
}

/// Whether the compass is off: by its deviations beyond an angle to the course, or against the gyroscope.
template <class T>
bool compass_is_off(const WayState<T>& way) {
    const T slope = T(off_slope), beyond = abs(way.at[way_across]) - slope * way.at[way_along];
    const T variance = way.spread[way_across][way_across] + slope * slope * way.spread[way_along][way_along];
    const bool against = T(0) < beyond && T(off_deviations * off_deviations) * variance < beyond * beyond;
    return against || T(off_turn) < way.apart;
}

/// Where the robot faces by the course, of what it faces by the compass.
template <class T>
void face_by_course(const WayState<T>& way, Vector<T>& facing) {
    const T a = way.at[way_along], b = way.at[way_across], size = sqrt(a * a + b * b);
    if (!(T(0.05) < size)) return;
    const T x = facing.x, y = facing.y;
    facing.x = (a * x - b * y) / size, facing.y = (a * y + b * x) / size;
}

// --- fixes

/// s for which refused fixes must be at one place until it is the estimate that was wrong; of which a pause between two
/// of them is at most one. Reflected signals last some seconds.
inline constexpr float doubt_time = 30, doubt_pause = 1;

/// Refuse a fix. The longer fixes agree within `near` [m^2], the less the estimate is believed.
template <class T>
void refuse(Doubt<T>& doubt, const T (&off)[2], T near) {
    const T x = off[0] - doubt.off[0], y = off[1] - doubt.off[1];
    const bool agrees = 0 < doubt.fixes && x * x + y * y < near;
    doubt.agree = agrees ? doubt.agree + min(doubt.since, T(doubt_pause)) : T(0);
    for (int k = 0; k < 2; ++k) doubt.off[k] = off[k];
    if (doubt.fixes < 1 << 30) ++doubt.fixes;
    doubt.since = T(0);
}

/// Begin anew at a fix whose noise has this variance: the robot was carried there, or lost its way.
template <class T>
void begin_at(const WayModel<T>& model, WayState<T>& way, const T (&fix)[2], T noise) {
    for (int axis = 0; axis < 2; ++axis) {
        for (int k = 0; k < way_states; ++k) way.spread[axis][k] = way.spread[k][axis] = T(0);
        way.at[axis] = fix[axis], way.spread[axis][axis] = noise;
        way.spread[way_current + axis][way_current + axis] += model.current_error * model.current_error;
    }
}

/// Use a fix if it is plausible, by the accuracy [m] that the receiver tells; 0 where it tells none. It is within the
/// deviations of the estimate, and no farther from the last one than the robot can have come. Others are refused
/// without a trace in the filter, until they have agreed for long.
template <class T>
bool take_fix(const WayModel<T>& model, WayState<T>& way, const T (&fix)[2], T accuracy) {
    const T off[2] = {fix[0] - way.at[0], fix[1] - way.at[1]}, deviation = max(model.fix_noise, accuracy);
    // Nor what is no number.
    if (!(abs(off[0]) < T(1e5) && abs(off[1]) < T(1e5) && deviation <= model.fix_error_max)) return false;
    const T noise = deviation * deviation, extra = noise + model.fix_offset * model.fix_offset;
    const T square = off[0] * off[0] / (way.spread[0][0] + extra) + off[1] * off[1] / (way.spread[1][1] + extra);
    const T x = fix[0] - way.from[0], y = fix[1] - way.from[1], far = way.reach + T(reach_gate) * sqrt(extra);
    const bool reached = x * x + y * y <= far * far;
    if (reached && square <= (0 < way.doubt.fixes ? T(doubt_gate) : T(fix_gate))) {
        for (int axis = 0; axis < 2; ++axis) take_fix(way, axis, fix[axis] - way.at[axis], noise);
        suspect_compass(way);
    } else {
        refuse(way.doubt, off, T(2 * fix_gate) * noise);
        way.doubt.reached = reached;
        if (way.doubt.agree < T(doubt_time)) return false;
        begin_at(model, way, fix, noise);
    }
    way.doubt = {};
    way.reach = T(reach_gate) * deviation;
    for (int k = 0; k < 2; ++k) way.from[k] = way.at[k];
    return true;
}

/// Standard deviation of the position along its worst direction, with what all fixes share and with what speaks for
/// those that are refused: nothing where the robot cannot have come.
template <class T>
T position_error(const WayModel<T>& model, const WayState<T>& way) {
    const T mean = T(0.5) * (way.spread[0][0] + way.spread[1][1]),
            half = T(0.5) * (way.spread[0][0] - way.spread[1][1]);
    const T largest = mean + sqrt(half * half + way.spread[0][1] * way.spread[0][1]);
    const T(&off)[2] = way.doubt.off;
    const T agree = way.doubt.reached ? way.doubt.agree / T(doubt_time) : T(0);
    const T doubted = agree * (off[0] * off[0] + off[1] * off[1]) / T(doubt_gate);
    return sqrt(max(T(0), largest) + model.fix_offset * model.fix_offset + doubted);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
