/// Safety: which readings can be believed, how far a pump may push, what may reach a servo, and the status that tells.
#pragma once

#include <cstdint>

#include "cpg.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int most_joints = 4;
inline constexpr int most_circuits = 2 * most_joints;
inline constexpr int most_servos = most_circuits + 2;

/// What the status can tell. Each condition has one bit in the flags, and one bit per joint, circuit or servo in `at`.
enum class Condition : std::uint8_t {
    bend_fault,
    pressure_fault,
    current_fault,
    imu_fault,
    battery_fault,
    open_loop,
    blind,
    pressure_limit,
    line_limit,
    suction_limit,
    speed_limit,
    slew_limit,
    pulse_limit,
    amplitude_limit,
    hard_stop,
    low_voltage,
    timeout,
    bad_command,
    disarmed,
    count
};
inline constexpr int conditions = int(Condition::count);

/// What a bit of `Status::at` stands for.
enum class Place : std::uint8_t { robot, joint, circuit, servo };

struct ConditionText {
    const char* name;
    Place place;
    const char* sentence;
};

/// The one table of all conditions: name, place, and what it means.
inline constexpr ConditionText condition_texts[conditions] = {
    {"bend_fault", Place::joint, "the bend sensor's reading is not plausible"},
    {"pressure_fault", Place::circuit, "the pressure sensor's reading is not plausible"},
    {"current_fault", Place::circuit, "the current sensor's reading is not plausible"},
    {"imu_fault", Place::robot, "the IMU's reading is not plausible"},
    {"battery_fault", Place::robot, "the battery voltage's reading is not plausible"},
    {"open_loop", Place::joint, "posture control holds its last good correction"},
    {"blind", Place::circuit, "without a pressure reading, the joint beats no wider than its model holds safe"},
    {"pressure_limit", Place::circuit, "the soft pressure limit held the pump back"},
    {"line_limit", Place::circuit, "the pressure drop of the oil line held the pump back"},
    {"suction_limit", Place::circuit, "the pump was held back so that its oil does not cavitate"},
    {"speed_limit", Place::circuit, "the servo was asked to turn faster than it can"},
    {"slew_limit", Place::servo, "the slew limit held the servo's command back"},
    {"pulse_limit", Place::servo, "the pulse clamp held the servo's command back"},
    {"amplitude_limit", Place::joint, "the joint was asked to bend further than its pumps reach"},
    {"hard_stop", Place::circuit, "pressure passed the hard limit: the joint is released until it is armed anew"},
    {"low_voltage", Place::robot, "the battery voltage is low"},
    {"timeout", Place::robot, "no command came in time: the tail comes to rest"},
    {"bad_command", Place::robot, "a value of the command cannot be used: the last good one holds"},
    {"disarmed", Place::robot, "the robot is not armed: the tail rests"},
};

struct Status {
    std::uint32_t flags;           // bit c: condition c holds somewhere
    std::uint16_t at[conditions];  // where: bit per joint, circuit or servo

    bool has(Condition c) const { return flags >> int(c) & 1; }
    bool has(Condition c, int place) const { return at[int(c)] >> place & 1; }
    void tell(Condition c, int place = 0) {
        flags |= std::uint32_t(1) << int(c);
        at[int(c)] = std::uint16_t(at[int(c)] | 1 << place);
    }
};

template <class T>
T clamp(T x, T low, T high) {
    return max(low, min(high, x));
}

/// Neither infinite nor NaN.
template <class T>
bool is_finite(T x) {
    return x - x == T(0);
}

/// What a reading of one kind of sensor must keep to be believed.
template <class T>
struct Plausible {
    T low, high;  // range of the sensor, SI
    T step;       // largest change within a tick
    int repeats;  // so many equal readings while the robot moves are no coincidence
};

/// The past of one sensor. `bucket` fills where readings are bad and drains where they are good.
template <class T>
struct Health {
    T last;  // last finite reading within range
    int repeats, bucket;
    bool faulty, seen;
};

inline constexpr int bucket_bad = 4;      // a bad reading weighs as much as four good ones
inline constexpr int bucket_faulty = 20;  // five bad readings in a row, or every fourth of them bad
inline constexpr int bucket_most = 100;   // a second of good readings at 100 Hz redeems the worst sensor
inline constexpr int repeats_fast = 6, repeats_slow = 25;  // equal readings: of what moves with each beat, of the rest

template <class T>
struct Verdict {
    bool usable;    // finite, within range and step, not stuck
    bool repeated;  // the very same number as before
};

/// Judge one reading. `expected` is what it may be one step away from: the last reading, or a prediction.
template <class T>
Verdict<T> judge(const Plausible<T>& limits, Health<T>& health, T reading, T expected, bool moving) {
    const bool inside = is_finite(reading) && limits.low <= reading && reading <= limits.high;
    const bool near = !health.seen || abs(reading - expected) <= limits.step;
    const bool repeated = inside && health.seen && reading == health.last;
    health.repeats = !repeated ? 0 : moving && health.repeats < limits.repeats ? health.repeats + 1 : health.repeats;
    const bool usable = inside && near && health.repeats < limits.repeats;
    const int bucket = health.bucket + (usable ? -1 : bucket_bad);
    health.bucket = bucket < 0 ? 0 : bucket < bucket_most ? bucket : bucket_most;
    health.faulty = health.bucket >= bucket_faulty || (health.faulty && health.bucket > 0);
    if (inside) health.last = reading, health.seen = true;
    return {usable && !health.faulty, repeated};
}

inline constexpr double one_atmosphere = 101325.0;  // Pa

/// Instants within a tick, evenly spaced and the last one its end, at which the supervisor predicts the pressure.
inline constexpr int instants = 4;

/// What the supervisor knows of one circuit: a critically damped servo, a line, oil with air in it. Volumes are servo
/// angles: what the pump pushes out per radian is 1.
template <class T>
struct SupervisorModel {
    Smoothing<T> servo;  // its position loop at one tick
    T speed;             // rad/s without load, at the rated voltage
    T stall;             // Pa at which it stalls, at the rated voltage
    T line;              // Pa s/rad: pressure drop of the line per flow
    T fill;              // Pa: pressure at rest
    T draw;              // rad per tick: drawing faster than this opens a cavity and moves no more oil
    T gas, gas_pump;     // rad: the air in the whole circuit and in its cylinder, at atmospheric pressure
    T soft;              // rad/Pa: what oil, hoses and fittings give
    // At each instant: the servo's move per rate [s] and per step of the target [1], and the pressure in the cylinder
    // over that in the units per servo rate, per flow beyond it [Pa s/rad] and per step [Pa/rad].
    T move_by_rate[instants], move_by_step[instants];
    T drop_by_rate[instants], drop_by_flow[instants], drop_by_step[instants];
};

/// What it believes.
template <class T>
struct SupervisorState {
    Follower<T> servo;  // rad, rad per tick: where the servo is
    T moved;            // rad: by how much it turned within the last tick
    T turned;           // rad per tick: by how much its rate changed
    T target;           // rad: its last command
    T reading;          // Pa: last one that was believed
    T flow;             // rad/s: flow out of the cylinder beyond the servo's
    T pressure;         // Pa: in the units
    T squeeze;          // rad: volume that bending took from the units within the last tick
    bool stopped;       // released by the hard limit
};

/// The servo over the next tick, no faster than its torque-speed line lets it: `most` is rad per tick.
template <class T>
Follower<T> turn_servo(const SupervisorModel<T>& model, const Follower<T>& now, T target, T most) {
    const Follower<T> free = follow(model.servo, now, target);
    return {now.value + clamp(free.value - now.value, -most, most), clamp(free.change, -most, most)};
}

/// Air of this volume at one atmosphere under a pressure (isothermal).
template <class T>
T air_at(T gas, T pressure) {
    return gas * T(one_atmosphere) / max(T(0.05 * one_atmosphere), T(one_atmosphere) + pressure);
}
/// Volume that a circuit gives to a pressure: its air is compressed, the rest yields linearly.
template <class T>
T yielded(const SupervisorModel<T>& model, T pressure) {
    return model.soft * pressure - air_at(model.gas, pressure);
}

/// Take in a pressure reading. The units stand at the reading less what the line drops, where the flow is the servo's
/// and that of the air in the cylinder, which soaks up the first of each push: now, or over the last tick, whichever
/// says more. What volume the units lost beyond what the pump pushed in, the bending joint took from them: a tail that
/// swings will go on doing so for a tick.
///
/// Where there is no reading the joint is taken as held fast, and pushed oil finds no room but its own compression.
template <class T>
void believe(const SupervisorModel<T>& model, SupervisorState<T>& now, bool fresh, T reading, T tick, T ease) {
    const T before = now.pressure, rate = now.servo.change / tick;
    const T stiffness = T(1) / (model.soft + air_at(model.gas, before) / (T(one_atmosphere) + before));
    if (fresh) {
        const T swelling = air_at(model.gas_pump, reading) - air_at(model.gas_pump, now.reading);
        const T at_end = reading - model.line * (rate + swelling / tick);
        const T in_mean = T(0.5) * (reading + now.reading) - model.line * (now.moved + swelling) / tick;
        now.pressure = max(at_end, in_mean);
        now.flow = (reading - now.pressure) / model.line - rate;
        const T taken = yielded(model, now.pressure) - yielded(model, before) - now.moved - swelling;
        const T squeeze = clamp(taken, -model.draw, model.draw);
        now.squeeze = T(0) < now.squeeze ? max(squeeze, T(0.5) * now.squeeze) : squeeze;
        now.pressure = max(now.pressure, before - ease);
        now.reading = reading;
    } else {
        now.flow = T(0);
        now.squeeze = max(now.squeeze, T(0));
        now.pressure = before + stiffness * (now.moved + now.squeeze);
    }
    now.pressure = clamp(now.pressure, T(-0.9 * one_atmosphere), T(10 * one_atmosphere));
}

/// What the cylinder should show now, where no more happened than the own pump did.
template <class T>
T expected_pressure(const SupervisorModel<T>& model, const SupervisorState<T>& now, T tick) {
    return now.reading + model.line * now.turned / tick;
}

/// The furthest target that keeps the cylinder below `limit` until the next tick.
///
/// The units' pressure goes along the secant from now to the limit: air is stiffer the more it is compressed, so this
/// is never too low. Everything is linear in the step of the target then, at every instant.
template <class T>
T furthest(const SupervisorModel<T>& model, const SupervisorState<T>& now, T limit, T tick) {
    const T room = limit - now.pressure, rate = now.servo.change / tick;
    const T span = max(room, T(0.1) * limit);
    const T stiffness = span / (yielded(model, now.pressure + span) - yielded(model, now.pressure));
    T step = T(0);
    for (int k = 0; k < instants; ++k) {
        const T squeezed = now.squeeze * (T(k + 1) / T(instants));
        const T left = room - stiffness * (model.move_by_rate[k] * rate + squeezed) - model.drop_by_rate[k] * rate -
                       model.drop_by_flow[k] * now.flow;
        const T most = left / (stiffness * model.move_by_step[k] + model.drop_by_step[k]);
        step = k == 0 ? most : min(step, most);
    }
    return now.servo.value + (now.reading < limit ? max(step, T(0)) : step);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
