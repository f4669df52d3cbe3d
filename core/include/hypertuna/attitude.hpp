/// Attitude: a complementary filter of rates, gravity and magnetic field, on the unit quaternion from body to world.
///
/// The gyroscope carries the frame; in that frame gravity and field pull the attitude home slowly, gravity about level
/// axes and the field about the vertical alone, so that a disturbed field never tilts it (Mahony, Hamel and Pflimlin,
/// IEEE TAC 53(5), 2008). What pulls slowly averages: the beat's accelerations are many times faster and cancel.
#pragma once

#include "readings.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A vector of the body in world axes. q is (w, x, y, z).
template <class T>
void to_world(const T (&q)[4], const T (&v)[3], T (&out)[3]) {
    const T t[3] = {q[2] * v[2] - q[3] * v[1], q[3] * v[0] - q[1] * v[2], q[1] * v[1] - q[2] * v[0]};
    out[0] = v[0] + T(2) * (q[0] * t[0] + q[2] * t[2] - q[3] * t[1]);
    out[1] = v[1] + T(2) * (q[0] * t[1] + q[3] * t[0] - q[1] * t[2]);
    out[2] = v[2] + T(2) * (q[0] * t[2] + q[1] * t[1] - q[2] * t[0]);
}

/// A vector of the world in body axes.
template <class T>
void to_body(const T (&q)[4], const T (&v)[3], T (&out)[3]) {
    const T back[4] = {q[0], -q[1], -q[2], -q[3]};
    to_world(back, v, out);
}

template <class T>
T norm(const T (&v)[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// q <- q (1, r / 2), made a unit again: the turn by a small angle r about body axes.
template <class T>
void turn_by(T (&q)[4], const T (&r)[3]) {
    const T x = T(0.5) * r[0], y = T(0.5) * r[1], z = T(0.5) * r[2];
    const T w[4] = {q[0] - x * q[1] - y * q[2] - z * q[3], q[1] + x * q[0] + z * q[2] - y * q[3],
                    q[2] + y * q[0] + x * q[3] - z * q[1], q[3] + z * q[0] + y * q[1] - x * q[2]};
    const T scale = T(1) / sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
    for (int k = 0; k < 4; ++k) q[k] = w[k] * scale;
}

template <class T>
struct AttitudeModel {
    T tick;                          // s
    T tilt_rate, heading_rate;       // 1/s: how fast gravity and field pull
    T drift_most;                    // rad/s: largest offset of the gyroscope that is believed
    T rate_most, acceleration_most;  // rad/s, m/s^2: ranges of the sensors
    T field_low, field_high;         // strength that a sound field has
};

template <class T>
struct AttitudeState {
    T q[4];      // unit quaternion, body to world
    T rate[3];   // rad/s in body axes, without the offset
    T drift[3];  // rad/s: offset of the gyroscope
    int age;     // ticks that gravity was averaged for
    bool known;  // gravity and field were seen together once
};

template <class T>
AttitudeState<T> level() {
    AttitudeState<T> state{};
    state.q[0] = T(1);
    return state;
}

/// Attitude whose vertical and north are where two readings see them, or none where those are parallel.
template <class T>
bool attitude_from(const T (&up)[3], const T (&field)[3], T (&q)[4]) {
    const T size = norm(up);
    if (!(size > T(0))) return false;
    const T z[3] = {up[0] / size, up[1] / size, up[2] / size};
    // East is field x up.
    const T e[3] = {field[1] * z[2] - field[2] * z[1], field[2] * z[0] - field[0] * z[2],
                    field[0] * z[1] - field[1] * z[0]};
    const T east = norm(e);
    if (!(east > T(0.05) * norm(field))) return false;
    const T x[3] = {e[0] / east, e[1] / east, e[2] / east};
    const T y[3] = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    // Rows of the rotation body -> world are x, y, z. Shepperd's method: divide by the largest component.
    const T trace[4] = {x[0] + y[1] + z[2], x[0] - y[1] - z[2], y[1] - x[0] - z[2], z[2] - x[0] - y[1]};
    int most = 0;
    for (int k = 1; k < 4; ++k)
        if (trace[most] < trace[k]) most = k;
    const T r = sqrt(T(1) + trace[most]), s = T(0.5) / r;
    const T wx = z[1] - y[2], wy = x[2] - z[0], wz = y[0] - x[1];
    const T xy = y[0] + x[1], xz = z[0] + x[2], yz = z[1] + y[2];
    const T rows[4][4] = {{T(0), wx, wy, wz}, {wx, T(0), xy, xz}, {wy, xy, T(0), yz}, {wz, xz, yz, T(0)}};
    for (int k = 0; k < 4; ++k) q[k] = k == most ? T(0.5) * r : rows[most][k] * s;
    return true;
}

/// What of the readings can be used in this tick.
template <class T>
struct AttitudeInput {
    T rate[3], acceleration[3], field[3];
    bool gyro, gravity, magnet;
    T speed;  // m/s through the water, for the acceleration of turning
};

/// How gravity and field want the attitude to turn, about body axes [rad].
template <class T>
struct Pull {
    T tilt[3], heading[3];
};
template <class T>
Pull<T> pull_of(const AttitudeState<T>& state, const AttitudeInput<T>& in) {
    Pull<T> pull{};
    const T vertical[3] = {T(0), T(0), T(1)};
    T up[3];
    to_body(state.q, vertical, up);
    if (in.gravity) {
        // What a steady turn adds, rate x velocity: the robot swims along -x.
        const T a[3] = {in.acceleration[0], in.acceleration[1] + state.rate[2] * in.speed,
                        in.acceleration[2] - state.rate[1] * in.speed};
        const T size = norm(a);
        if (size > T(1)) {
            pull.tilt[0] = (a[1] * up[2] - a[2] * up[1]) / size;
            pull.tilt[1] = (a[2] * up[0] - a[0] * up[2]) / size;
            pull.tilt[2] = (a[0] * up[1] - a[1] * up[0]) / size;
        }
    }
    if (in.magnet) {
        T seen[3];
        to_world(state.q, in.field, seen);
        const T flat = sqrt(seen[0] * seen[0] + seen[1] * seen[1]);
        if (flat > T(0.05)) {
            // Sine of the angle to north; beyond a right angle all of it.
            const T sine = seen[0] / flat, error = T(0) < seen[1] ? sine : sine < T(0) ? T(-1) : T(1);
            for (int k = 0; k < 3; ++k) pull.heading[k] = error * up[k];
        }
    }
    return pull;
}

/// One tick. Until it has averaged for its own time constant gravity counts as in a mean: the start is quick.
template <class T>
AttitudeState<T> attitude_step(const AttitudeModel<T>& model, const AttitudeState<T>& before,
                               const AttitudeInput<T>& in) {
    AttitudeState<T> state = before;
    if (!state.known) {
        state.known = in.gravity && in.magnet && attitude_from(in.acceleration, in.field, state.q);
        state.age = 1;
    }
    if (in.gyro)
        for (int k = 0; k < 3; ++k) state.rate[k] = in.rate[k] - state.drift[k];
    const Pull<T> pull = pull_of(state, in);
    if (in.gravity && T(state.age) * model.tick * min(model.tilt_rate, model.heading_rate) < T(1)) ++state.age;
    const T young = T(1) / (T(state.age) * model.tick);
    const T tilt = max(model.tilt_rate, young), heading = max(model.heading_rate, young);
    T turn[3];
    for (int k = 0; k < 3; ++k) {
        const T push = tilt * pull.tilt[k] + heading * pull.heading[k];
        turn[k] = (state.rate[k] + push) * model.tick;
        // A quarter of the rate's square: critically damped.
        const T learned = T(0.25) * (model.tilt_rate * model.tilt_rate * pull.tilt[k] +
                                     model.heading_rate * model.heading_rate * pull.heading[k]);
        if (in.gyro) state.drift[k] = clamp(state.drift[k] - learned * model.tick, -model.drift_most, model.drift_most);
    }
    turn_by(state.q, turn);
    return state;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
