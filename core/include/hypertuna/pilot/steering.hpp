/// Steering: a course over ground becomes a tail bias, a depth becomes fin angles, a speed becomes a beat.
///
/// No angle is wrapped because none is computed: directions are unit vectors, errors their products. What steers the
/// tail is a mean over a beat, in which the head's swing cancels.
#pragma once

#include "hypertuna/pilot/estimator.hpp"
#include "hypertuna/pilot/mission.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int max_gaits = 12;

/// Gaits in order of speed. Between two of them all numbers are interpolated linearly; below the first the frequency
/// falls.
template <class T>
struct GaitTable {
    int gaits;
    T speed[max_gaits], frequency[max_gaits];                          // m/s, Hz
    T amplitude[max_gaits][max_joints], phase[max_gaits][max_joints];  // rad
};

template <class T>
struct Beating {
    T speed, frequency, amplitude[max_joints], phase[max_joints];
};

template <class T>
Beating<T> beating(const GaitTable<T>& table, int joints, T speed) {
    Beating<T> out{};
    out.speed = clamp(speed, T(0), table.speed[table.gaits - 1]);
    int k = 0;
    while (k < table.gaits - 1 && table.speed[k] < out.speed) ++k;
    const int before = k > 0 ? k - 1 : 0;
    const T below = k > 0 ? table.speed[before] : T(0);
    const T part = clamp((out.speed - below) / (table.speed[k] - below), T(0), T(1));
    const auto between = [&](T a, T b) { return a + part * (b - a); };
    out.frequency = between(k > 0 ? table.frequency[before] : T(0), table.frequency[k]);
    for (int j = 0; j < joints; ++j) {
        out.amplitude[j] = between(table.amplitude[before][j], table.amplitude[k][j]);
        out.phase[j] = between(table.phase[before][j], table.phase[k][j]);
    }
    return out;
}

template <class T>
struct Steering {
    int joints;
    T period;  // s between two decisions
    GaitTable<T> table;
    T bias_max[max_joints],
        reach[max_joints];          // rad, largest bends of each joint: for steering; with the beat included
    T curvature;                    // 1/m of the path at full tail bias
    T heading_rate, turn_max;       // 1/s of the heading loop; rad/s, largest rate of turn that it asks for
    T rate_gain, heading_integral;  // 1, 1/s
    T speed_min;                    // m/s below which nothing can be steered
    T lookahead, depth_lookahead;   // m
    T climb_max, pitch_max;         // sines: largest slope of the path; pitch at which no slope is asked for
    T depth_integral;               // 1/s
    T climb_lead, climb_gain;       // rad of fin per sine: of the slope asked for; of the slope that is missing
    T pitch_gain, pitch_damping;    // rad of fin per sine of pitch, s
    T fin_max;                      // rad
};

template <class T, class Visit>
void visit_fields(Steering<T>& m, const Visit& visit) {
    visit("period", 0, m.period);
    for (int k = 0; k < m.table.gaits; ++k) {
        visit("speed", k, m.table.speed[k]), visit("frequency", k, m.table.frequency[k]);
        for (int j = 0; j < m.joints; ++j) {
            visit("swing", m.joints * k + j, m.table.amplitude[k][j]);
            visit("lag", m.joints * k + j, m.table.phase[k][j]);
        }
    }
    for (int j = 0; j < m.joints; ++j) visit("bias_max", j, m.bias_max[j]), visit("bend_max", j, m.reach[j]);
    visit("curvature", 0, m.curvature), visit("heading_rate", 0, m.heading_rate), visit("turn_max", 0, m.turn_max);
    visit("rate_gain", 0, m.rate_gain), visit("heading_integral", 0, m.heading_integral);
    visit("speed_min", 0, m.speed_min), visit("lookahead", 0, m.lookahead);
    visit("depth_lookahead", 0, m.depth_lookahead), visit("pitch_max", 0, m.pitch_max);
    visit("climb_max", 0, m.climb_max), visit("climb_lead", 0, m.climb_lead), visit("climb_gain", 0, m.climb_gain);
    visit("depth_integral", 0, m.depth_integral), visit("pitch_gain", 0, m.pitch_gain);
    visit("pitch_damping", 0, m.pitch_damping), visit("fin_angle_max", 0, m.fin_max);
}

/// Direction that the head faces, rate of turn [rad/s], sine of the roll.
template <class T>
struct Heading {
    T x, y, turn, tilt;
};

/// Means of direction, rate of turn and roll over the last whole beat.
template <class T>
struct BeatMean {
    Heading<T> sum, mean;
    int ticks;
};

/// Add one tick to the sums; at the end of a beat, or after `limit` ticks without one, compute the mean anew.
template <class T>
void update(BeatMean<T>& beat, const Estimate<T>& at, bool ended, int limit) {
    Heading<T>& sum = beat.sum;
    sum.x += at.facing.x, sum.y += at.facing.y, sum.turn += at.rate.z, sum.tilt += at.tilt;
    const T ticks = T(++beat.ticks);
    if (!ended && beat.ticks < limit) return;
    beat.mean = {sum.x / ticks, sum.y / ticks, sum.turn / ticks, sum.tilt / ticks};
    sum = {}, beat.ticks = 0;
}

template <class T>
struct SteeringState {
    BeatMean<T> beat;
    T turn_sum;   // rad/s: rate of turn that the integral asks for
    T climb_sum;  // sine of the path that the integral asks for
};

/// A direction over ground, of length 1.
template <class T>
struct Course {
    T x, y;
};

/// Direction of a vector; `otherwise` where the vector is zero.
template <class T>
Course<T> toward(T dx, T dy, const Course<T>& otherwise) {
    const T away = sqrt(dx * dx + dy * dy);
    return away > T(1e-3) ? Course<T>{dx / away, dy / away} : otherwise;
}

/// Direction to face so that the path over ground follows a course despite the current.
template <class T>
Course<T> crab(const Course<T>& course, const T (&current)[2], T speed) {
    const T across = course.x * current[1] - course.y * current[0];  // m/s, current to the left of the course
    const T sine = clamp(-across / speed, T(-0.9), T(0.9)), cosine = sqrt(T(1) - sine * sine);
    return {course.x * cosine - course.y * sine, course.y * cosine + course.x * sine};
}

/// Speed made good along a course by swimming at `speed` with the crab angle.
template <class T>
T made_good(const Course<T>& course, const T (&current)[2], T speed) {
    const T across = course.x * current[1] - course.y * current[0];
    const T along = course.x * current[0] + course.y * current[1];
    return along + sqrt(max(T(0), speed * speed - across * across));
}

/// Line of sight: the course to a point ahead on the leg, and how far along it the robot is.
template <class T>
struct Leg {
    Course<T> course;
    T along, length, across;  // m
};
template <class T>
Leg<T> line_of_sight(const Corner<T>& from, const Corner<T>& to, T x, T y, T lookahead, const Course<T>& otherwise) {
    const T ex = to.x - from.x, ey = to.y - from.y, length = sqrt(ex * ex + ey * ey);
    const Course<T> leg = toward(ex, ey, toward(to.x - x, to.y - y, otherwise));
    const T px = x - from.x, py = y - from.y;
    const T along = leg.x * px + leg.y * py, across = leg.x * py - leg.y * px;
    const T ahead = clamp(along + lookahead, T(0), length);
    return {toward(from.x + leg.x * ahead - x, from.y + leg.y * ahead - y, otherwise), along, length, across};
}

/// Part of the whole tail bias, -1 to 1, that turns the head to a direction.
///
/// Turning: r' ~ -curvature U bias. The loop asks for a rate of turn w e + integral, and adds a gain times the missing
/// rate.
template <class T>
T bias_for(const Steering<T>& model, SteeringState<T>& state, const Course<T>& wanted, T speed) {
    const Heading<T>& mean = state.beat.mean;
    const T flat = sqrt(mean.x * mean.x + mean.y * mean.y);
    if (!(flat > T(0.05))) return T(0);
    const T sine = (mean.x * wanted.y - mean.y * wanted.x) / flat;
    const T cosine = (mean.x * wanted.x + mean.y * wanted.y) / flat;
    // Twice the tangent of half the angle: the angle as long as it is small, and it never wraps.
    const T error = cosine > T(0) ? T(2) * sine / (T(1) + cosine) : sine < T(0) ? T(-2) : T(2);
    const T rate = clamp(model.heading_rate * error, -model.turn_max, model.turn_max);
    const T full = model.curvature * max(speed, model.speed_min);
    const T asked = (rate + state.turn_sum + model.rate_gain * (rate - mean.turn)) / full;
    const T given = clamp(asked, T(-1), T(1));
    // The sum changes only where the bias is not at its limit, and near the course.
    if (asked == given && abs(error) < T(0.5))
        state.turn_sum = clamp(state.turn_sum + model.period * model.heading_integral * model.heading_rate * error,
                               -model.turn_max, model.turn_max);
    return -given;
}

/// Sine of the path's slope that leads to a depth, upward: line of sight to a point ahead at that depth, with an
/// integral against a wrong trim. The more the robot pitches, the less slope is asked for.
template <class T>
T climb_for(const Steering<T>& model, SteeringState<T>& state, const Estimate<T>& at, T depth) {
    const T error = at.depth - depth;
    const T sight = error / sqrt(error * error + model.depth_lookahead * model.depth_lookahead);
    const T limit = model.climb_max * clamp(T(2) - T(2) * abs(at.facing.z) / model.pitch_max, T(0), T(1));
    const T asked = sight + state.climb_sum, given = clamp(asked, -limit, limit);
    if (asked == given && model.speed_min < at.speed)
        state.climb_sum =
            clamp(state.climb_sum + model.period * model.depth_integral * sight, -model.climb_max, model.climb_max);
    return given;
}

/// Angle of both fins for the sine of a path's slope, leading edge up. Fins lift the body more than they turn it, so
/// they follow the path, and damp the pitch.
template <class T>
T fins_for(const Steering<T>& model, const Estimate<T>& at, T climb) {
    const T path = clamp(-at.sink / max(at.speed, model.speed_min), T(-1), T(1));
    const T asked = model.climb_lead * climb + model.climb_gain * (climb - path) - model.pitch_gain * at.facing.z -
                    model.pitch_damping * at.rate.y;
    return clamp(asked, -model.fin_max, model.fin_max);
}

/// Turn a command's beat by a part of the tail bias; a joint with a bias swings less.
template <class T>
void turn_beat(const Steering<T>& model, Command<T>& command, T bias) {
    for (int j = 0; j < model.joints; ++j) {
        command.bias[j] = bias * model.bias_max[j];
        command.amplitude[j] = max(T(0), min(command.amplitude[j], model.reach[j] - abs(command.bias[j])));
    }
}

/// Set a command to the beat of a speed, turned by a part of the tail bias.
template <class T>
void beat_into(const Steering<T>& model, Command<T>& command, T speed, T bias) {
    const Beating<T> beat = beating(model.table, model.joints, speed);
    command.frequency = beat.frequency;
    for (int j = 0; j < model.joints; ++j) command.amplitude[j] = beat.amplitude[j], command.phase[j] = beat.phase[j];
    turn_beat(model, command, bias);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
