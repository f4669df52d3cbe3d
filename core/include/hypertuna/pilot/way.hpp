/// Way: the robot's position by dead reckoning, and its uncertainty.
///
/// Under water nothing measures the velocity: its size is the gait's, its direction the compass'. So a Kalman filter
/// estimates position, current, a factor on the gait's speed and the error of the compass together, x' = c + U (a f + b
/// f_left) with the facing direction f. A fix after a dive shows the current by the error of the position, and two
/// headings tell the current from the factors. A compass that is off by an angle has a = cos, b = sin of that angle;
/// the filter of compass.hpp shows it sooner, and this one then begins anew from that.
#pragma once

#include "hypertuna/pilot/attitude.hpp"
#include "hypertuna/pilot/compass.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Indices of the filter's state: position x, y, current x, y, factors ahead and to the left.
enum WayPlace { way_position = 0, way_current = 2, way_along = 4, way_across, way_states };

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
    T off[2];        // m: place of the last one relative to the estimate
    T since, agree;  // s since the last one; s for which they have agreed on one place
};

template <class T>
struct WayState {
    T at[way_states];
    T spread[way_states][way_states];  // covariance
    T moved[2];                        // m swum through the water since the last `carry`, by gait and compass
    int ticks;                         // ticks since the last `carry`
    T swim[2];                         // m/s: mean velocity through the water over some beats
    T suspected;                       // variance given to the factors because of an apparent current
    T apart;           // rad by which the field has turned relative to the gyroscope, beyond the gyroscope's offset
    T from[2], reach;  // m: place of the last fix that was taken, and how far from it the robot can be
    RefusedFixes<T> refused;
    T astray;  // m swum since the attitude was lost
    CompassState<T> compass;
};

/// Largest squared deviation of a fix that is believed, in variances: all but one fix in 1000 keep it; and while fixes
/// are refused.
inline constexpr double fix_gate = 14, refused_gate = 5;
inline constexpr float reach_gate = 3.74f,
                       speed_factor_max = 1.7f;  // root of fix_gate; largest factor on the gait's speed

template <class T>
WayState<T> init(const WayModel<T>& model, const T (&start)[2]) {
    WayState<T> way{};
    for (int k = 0; k < 2; ++k) way.at[way_position + k] = way.from[k] = start[k];
    way.at[way_along] = T(1);
    const T error[way_states] = {model.start_error,   model.start_error,  model.current_error,
                                 model.current_error, model.factor_error, model.factor_error};
    for (int k = 0; k < way_states; ++k) way.spread[k][k] = error[k] * error[k];
    way.reach = T(reach_gate) * model.start_error;
    way.compass = init_compass({start[0], start[1]}, model.start_error, model.current_error);
    return way;
}

/// Derivatives of the position's coordinates with respect to current and factors, after a way through the water.
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

/// Carry position and covariance on over the way swum since the last call: P <- F P F' + Q, F = 1 but for the rows of
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
    const T walk[3] = {model.position_walk, model.current_walk, model.factor_walk};
    T noise[3];
    for (int k = 0; k < 3; ++k) noise[k] = walk[k] * walk[k] * dt;
    for (int k = 0; k < way_states; ++k) way.spread[k][k] += noise[k / 2];
    carry(way.compass, dt, {way.moved[0], way.moved[1]}, noise);
    const T current = abs(way.at[way_current]) + abs(way.at[way_current + 1]) + T(reach_gate) * model.current_error;
    way.reach += T(speed_factor_max) * sqrt(way.moved[0] * way.moved[0] + way.moved[1] * way.moved[1]) + current * dt;
    way.refused.since += dt;
    way.moved[0] = way.moved[1] = T(0);
    way.ticks = 0;
}

/// Add to the uncertainty while the robot swims without an attitude: the position becomes as uncertain as that way is
/// long.
template <class T>
void go_astray(WayState<T>& way, T swum, bool known) {
    way.astray = known ? T(0) : way.astray + abs(swum);
    if (!known) way.reach += T(speed_factor_max) * abs(swum);
    const T more = T(2) * way.astray * abs(swum);
    for (int axis = 0; axis < 2; ++axis) way.spread[axis][axis] += more;
    way.compass.position_square += more;
}

/// Speed through the water over that of the gait.
template <class T>
T factor_of(const WayState<T>& way) {
    return max(T(0.3), sqrt(way.at[way_along] * way.at[way_along] + way.at[way_across] * way.at[way_across]));
}

template <class T>
void bound_factor(WayState<T>& way) {
    const T size = factor_of(way), scale = min(T(1), T(speed_factor_max) / size);
    way.at[way_along] *= scale, way.at[way_across] *= scale;
}

/// Kalman update by one coordinate of a fix; `noise` is its variance [m^2].
template <class T>
void take_fix(WayState<T>& way, int axis, T innovation, T noise) {
    const T variance = way.spread[axis][axis] + noise;
    T gain[way_states], row[way_states];
    for (int k = 0; k < way_states; ++k) gain[k] = way.spread[k][axis] / variance, row[k] = way.spread[axis][k];
    for (int i = 0; i < way_states; ++i) {
        way.at[i] += gain[i] * innovation;
        for (int k = 0; k < way_states; ++k) way.spread[i][k] -= gain[i] * row[k];
    }
    bound_factor(way);
    for (int i = 0; i < way_states; ++i) {
        for (int k = 0; k < i; ++k)  // rounding must leave the covariance symmetric
            way.spread[i][k] = way.spread[k][i] = T(0.5) * (way.spread[i][k] + way.spread[k][i]);
        way.spread[i][i] = max(way.spread[i][i], T(1e-8));
    }
}

/// Standard deviation of the velocity over ground [m/s], of its worse component, at a velocity through the water: how
/// fast the position error grows in a dive.
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

inline constexpr float suspected_part =
    0.25f;  // part of the factors' variance that would explain the whole apparent current
/// rad by which the field turned relative to the gyroscope, beyond which a compass is off.
inline constexpr float off_turn = 0.35f;

/// Make the factors uncertain where there seems to be a current. On one heading a compass that is off looks like one, v
/// over ground minus U f; but a current stays where it is, and the compass' error turns with the robot. The current
/// becomes uncertain along with the factors, so that the velocity on the present heading remains known. Each amount is
/// added once: what fixes on two headings showed does not become uncertain again.
template <class T>
void suspect_compass(WayState<T>& way) {
    const T x = way.swim[0], y = way.swim[1], square = x * x + y * y;
    if (!(T(0.01) < square)) return;
    const WaySlope<T> slope(T(1), x, y);
    const T drift = drift_error(way, x, y);
    const T extra[2] = {slope.along(0, way.at + way_current) - x, slope.along(1, way.at + way_current) - y};
    const T excess = (extra[0] * extra[0] + extra[1] * extra[1] - T(2) * drift * drift) / square;
    const T more = T(suspected_part) * min(excess, T(4)) - way.suspected;
    if (!(T(0) < more)) return;
    way.suspected += more;
    // Changes of current and factors that leave the velocity x' = c + a U f + b U f_left on this heading as it is.
    const T alike[2][way_states - way_current] = {{-x, -y, T(1), T(0)}, {y, -x, T(0), T(1)}};
    for (const auto& change : alike)
        for (int i = way_current; i < way_states; ++i)
            for (int k = way_current; k < way_states; ++k)
                way.spread[i][k] += more * change[i - way_current] * change[k - way_current];
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
    for (int k = way_along; k < way_states; ++k) way.spread[k][k] += more;
    way.compass.factor_square += more;
}

/// Whether the compass is off, by the course over ground or against the gyroscope.
template <class T>
bool compass_is_off(const WayState<T>& way) {
    return is_off(way.compass) || T(off_turn) < way.apart;
}

/// Take the estimate of the compass' filter for that of the way. Of two complex errors e and f, the covariance has
/// E[Re e Re f] = E[Im e Im f] as its real part, and E[Im e Re f] = -E[Re e Im f] as its imaginary one.
template <class T>
void believe_compass_filter(WayState<T>& way) {
    const CompassState<T>& c = way.compass;
    const Complex<T> at[3] = {c.position, c.current, c.factor};
    const Complex<T> spread[3][3] = {
        {{c.position_square, T(0)}, c.position_current, c.position_factor},
        {conj(c.position_current), {c.current_square, T(0)}, c.current_factor},
        {conj(c.position_factor), conj(c.current_factor), {c.factor_square, T(0)}},
    };
    for (int i = 0; i < 3; ++i) {
        way.at[2 * i] = at[i].re, way.at[2 * i + 1] = at[i].im;
        for (int k = 0; k < 3; ++k) {
            way.spread[2 * i][2 * k] = way.spread[2 * i + 1][2 * k + 1] = spread[i][k].re;
            way.spread[2 * i + 1][2 * k] = spread[i][k].im, way.spread[2 * i][2 * k + 1] = -spread[i][k].im;
        }
    }
    bound_factor(way);
}

/// Correct the direction that the robot faces by the compass, in place, by the error that fixes showed.
template <class T>
void face_by_course(const WayState<T>& way, Vector<T>& facing) {
    const T a = way.at[way_along], b = way.at[way_across], size = sqrt(a * a + b * b);
    if (!(T(0.05) < size)) return;
    const T x = facing.x, y = facing.y;
    facing.x = (a * x - b * y) / size, facing.y = (a * y + b * x) / size;
}

// --- fixes

/// s for which refused fixes must agree on one place until the estimate counts as wrong; longest pause between two of
/// them that counts [s]. Reflected signals last some seconds.
inline constexpr float refused_time = 30, refused_pause = 1;

/// Record a refused fix. The longer fixes agree within `near` [m^2], the less the estimate is believed.
template <class T>
void refuse(RefusedFixes<T>& refused, const T (&off)[2], T near) {
    const T x = off[0] - refused.off[0], y = off[1] - refused.off[1];
    const bool agrees = 0 < refused.count && x * x + y * y < near;
    refused.agree = agrees ? refused.agree + min(refused.since, T(refused_pause)) : T(0);
    for (int k = 0; k < 2; ++k) refused.off[k] = off[k];
    if (refused.count < 1 << 30) ++refused.count;
    refused.since = T(0);
}

/// Begin anew at a fix with the variance `noise` [m^2]: the robot was carried there, or its estimate was wrong.
template <class T>
void begin_at(const WayModel<T>& model, WayState<T>& way, const T (&fix)[2], T noise) {
    for (int axis = 0; axis < 2; ++axis) {
        for (int k = 0; k < way_states; ++k) way.spread[axis][k] = way.spread[k][axis] = T(0);
        way.at[axis] = fix[axis], way.spread[axis][axis] = noise;
        way.spread[way_current + axis][way_current + axis] += model.current_error * model.current_error;
    }
    begin_at(way.compass, {fix[0], fix[1]}, noise, model.current_error);
}

/// Use a fix if it is plausible, and return whether it was used. A fix must agree with the estimate within the
/// deviations, and lie no farther from the last one than the robot can have come. Others leave the filter unchanged,
/// until they have agreed for long. `accuracy` [m] is the receiver's own; 0 where unknown.
template <class T>
bool take_fix(const WayModel<T>& model, WayState<T>& way, const T (&fix)[2], T accuracy) {
    const T off[2] = {fix[0] - way.at[0], fix[1] - way.at[1]}, deviation = max(model.fix_noise, accuracy);
    // NaN is refused as well.
    if (!(abs(off[0]) < T(1e5) && abs(off[1]) < T(1e5) && deviation <= model.fix_error_max)) return false;
    const T noise = deviation * deviation, extra = noise + model.fix_offset * model.fix_offset;
    const T square = off[0] * off[0] / (way.spread[0][0] + extra) + off[1] * off[1] / (way.spread[1][1] + extra);
    const T x = fix[0] - way.from[0], y = fix[1] - way.from[1], far = way.reach + T(reach_gate) * sqrt(extra);
    const bool reached = x * x + y * y <= far * far;
    if (reached && square <= (0 < way.refused.count ? T(refused_gate) : T(fix_gate))) {
        for (int axis = 0; axis < 2; ++axis) take_fix(way, axis, fix[axis] - way.at[axis], noise);
        suspect_compass(way);
        take_fix(way.compass, {fix[0], fix[1]}, noise);
        if (is_off(way.compass)) believe_compass_filter(way);
    } else {
        refuse(way.refused, off, T(2 * fix_gate) * noise);
        way.refused.reached = reached;
        if (way.refused.agree < T(refused_time)) return false;
        begin_at(model, way, fix, noise);
    }
    way.refused = {};
    way.reach = T(reach_gate) * deviation;
    for (int k = 0; k < 2; ++k) way.from[k] = way.at[k];
    return true;
}

/// Standard deviation of the position along its worst direction [m]. It includes the error that all fixes share, and
/// refused fixes add to it the longer they agree on a place that the robot can have come to.
template <class T>
T position_error(const WayModel<T>& model, const WayState<T>& way) {
    const T mean = T(0.5) * (way.spread[0][0] + way.spread[1][1]),
            half = T(0.5) * (way.spread[0][0] - way.spread[1][1]);
    const T largest = mean + sqrt(half * half + way.spread[0][1] * way.spread[0][1]);
    const T(&off)[2] = way.refused.off;
    const T agree = way.refused.reached ? way.refused.agree / T(refused_time) : T(0);
    const T contradicted = agree * (off[0] * off[0] + off[1] * off[1]) / T(refused_gate);
    return sqrt(max(T(0), largest) + model.fix_offset * model.fix_offset + contradicted);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
