/// Estimator: attitude, depth and sink rate, and a dead reckoning that satellite fixes at the surface put right.
///
/// Under water nothing measures speed: the gait says it, and the compass says where to. So position, current, a factor
/// on the gait's speed and the error of the compass are estimated together by a Kalman filter, x' = c + U (a f + b
/// f_left) with the facing direction f: a fix after a dive tells the current from the error of the way, and two
/// headings tell it from the factors. A compass that is off by an angle has a = cos, b = sin of it.
///
/// The depth sensor measures absolute pressure: weather and altitude shift it by meters. Its zero is what it shows at
/// the surface, or in the air.
#pragma once

#include "hypertuna/pilot/attitude.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// What the pilot knows of where it is. Quaternion body -> world, rates in body axes, current toward.
template <class T>
struct Estimate {
    Quaternion<T> q;
    Vector<T> rate;        // rad/s
    T depth, sink;         // m, m/s down
    T x, y;                // m east and north
    T speed;               // m/s through the water, ahead
    T factor;              // of the speed that the gait says, 1
    T current[2];          // m/s
    T position_error;      // m, standard deviation along its worst direction
    T drift_error;         // m/s, standard deviation of the velocity over ground, of its worse component
    bool fix;              // a fix was taken in in this tick
    bool attitude;         // rates and gravity can be used
    bool compass, depths;  // the field, the depth can be used
    bool compass_off;      // the compass disagrees with the course over ground, or with the gyroscope
    bool zeroed;           // the depth counts from a surface that the sensor was seen at
    Vector<T> facing;      // direction that the head faces, in world axes
    T tilt;                // rad: roll, starboard down
};

inline constexpr int still_max = 500;  // equal readings of depth while it swims: the sensor is stuck
/// Where the numbers of the way's state begin: position x, y, current x, y, factors ahead and to the left.
enum WayPlace { way_position = 0, way_current = 2, way_along = 4, way_across, way_states };

template <class T>
struct Estimator {
    AttitudeModel<T> attitude;
    T depth_rate;                                // 1/s of the depth observer
    T depth_low, depth_high, depth_step;         // m: range, largest change within a tick
    T depth_repeat, field_repeat;                // m, 1: change that a working sensor may not show; 0 where noise does
    T glide;                                     // m in which the robot slows to 1/e when it stops beating
    T position_walk, current_walk, factor_walk;  // m, m/s, 1 per root of a second: what the way is uncertain by
    T start_error, current_error, factor_error;  // standard deviations at the start
    T fix_noise, fix_offset;                     // m: noise of a fix, and what many of them share
    T fix_error_max;                             // m: a receiver that tells more has no fix
    T fix_depth;                                 // m: deeper there can be none
    T air_low, air_high;                         // m that the sensor shows in the air, of any weather and altitude
    T antenna_x, antenna_z;                      // m toward the tail and up, from the depth sensor
};

template <class T, class Visit>
void visit_fields(Estimator<T>& m, const Visit& visit) {
    visit_fields(m.attitude, visit);
    visit("depth_rate", 0, m.depth_rate), visit("depth_low", 0, m.depth_low), visit("depth_high", 0, m.depth_high);
    visit("depth_step", 0, m.depth_step), visit("depth_repeat", 0, m.depth_repeat);
    visit("field_repeat", 0, m.field_repeat), visit("glide", 0, m.glide), visit("position_walk", 0, m.position_walk);
    visit("current_walk", 0, m.current_walk), visit("factor_walk", 0, m.factor_walk);
    visit("start_error", 0, m.start_error), visit("current_error", 0, m.current_error);
    visit("factor_error", 0, m.factor_error), visit("fix_noise", 0, m.fix_noise);
    visit("fix_offset", 0, m.fix_offset), visit("fix_depth", 0, m.fix_depth);
    visit("fix_error_max", 0, m.fix_error_max);
    visit("air_low", 0, m.air_low), visit("air_high", 0, m.air_high);
    visit("antenna_x", 0, m.antenna_x), visit("antenna_z", 0, m.antenna_z);
}

template <class T>
struct WayState {
    T at[way_states];
    T spread[way_states][way_states];  // covariance
    T moved[2];                        // m through the water since the covariance was carried on, by gait and compass
    int ticks;                         // since then
    T swim[2];                         // m/s: its mean over some beats
    T suspected;                       // variance of the factors for what looks like a current
    T apart;                           // rad by which field and gyroscope turned apart, beyond the gyroscope's offset
    int refused;                       // fixes in a row that agree
    T off[2];                          // m from the last of them
    T astray;                          // m swum since the attitude was lost
};

template <class T>
struct EstimatorState {
    AttitudeState<T> attitude;
    Health<T> depth_health, field_health[3];
    T depth, sink;
    bool dipped;            // a depth was seen
    int still;              // equal readings of depth in a row while it swims
    T climbed;              // m up or down since the reading of depth changed
    T zero;                 // m that the depth sensor shows at the surface
    bool zeroed;            // it was seen there
    T air_max;              // m that the sensor may show at boot in the air
    int boot, boot_usable;  // ticks and usable readings of the depth sensor since boot, until its zero is taken
    int dry;                // fixes in a row at a depth where there can be none
    T speed;                // m/s by the gait, factor 1
    WayState<T> way;
};

template <class T>
EstimatorState<T> init(const Estimator<T>& model, const T (&start)[2]) {
    EstimatorState<T> state{};
    state.attitude.q.w = T(1);
    state.air_max = model.air_high;
    WayState<T>& way = state.way;
    way.at[way_position] = start[0], way.at[way_position + 1] = start[1], way.at[way_along] = T(1);
    const T error[way_states] = {model.start_error,   model.start_error,  model.current_error,
                                 model.current_error, model.factor_error, model.factor_error};
    for (int k = 0; k < way_states; ++k) way.spread[k][k] = error[k] * error[k];
    return state;
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
void carry(const Estimator<T>& model, WayState<T>& way) {
    const T dt = T(way.ticks) * model.attitude.tick;
    const WaySlope<T> slope(dt, way.moved[0], way.moved[1]);
    for (int i = 0; i < 2; ++i) way.at[i] += slope.along(i, way.at + way_current);
    for (const bool columns : {false, true}) {  // after the rows
        T added[2][way_states];
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < way_states; ++k) added[i][k] = slope.along(i, way.spread[k] + way_current);
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < way_states; ++k) (columns ? way.spread[k][i] : way.spread[i][k]) += added[i][k];
    }
    const T rate = min(T(swim_rate), T(1) / max(dt, model.attitude.tick));
    for (int i = 0; i < 2; ++i) way.swim[i] += rate * (way.moved[i] - dt * way.swim[i]);
    const T noise[3] = {model.position_walk, model.current_walk, model.factor_walk};
    for (int k = 0; k < way_states; ++k) way.spread[k][k] += noise[k / 2] * noise[k / 2] * dt;
    way.moved[0] = way.moved[1] = T(0);
    way.ticks = 0;
}

/// Swim on without knowing where to: after a way of that kind the position is as uncertain as the way is long.
template <class T>
void go_astray(WayState<T>& way, T swum, bool known) {
    way.astray = known ? T(0) : way.astray + abs(swum);
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
    const T size = factor_of(way), scale = min(T(1), T(1.7) / size);
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

/// Squares of the deviations within which a fix is believed, all but one in 1000; and while fixes are refused.
inline constexpr double fix_gate = 14, doubt_gate = 5;
inline constexpr int fixes_refused = 30;  // in a row at one place: then it is the estimate that was wrong

/// A fix beyond the gate may be a reflected signal for some seconds. The longer fixes agree within `near` [m^2], the
/// less the estimate is believed: in `fixes_refused` of them its variance grows by `wide` [m^2], and the gate opens.
template <class T>
void doubt(const Estimator<T>& model, WayState<T>& way, const T (&off)[2], T near, T wide) {
    const T x = off[0] - way.off[0], y = off[1] - way.off[1], part = T(1) / T(fixes_refused);
    way.refused = way.refused > 0 && x * x + y * y < near ? way.refused + 1 : 1;
    for (int k = 0; k < 2; ++k) way.off[k] = off[k];
    if (way.refused == 1) return;
    for (int k = 0; k < 2; ++k) {
        way.spread[k][k] += part * max(T(0), wide);
        way.spread[2 + k][2 + k] += part * model.current_error * model.current_error;
    }
}

/// Use a fix if it is plausible, by the accuracy [m] that the receiver tells; 0 where it tells none.
template <class T>
bool take_fix(const Estimator<T>& model, WayState<T>& way, const T (&fix)[2], T accuracy) {
    carry(model, way);
    const T off[2] = {fix[0] - way.at[0], fix[1] - way.at[1]}, deviation = max(model.fix_noise, accuracy);
    // Nor what is no number.
    if (!(abs(off[0]) < T(1e5) && abs(off[1]) < T(1e5) && deviation <= model.fix_error_max)) return false;
    const T noise = deviation * deviation, extra = noise + model.fix_offset * model.fix_offset;
    const T square = off[0] * off[0] / (way.spread[0][0] + extra) + off[1] * off[1] / (way.spread[1][1] + extra);
    if ((way.refused > 0 ? T(doubt_gate) : T(fix_gate)) < square) {
        const T far = off[0] * off[0] + off[1] * off[1];
        doubt(model, way, off, T(2 * fix_gate) * noise, far / T(doubt_gate) - extra);
        return false;
    }
    way.refused = 0;
    for (int axis = 0; axis < 2; ++axis) take_fix(way, axis, fix[axis] - way.at[axis], noise);
    suspect_compass(way);
    return true;
}

/// Standard deviation of the position along its worst direction, with what all fixes share.
template <class T>
T position_error(const Estimator<T>& model, const WayState<T>& way) {
    const T mean = T(0.5) * (way.spread[0][0] + way.spread[1][1]),
            half = T(0.5) * (way.spread[0][0] - way.spread[1][1]);
    const T largest = mean + sqrt(half * half + way.spread[0][1] * way.spread[0][1]);
    return sqrt(max(T(0), largest) + model.fix_offset * model.fix_offset);
}

// --- the surface

inline constexpr int boot_ticks = 100, boot_readings = 25;  // the first readings after boot, and how many are averaged
inline constexpr int dry_fixes = 5;                         // in a row: then it is the depth that was wrong

/// Move the surface by which the depth counts, if the sensor can show that in the air.
template <class T>
bool shift_zero(const Estimator<T>& model, EstimatorState<T>& state, T shift) {
    const T zero = state.zero + shift;
    if (!(model.air_low <= zero && zero <= model.air_high)) return false;
    state.zero = zero, state.depth -= shift;
    return true;
}

/// Take the present reading as the surface, on arming or on command: false where it is no reading, or none of the air.
template <class T>
bool zero_depth(const Estimator<T>& model, EstimatorState<T>& state) {
    if (!state.dipped || state.depth_health.bucket > 0 || !shift_zero(model, state, state.depth)) return false;
    state.sink = T(0), state.zeroed = true, state.boot = boot_ticks;
    return true;
}

/// Go on with a zero from before a restart.
template <class T>
void keep_zero(EstimatorState<T>& state, T zero) {
    state.zero = zero, state.zeroed = true, state.boot = boot_ticks;
}

inline constexpr float weather_max = 0.4f;  // m of water, 39 hPa: the weather rises by less between two swims

/// Begin with what the sensor showed at the surface before it was switched on: what shows much more is under water,
/// until a fix, the ground or an ascent says otherwise.
template <class T>
void expect_surface(const Estimator<T>& model, EstimatorState<T>& state, T zero) {
    state.zero = zero, state.air_max = min(model.air_high, zero + T(weather_max));
}

/// The first readings after boot are those of the surface, if the sensor can show them in the air of these days: one
/// that begins under water, or answers later, has no zero yet.
template <class T>
void zero_at_boot(const Estimator<T>& model, EstimatorState<T>& state, T reading, bool usable) {
    if (state.boot == boot_ticks) return;
    ++state.boot;
    if (!usable) return;
    if (state.boot_usable == 0) state.zeroed = model.air_low <= reading && reading <= state.air_max;
    if (state.zeroed) state.zero += (reading - state.zero) / T(++state.boot_usable);
    if (!state.zeroed || state.boot_usable == boot_readings) state.boot = boot_ticks;
}

/// A sensor is never above the surface: in the air it shows the air's pressure. What is less moves the zero.
template <class T>
void bound_depth(const Estimator<T>& model, EstimatorState<T>& state) {
    if (state.depth < T(0)) shift_zero(model, state, model.depth_rate * model.attitude.tick * state.depth);
}

/// Whether a fix is believed at this depth; after several that are not it is the depth's zero that is not.
template <class T>
bool believes_fixes(const Estimator<T>& model, EstimatorState<T>& state, bool usable) {
    state.dry = usable && state.zeroed && model.fix_depth <= state.depth ? state.dry + 1 : 0;
    if (state.dry == dry_fixes) state.zeroed = false, state.dry = 0;
    return state.dry == 0;
}

/// A fix proves that the antenna is out of the water, a second ago at most. A depth that keeps it below moves the zero:
/// at once where there is none, else slowly.
template <class T>
void follow_surface(const Estimator<T>& model, EstimatorState<T>& state, const Vector<T>& up) {
    const T highest = max(T(0), up.x * model.antenna_x + up.z * model.antenna_z);
    const T below = max(T(0), state.depth - max(T(0), state.sink) - highest);
    if (state.zeroed && below == T(0)) return;
    const bool moved = shift_zero(model, state, state.zeroed ? T(0.1) * below : below);
    state.zeroed = state.zeroed || moved;
}

/// Depth with its rate by a critically damped observer. A sensor that is stuck shows by equal readings: at once on the
/// way up or down, and in some seconds of any swim where its noise exceeds its resolution.
template <class T>
bool watch_depth(const Estimator<T>& model, EstimatorState<T>& state, T reading, T climb, T speed) {
    const T dt = model.attitude.tick;
    const bool moving = T(0.05) < abs(climb) && model.depth_repeat <= abs(state.climbed);
    const ReadingQuality<T> quality = judge({model.depth_low, model.depth_high, model.depth_step, T(repeats_slow)},
                                            state.depth_health, reading, state.depth_health.last, moving);
    state.climbed = quality.repeated ? state.climbed + climb * dt : T(0);
    if (!quality.repeated)
        state.still = 0;
    else if (T(0.1) < speed && model.depth_repeat == T(0) && state.still < still_max)
        ++state.still;
    const bool usable = quality.usable && state.still < still_max;
    zero_at_boot(model, state, reading, usable);
    if (usable && !state.dipped) state.depth = reading - state.zero, state.dipped = true;
    state.depth += state.sink * dt;
    if (usable) {
        const T error = reading - state.zero - state.depth, step = model.depth_rate * dt;
        state.depth += T(2) * step * error;
        state.sink += model.depth_rate * step * error;
        bound_depth(model, state);
    } else {
        state.sink -= model.depth_rate * dt * state.sink;
    }
    return usable;
}

template <class T>
bool watch_field(const Estimator<T>& model, EstimatorState<T>& state, const T (&field)[3], bool moving) {
    bool usable = true;
    for (int k = 0; k < 3; ++k) {
        const T limit = model.attitude.field_high;
        usable = judge({-limit, limit, limit, T(repeats_slow)}, state.field_health[k], field[k],
                       state.field_health[k].last, moving && model.field_repeat == T(0))
                     .usable &&
                 usable;
    }
    const T strength = usable ? norm(Vector<T>{field[0], field[1], field[2]}) : T(0);
    return usable && model.attitude.field_low < strength && strength < model.attitude.field_high;
}

/// Attitude toward true north, of one toward magnetic north: turned about the vertical by the declination, clockwise.
template <class T>
Quaternion<T> true_attitude(const Quaternion<T>& q, T declination) {
    const SinCos<T> half = sincos(T(-0.5) * declination);
    return {half.cos * q.w - half.sin * q.z, half.cos * q.x - half.sin * q.y, half.cos * q.y + half.sin * q.x,
            half.cos * q.z + half.sin * q.w};
}

/// One tick. `beat_speed` is the speed that the present beat keeps up, `imu` whether the controller believes the IMU,
/// `declination` that of the magnetic field [rad, east positive].
template <class T>
Estimate<T> estimate(const Estimator<T>& model, EstimatorState<T>& state, const PilotReadings<T>& readings,
                     T beat_speed, bool imu, T declination) {
    const AttitudeModel<T>& frame = model.attitude;
    const T dt = frame.tick;
    Estimate<T> out{};
    AttitudeInput<T> in{};
    const Readings<T>& robot = readings.robot;
    in.rate = {robot.rate[0], robot.rate[1], robot.rate[2]};
    in.acceleration = {robot.acceleration[0], robot.acceleration[1], robot.acceleration[2]};
    in.field = {readings.field[0], readings.field[1], readings.field[2]};
    in.gyro = in.gravity = imu;
    for (int k = 0; k < 3; ++k) {  // false for what is no number
        in.gyro = in.gyro && abs(robot.rate[k]) <= frame.rate_max;
        in.gravity = in.gravity && abs(robot.acceleration[k]) <= frame.acceleration_max;
    }
    in.magnet = watch_field(model, state, readings.field, T(0.05) < abs(state.attitude.rate.z));
    in.speed = state.speed * factor_of(state.way);
    state.attitude = attitude_step(frame, state.attitude, in);
    out.q = true_attitude(state.attitude.q, declination);
    const Rotation<T> pose = rotation(out.q);
    out.facing = {-pose.east.x, -pose.north.x, -pose.up.x};

    // Thrust against quadratic drag: U' = (U_beat^2 - U^2) / glide.
    state.speed += dt * (beat_speed * abs(beat_speed) - state.speed * abs(state.speed)) / model.glide;
    WayState<T>& way = state.way;
    way.moved[0] += dt * state.speed * out.facing.x;
    way.moved[1] += dt * state.speed * out.facing.y;
    out.attitude = imu && state.attitude.known;
    go_astray(way, out.attitude ? T(0) : dt * in.speed, out.attitude);
    ++way.ticks;
    out.depths = watch_depth(model, state, readings.depth, in.speed * out.facing.z, in.speed);
    // Without a valid depth every fix is used: under water the receiver has none.
    if (readings.fixed && believes_fixes(model, state, out.depths))
        out.fix = take_fix(model, way, readings.fix, readings.accuracy);
    if (out.fix && out.depths && out.attitude) follow_surface(model, state, pose.up);
    out.zeroed = state.zeroed;

    const T since = T(way.ticks) * dt;
    out.rate = state.attitude.rate;
    out.depth = state.depth, out.sink = state.sink;
    const WaySlope<T> slope(since, way.moved[0], way.moved[1]);
    out.x = way.at[0] + slope.along(0, way.at + way_current);
    out.y = way.at[1] + slope.along(1, way.at + way_current);
    out.factor = factor_of(way);
    out.speed = state.speed * out.factor;
    out.current[0] = way.at[way_current], out.current[1] = way.at[way_current + 1];
    out.position_error = position_error(model, way);
    out.drift_error = drift_error(way, state.speed * out.facing.x, state.speed * out.facing.y);
    if (in.gyro && in.magnet) compare_gyroscope(frame, way, state.attitude.pulled);
    out.compass_off = compass_is_off(way);
    face_by_course(way, out.facing);
    out.compass = in.magnet;
    out.tilt = -pose.up.y;
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
