/// Attitude: a complementary filter of rates, gravity and magnetic field, on the unit quaternion from body to world.
///
/// The gyroscope carries the frame; in that frame gravity and field pull the attitude home slowly, gravity about level
/// axes and the field about the vertical alone, so that a disturbed field never tilts it (Mahony, Hamel and Pflimlin,
/// IEEE TAC 53(5), 2008). A slow pull averages: the beat's accelerations are many times faster and cancel.
#pragma once

#include "hypertuna/math/spatial.hpp"
#include "hypertuna/pilot/readings.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
T norm(const Vector<T>& v) {
    return sqrt(dot(v, v));
}

template <class T>
struct AttitudeModel {
    T tick;                        // s
    T tilt_rate, heading_rate;     // 1/s: how fast gravity and field correct the attitude
    T drift_max;                   // rad/s: largest plausible offset of the gyroscope
    T rate_max, acceleration_max;  // rad/s, m/s^2: ranges of the sensors
    T field_low, field_high;       // range of strengths of an undisturbed field
};

template <class T, class Visit>
void visit_fields(AttitudeModel<T>& m, const Visit& visit) {
    visit("tick", 0, m.tick), visit("gravity_rate", 0, m.tilt_rate), visit("field_rate", 0, m.heading_rate);
    visit("drift_max", 0, m.drift_max), visit("rate_max", 0, m.rate_max);
    visit("acceleration_max", 0, m.acceleration_max);
    visit("field_low", 0, m.field_low), visit("field_high", 0, m.field_high);
}

template <class T>
struct AttitudeState {
    Quaternion<T> q;  // unit, body to world
    Vector<T> rate;   // rad/s in body axes, without the offset
    Vector<T> drift;  // rad/s: offset of the gyroscope
    int age;          // ticks over which gravity has been averaged
    bool known;       // gravity and field were seen together once
    T pulled;         // rad/s at which the field turns the attitude against the gyroscope, a mean over a second
};

/// Attitude from the directions of up and of the magnetic field in body axes; false where the two are parallel.
template <class T>
bool attitude_from(const Vector<T>& up, const Vector<T>& field, Quaternion<T>& q) {
    const T size = norm(up);
    const Vector<T> across = cross(field, up);  // east
    const T flat = norm(across);
    if (!(flat > T(0.05) * size * norm(field))) return false;
    const Vector<T> z = (T(1) / size) * up, x = (T(1) / flat) * across, y = cross(z, x);
    // Rows of the rotation are x, y, z: Shepperd's method divides by the quaternion's largest component.
    const T trace[4] = {x.x + y.y + z.z, x.x - y.y - z.z, y.y - x.x - z.z, z.z - x.x - y.y};
    int largest = 0;
    for (int k = 1; k < 4; ++k)
        if (trace[largest] < trace[k]) largest = k;
    const T large = T(1) + trace[largest];
    const T wx = z.y - y.z, wy = x.z - z.x, wz = y.x - x.y, xy = y.x + x.y, xz = z.x + x.z, yz = z.y + y.z;
    const Quaternion<T> row[4] = {{large, wx, wy, wz}, {wx, large, xy, xz}, {wy, xy, large, yz}, {wz, xz, yz, large}};
    q = normalized(row[largest]);
    return true;
}

/// Readings of one tick, and which of them can be used.
template <class T>
struct AttitudeInput {
    Vector<T> rate, acceleration, field;
    bool gyro, gravity, magnet;
    T speed;  // m/s through the water, for the acceleration of turning
};

/// Corrections of the attitude by gravity and field, as rotations about body axes [rad].
template <class T>
struct Pull {
    Vector<T> tilt, heading;
    T turn;  // sine of the angle to north
};
template <class T>
Pull<T> pull_of(const AttitudeState<T>& state, const AttitudeInput<T>& in) {
    Pull<T> pull{};
    const Rotation<T> frame = rotation(state.q);
    if (in.gravity) {
        // Without the acceleration of a steady turn, rate x velocity: the robot swims along -x.
        const Vector<T> up = in.acceleration - cross(state.rate, {-in.speed, T(0), T(0)});
        const T size = norm(up);
        if (size > T(1)) pull.tilt = (T(1) / size) * cross(up, frame.up);
    }
    if (in.magnet) {
        const T east = dot(frame.east, in.field), north = dot(frame.north, in.field);
        const T flat = sqrt(east * east + north * north);
        if (flat > T(0.05)) {
            // Sine of the angle to north; 1 or -1 beyond a right angle.
            pull.turn = T(0) < north ? east / flat : east < T(0) ? T(-1) : T(1);
            pull.heading = pull.turn * frame.up;
        }
    }
    return pull;
}

inline constexpr int gap_age = 50;  // largest `age` after a gap in the gyroscope's readings

/// One tick of the filter. Over its first time constant gravity is weighted as in a running mean, for a quick start.
template <class T>
AttitudeState<T> attitude_step(const AttitudeModel<T>& model, const AttitudeState<T>& before,
                               const AttitudeInput<T>& in) {
    AttitudeState<T> state = before;
    if (!state.known) {
        state.known = in.gravity && in.magnet && attitude_from(in.acceleration, in.field, state.q);
        state.age = 0;
    }
    if (in.gyro) {
        state.rate = in.rate - state.drift;
    } else {  // the head swings to and fro: zero is the best guess of its rate, and a low age corrects the gap's error
              // quickly
        state.rate = {T(0), T(0), T(0)};
        state.age = state.age < gap_age ? state.age : gap_age;
    }
    const Pull<T> pull = pull_of(state, in);
    const T young = T(1) / (T(state.age + 1) * model.tick);
    if (in.gravity && min(model.tilt_rate, model.heading_rate) < young) ++state.age;
    // A young attitude may be far off, so that its correction by the field says nothing about the compass.
    const T pulled = model.heading_rate < young ? T(0) : model.heading_rate * pull.turn;
    state.pulled += model.tick * (pulled - state.pulled);
    const Vector<T> push = max(model.tilt_rate, young) * pull.tilt + max(model.heading_rate, young) * pull.heading;
    if (in.gyro) {
        // A quarter of the rate's square: critically damped.
        const Vector<T> learned =
            T(0.25) * model.tick *
            (model.tilt_rate * model.tilt_rate * pull.tilt + model.heading_rate * model.heading_rate * pull.heading);
        const auto kept = [&](T x) { return clamp(x, -model.drift_max, model.drift_max); };
        const Vector<T> drift = state.drift - learned;
        state.drift = {kept(drift.x), kept(drift.y), kept(drift.z)};
    }
    state.q = normalized(state.q + model.tick * attitude_rate(state.q, state.rate + push));
    return state;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
