/// Estimator: attitude, depth, sink rate, and position by dead reckoning, which satellite fixes at the surface correct.
///
/// The depth sensor measures absolute pressure: weather and altitude shift it by meters. Its zero is its reading at the
/// surface, or in the air.
#pragma once

#include "hypertuna/pilot/way.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// The pilot's estimate of the robot's motion: quaternion from body to world, rates in body axes, velocity of the
/// current.
template <class T>
struct Estimate {
    Quaternion<T> q;
    Vector<T> rate;        // rad/s
    T depth, sink;         // m, m/s down
    T x, y;                // m east and north
    T speed;               // m/s through the water, ahead
    T factor;              // speed through the water over that of the gait
    T current[2];          // m/s
    T position_error;      // m, standard deviation along its worst direction
    T drift_error;         // m/s, standard deviation of the velocity over ground, of its worse component
    bool fix;              // a fix was used in this tick
    bool attitude;         // rates and gravity can be used
    bool compass, depths;  // whether the magnetic field and the depth can be used
    bool fixes_refused;    // the last fixes, more than one in a row, were refused
    bool compass_off;      // the compass disagrees with the course over ground, or with the gyroscope
    bool zeroed;           // the zero of the depth was measured at the surface or in the air
    Vector<T> facing;      // direction that the head faces, in world axes
    T tilt;                // sine of the roll, starboard down
};

inline constexpr int still_max = 500;  // equal depth readings in a row while swimming that show a stuck sensor

template <class T>
struct Estimator {
    AttitudeModel<T> attitude;
    T depth_rate;                         // 1/s of the depth observer
    T depth_low, depth_high, depth_step;  // m: range, largest change within a tick
    T depth_repeat,
        field_repeat;  // m, 1: change that a working sensor may not show; 0 where its noise exceeds its resolution
    T glide;           // m in which the robot slows to 1/e when it stops beating
    WayModel<T> way;
    T fix_depth;             // m: largest depth at which there can be a fix
    T air_low, air_high;     // m: range of the sensor's readings in the air, at any weather and altitude
    T antenna_x, antenna_z;  // m toward the tail and up, from the depth sensor
};

template <class T, class Visit>
void visit_fields(Estimator<T>& m, const Visit& visit) {
    visit_fields(m.attitude, visit);
    visit("depth_rate", 0, m.depth_rate), visit("depth_low", 0, m.depth_low), visit("depth_high", 0, m.depth_high);
    visit("depth_step", 0, m.depth_step), visit("depth_repeat", 0, m.depth_repeat);
    visit("field_repeat", 0, m.field_repeat), visit("glide", 0, m.glide);
    visit_fields(m.way, visit);
    visit("fix_depth", 0, m.fix_depth);
    visit("air_low", 0, m.air_low), visit("air_high", 0, m.air_high);
    visit("antenna_x", 0, m.antenna_x), visit("antenna_z", 0, m.antenna_z);
}

template <class T>
struct EstimatorState {
    AttitudeState<T> attitude;
    Health<T> depth_health, field_health[3];
    T depth, sink;
    bool dipped;            // a depth has been read
    int still;              // equal readings of depth in a row while it swims
    T climbed;              // m up or down since the reading of depth changed
    T zero;                 // m that the depth sensor shows at the surface
    bool zeroed;            // the zero was measured at the surface
    T air_max;              // m: largest reading at boot that counts as one in the air
    int boot, boot_usable;  // ticks and usable readings of the depth sensor since boot, until its zero is taken
    int dry;                // fixes in a row at a depth where there can be none
    T speed;                // m/s by the gait alone, as if `factor` were 1
    WayState<T> way;
};

template <class T>
EstimatorState<T> init(const Estimator<T>& model, const T (&start)[2]) {
    EstimatorState<T> state{};
    state.attitude.q.w = T(1);
    state.air_max = model.air_high;
    state.way = init(model.way, start);
    return state;
}

// --- the surface

inline constexpr int boot_ticks = 100, boot_readings = 25;  // the first readings after boot, and how many are averaged
inline constexpr int dry_fixes = 5;  // fixes in a row at a depth where there can be none that prove the depth wrong

/// Move the zero of the depth, if the sensor can show the new zero in the air.
template <class T>
bool shift_zero(const Estimator<T>& model, EstimatorState<T>& state, T shift) {
    const T zero = state.zero + shift;
    if (!(model.air_low <= zero && zero <= model.air_high)) return false;
    state.zero = zero, state.depth -= shift;
    return true;
}

/// Take the present reading as the surface, on arming or on command; false without a valid reading, or where it cannot
/// be one in the air.
template <class T>
bool zero_depth(const Estimator<T>& model, EstimatorState<T>& state) {
    if (!state.dipped || state.depth_health.bucket > 0 || !shift_zero(model, state, state.depth)) return false;
    state.sink = T(0), state.zeroed = true, state.boot = boot_ticks;
    return true;
}

/// Restore the zero from before a restart.
template <class T>
void keep_zero(EstimatorState<T>& state, T zero) {
    state.zero = zero, state.zeroed = true, state.boot = boot_ticks;
}

inline constexpr float weather_max = 0.4f;  // m of water, 39 hPa: between two swims the air's pressure rises by less

/// Begin with the zero from before the robot was switched off: a much larger reading means that the robot is under
/// water, until a fix, the ground or an ascent says otherwise.
template <class T>
void expect_surface(const Estimator<T>& model, EstimatorState<T>& state, T zero) {
    state.zero = zero, state.air_max = min(model.air_high, zero + T(weather_max));
}

/// Average the first readings after boot as the zero, if they can be readings in the air of these days. A robot that
/// begins under water, or whose sensor answers later, has no zero yet.
template <class T>
void zero_at_boot(const Estimator<T>& model, EstimatorState<T>& state, T reading, bool usable) {
    if (state.boot == boot_ticks) return;
    ++state.boot;
    if (!usable) return;
    if (state.boot_usable == 0) state.zeroed = model.air_low <= reading && reading <= state.air_max;
    if (state.zeroed) state.zero += (reading - state.zero) / T(++state.boot_usable);
    if (!state.zeroed || state.boot_usable == boot_readings) state.boot = boot_ticks;
}

/// Move the zero where the depth is negative: in the air the sensor shows the air's pressure, so it is never above the
/// surface.
template <class T>
void bound_depth(const Estimator<T>& model, EstimatorState<T>& state) {
    if (state.depth < T(0)) shift_zero(model, state, model.depth_rate * model.attitude.tick * state.depth);
}

/// Whether a fix is believed at this depth. After several that are not, the zero of the depth is no longer believed.
template <class T>
bool believes_fixes(const Estimator<T>& model, EstimatorState<T>& state, bool usable) {
    state.dry = usable && state.zeroed && model.fix_depth <= state.depth ? state.dry + 1 : 0;
    if (state.dry == dry_fixes) state.zeroed = false, state.dry = 0;
    return state.dry == 0;
}

/// Move the zero by a fix, which proves that the antenna was out of the water at most a second ago. A depth that puts
/// the antenna under water moves the zero: at once where there is none, else slowly.
template <class T>
void follow_surface(const Estimator<T>& model, EstimatorState<T>& state, const Vector<T>& up) {
    const T highest = max(T(0), up.x * model.antenna_x + up.z * model.antenna_z);
    const T below = max(T(0), state.depth - max(T(0), state.sink) - highest);
    if (state.zeroed && below == T(0)) return;
    const bool moved = shift_zero(model, state, state.zeroed ? T(0.1) * below : below);
    state.zeroed = state.zeroed || moved;
}

/// Estimate depth and sink rate by a critically damped observer. Equal readings show a stuck sensor: at once on the way
/// up or down, and within seconds of any swim where the noise exceeds the resolution.
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

/// Attitude relative to true north from one relative to magnetic north: turned about the vertical by the declination,
/// clockwise.
template <class T>
Quaternion<T> true_attitude(const Quaternion<T>& q, T declination) {
    const SinCos<T> half = sincos(T(-0.5) * declination);
    return {half.cos * q.w - half.sin * q.z, half.cos * q.x - half.sin * q.y, half.cos * q.y + half.sin * q.x,
            half.cos * q.z + half.sin * q.w};
}

/// One tick of the estimator. `beat_speed` is the steady speed of the present beat [m/s], `imu` whether the controller
/// believes the IMU, `declination` that of the magnetic field [rad, east positive].
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
    for (int k = 0; k < 3; ++k) {  // false for NaN
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
    const Complex<T> swims = state.speed * Complex<T>{out.facing.x, out.facing.y};
    way.moved = way.moved + dt * swims;
    out.attitude = imu && state.attitude.known;
    go_astray(way, out.attitude ? T(0) : dt * in.speed, out.attitude);
    ++way.ticks;
    out.depths = watch_depth(model, state, readings.depth, in.speed * out.facing.z, in.speed);
    // Without a valid depth every fix is used: under water the receiver has none.
    if (readings.fixed && believes_fixes(model, state, out.depths)) {
        carry(model.way, way, dt);
        out.fix = take_fix(model.way, way, readings.fix, readings.accuracy);
    }
    out.fixes_refused = 1 < way.refused.count;
    if (out.fix && out.depths && out.attitude) follow_surface(model, state, pose.up);
    out.zeroed = state.zeroed;

    out.rate = state.attitude.rate;
    out.depth = state.depth, out.sink = state.sink;
    const Complex<T> here = position_after(way.filter, T(way.ticks) * dt, way.moved);
    out.x = here.re, out.y = here.im;
    out.factor = factor_of(way);
    out.speed = state.speed * out.factor;
    out.current[0] = way.filter.current.re, out.current[1] = way.filter.current.im;
    out.position_error = position_error(model.way, way);
    out.drift_error = drift_error(way.filter, swims);
    if (in.gyro && in.magnet) compare_gyroscope(frame, way, state.attitude.pulled);
    out.compass_off = compass_is_off(way);
    face_by_course(way, out.facing);
    out.compass = in.magnet;
    out.tilt = -pose.up.y;
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
