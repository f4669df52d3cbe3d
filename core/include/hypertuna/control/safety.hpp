/// Safety: validity of readings, limits of the amplitude of a joint and of the pressure of a pump, and the status.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "hypertuna/control/cpg.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

// Largest number of joint groups, from which the other limits follow. A board's memory and messages have room for
// fewer.
inline constexpr int board_joints = 4;
#ifdef HYPERTUNA_BOARD
inline constexpr int max_joints = board_joints;
#else
inline constexpr int max_joints = 12;
#endif
inline constexpr int max_coordinates = max_joints + 1;  // coordinates of a tail: joint groups and hinges
inline constexpr int max_circuits = 2 * max_joints;
inline constexpr int max_servos = max_circuits + 2;
/// Number of a robot's servos: two per joint and one per pectoral fin.
constexpr int servos_of(int joints) { return 2 * joints + 2; }

/// A bit per joint, circuit or servo.
using Places =
    std::conditional_t<max_servos <= std::numeric_limits<std::uint16_t>::digits, std::uint16_t, std::uint32_t>;

/// Conditions that the status reports. Each condition has one bit in the flags, and one bit per joint, circuit or servo
/// in `at`.
enum class Condition : std::uint8_t {
    bend_fault,
    pressure_fault,
    current_fault,
    imu_fault,
    battery_fault,
    open_loop,
    blind,
    pressure_limit,
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

/// Table of all conditions: name, place and meaning.
inline constexpr ConditionText condition_texts[conditions] = {
    {"bend_fault", Place::joint, "the bend sensor's reading is not plausible"},
    {"pressure_fault", Place::circuit, "the pressure sensor's reading is not plausible"},
    {"current_fault", Place::circuit, "the current sensor's reading is not plausible"},
    {"imu_fault", Place::robot, "the IMU's reading is not plausible"},
    {"battery_fault", Place::robot, "the reading of the battery voltage is not plausible"},
    {"open_loop", Place::joint, "posture control holds its last good correction"},
    {"blind", Place::circuit,
     "without a pressure reading, the joint beats no wider than it did or than its model holds safe"},
    {"pressure_limit", Place::circuit,
     "the soft pressure limit reduces the amplitude of the joint or the stroke of the pump"},
    {"speed_limit", Place::circuit, "the servo was asked to turn faster than it can"},
    {"slew_limit", Place::servo, "the slew limit held the servo's command back"},
    {"pulse_limit", Place::servo, "the pulse clamp held the servo's command back"},
    {"amplitude_limit", Place::joint, "the joint was asked to bend further than it reaches"},
    {"hard_stop", Place::circuit, "pressure passed the hard limit: the joint is released until it is armed again"},
    {"low_voltage", Place::robot, "the battery voltage is low"},
    {"timeout", Place::robot, "no command came in time: the tail comes to rest"},
    {"bad_command", Place::robot,
     "a value of the command is beyond its bounds and was clamped, or is no number and the last good one holds"},
    {"disarmed", Place::robot, "the robot is not armed: the tail rests"},
};

struct Status {
    std::uint32_t flags;    // bit c: condition c holds somewhere
    Places at[conditions];  // where

    bool has(Condition c) const { return flags >> int(c) & 1; }
    bool has(Condition c, int place) const { return at[int(c)] >> place & 1; }
    void set(Condition c, int place = 0) {
        flags |= std::uint32_t(1) << int(c);
        at[int(c)] = Places(at[int(c)] | 1 << place);
    }
};

/// Limit a value to bounds; one that is not a number becomes the upper bound.
template <class T>
T clamp(T x, T low, T high) {
    return x < low ? low : x <= high ? x : high;
}

/// Neither infinite nor NaN.
template <class T>
bool is_finite(T x) {
    return x - x == T(0);
}

/// Limits within which a reading of one kind of sensor is valid.
template <class T>
struct Plausible {
    T low, high;  // range of the sensor, SI
    T step;       // largest change within a tick
    T repeats;    // number of equal readings in a row that make a fault in full motion; with less motion it takes more
};

/// Record of one sensor. `bucket` fills where readings are bad and drains where they are good.
template <class T>
struct Health {
    T last;     // last finite reading within range
    T repeats;  // repetitions of `last`, each weighted by the robot's motion
    int bucket;
    bool faulty, seen;
};

inline constexpr int bucket_bad = 4;      // a bad reading weighs as much as four good ones
inline constexpr int bucket_faulty = 20;  // reached by five bad readings in a row, or where every fourth is bad
inline constexpr int bucket_max = 100;    // a second of good readings at 100 Hz ends the longest fault
inline constexpr float
    repeats_fast = 6,
    repeats_slow = 25;  // equal readings that make a fault: where a reading changes with each beat, and elsewhere

template <class T>
struct ReadingQuality {
    bool usable;    // finite, within range and step, not stuck
    bool repeated;  // the very same number as before
};

/// Judge one reading, which may be one step away from `expected`: the last reading, or a prediction. `motion` of the
/// robot is from 0, at rest, to 1; `agrees` says that nothing else contradicts the reading.
template <class T>
ReadingQuality<T> judge(const Plausible<T>& limits, Health<T>& health, T reading, T expected,
                        std::type_identity_t<T> motion, bool agrees = true) {
    const bool inside = limits.low <= reading && reading <= limits.high;  // false for NaN
    bool near = false, repeated = false;
    if (inside) {
        near = abs(reading - expected) <= limits.step || !health.seen;
        repeated = reading == health.last && health.seen;
        health.last = reading, health.seen = true;
    }
    health.repeats = repeated ? min(health.repeats + motion, limits.repeats) : T(0);
    const bool usable = near && agrees && health.repeats < limits.repeats;
    if (usable && health.bucket == 0) return {true, repeated};  // the usual case: not faulty, and the bucket is empty
    const int bucket = health.bucket + (usable ? -1 : bucket_bad);
    health.bucket = bucket < bucket_max ? bucket : bucket_max;
    health.faulty = health.bucket >= bucket_faulty || (health.faulty && health.bucket > 0);
    return {usable && !health.faulty, repeated};
}

/// Whether a sensor shows the same number for the third time in full motion: it may be stuck, although that is not a
/// fault yet.
template <class T>
bool repeats(const Health<T>& health) {
    return T(1.9) < health.repeats;
}

inline constexpr int hold_terms = 4;

/// What the supervisor knows of one circuit.
template <class T>
struct SupervisorModel {
    T speed;       // rad/s of the servo without load, at the rated voltage
    T stall;       // Pa at which the servo stalls
    T fill;        // Pa: pressure at rest
    T compliance;  // rad/Pa: servo angle per pressure near the soft limit, with the joint held
    T line;        // Pa s/rad: drop along the line per rate of the servo, with the thickest oil that flows
    T hammer;      // Pa s/rad: hammer of the line's oil per rate of the servo
    T draw;        // rad/s: largest rate of the servo drawing oil at which the hammer leaves no cavity
    T smooth;      // rad/s: largest change of the servo's rate within a tick that does not make the line ring
    T spare;  // rad/s/Pa: how much slower the servo draws per pressure of the trough below the fill; 0 where readings
              // show none
    T hold[hold_terms];  // Pa/rad to Pa/rad^4: coefficients of the pressure above the fill that holds a bend to this
                         // side at rest

    /// Whether the line is so long that a jerk of the pump makes it ring.
    bool rings() const { return smooth < T(1e6); }
};

/// Pressure that holds a bend at rest, Pa.
template <class T>
HYPERTUNA_INLINE T held(const SupervisorModel<T>& model, T bend) {
    const T* term = model.hold;
    return model.fill + (((term[3] * bend + term[2]) * bend + term[1]) * bend + term[0]) * bend;
}

/// A pressure sensor is astray where its mean over `astray_time` differs from the model's pressure by more than this
/// part of the way from fill to soft limit, plus this part of the pressure that holds the bend. The mean has little of
/// the water's loads.
inline constexpr double astray_time = 0.6;  // s
inline constexpr double astray_room = 0.2, astray_held = 0.25;

/// Part of the way to a lower reading that the crest falls within a tick, in a line that rings, and part of the way to
/// a higher one that the trough rises. The pump pushes as far as the crest falls: a crest that falls faster than the
/// oil's swing dies out keeps the swing up, in the rhythm of the readings.
inline constexpr double crest_fall = 0.015, trough_rise = 0.15;

/// Numbers of readings in a row above the hard limit that release a joint: of a trusted sensor, and of any sensor.
inline constexpr int hard_trusted = 2, hard_any = 5;

template <class T>
struct SupervisorState {
    T pressure;         // Pa: last valid reading, the fill pressure before the first
    T before;           // Pa: the reading before `pressure`
    T crest, trough;    // Pa: crest and trough of the readings, where the line rings
    T change;           // rad: change of the servo's angle in the last tick's command
    Follower<T> servo;  // rad: where the servo is, as long as no load slows it down
    T turned[2];        // rad: the servo's changes in the two ticks before
    T astray;           // Pa: mean of the reading minus the pressure that follows from bend and stroke
    bool wrong, bent;   // `astray` is too large: the pressure sensor is to blame, or the bend sensor
    int hard;           // readings in a row above the hard limit, trusted or not
    bool stopped;       // released by the hard limit
};

/// Within a tick: the furthest angle that a pump may be sent to. Above the soft limit the pump goes back by as much as
/// relieves the excess. The excess counts only up to the hard limit, since a sensor may be wrong. The pump moves no
/// faster than the pressure surge of its own return allows; otherwise the surge would come back in a long line.
template <class T>
T furthest_pump_angle(const SupervisorModel<T>& model, T sent, T pressure, T soft, T hard, T tick) {
    const T over = min(pressure, hard) - soft;
    return over < T(0) ? T(1e3) : sent - min(model.compliance, tick / model.hammer) * over;
}

/// Limit of a joint from beat to beat: the widest bend, amplitude plus bias, that its pressures allow.
template <class T>
struct Governor {
    T ceiling;       // rad: widest bend that the beats so far allow
    T bend_limit;    // rad: limit in force now, which moves smoothly to the ceiling
    T frequency;     // Hz at which the ceiling was found
    T proven;        // rad: widest bend of the last beat that kept the limit by its readings
    T peak;          // Pa: largest pressure read in the beat so far
    T sent, swung;   // rad: largest bend sent and largest bend read in the beat so far
    bool untrusted;  // whether a reading of this beat is not to be trusted
};

inline constexpr double governor_swing =
    0.8;                                     // part of the rate that the oil allows; a joint that swings faster is cut
inline constexpr double governor_min = 0.6;  // smallest factor on a bend from one beat to the next
inline constexpr double governor_max = 2.0;  // largest factor on a bend from one beat to the next
inline constexpr double governor_floor = 0.02;  // rad: smallest limit of a bend

/// A beat that ends: the bend it was allowed, its frequency, and the joint's limits.
template <class T>
struct BeatEnd {
    T bend;       // rad: widest bend allowed at the end of the beat
    T frequency;  // Hz that is commanded
    T reach;      // rad: largest bend of the joint
    T rate;       // rad/s: largest rate of its bend
};

/// Update the governor at the end of a beat. The pressure above the fill grows with the bend in proportion, in water up
/// to its square, and it takes some beats to develop. So the ceiling is cut in proportion and grows only by the fourth
/// root, from a ceiling that may have fallen within the beat.
template <class T>
void govern(Governor<T>& governor, const BeatEnd<T>& beat, T fill, T work) {
    const T margin = work - fill;
    // Inertia carries a joint that swings wider than it was sent: the oil that it presses out hammers.
    const T swing = T(2 * pi) * max(beat.frequency, T(0.1)) * max(governor.swung, T(governor_floor));
    const T part = min(margin / max(governor.peak - fill, T(0.01) * margin), T(governor_swing) * beat.rate / swing);
    if (part < T(1)) {
        governor.ceiling = min(governor.ceiling, beat.bend * max(part, T(governor_min)));
        governor.proven = min(governor.proven, governor.ceiling);
    } else if (!governor.untrusted) {
        const T grown = min(beat.bend, governor.ceiling) * min(sqrt(sqrt(part)), T(governor_max));
        governor.ceiling = max(governor.ceiling, grown);
        governor.proven = governor.sent;
        governor.frequency = beat.frequency;
    }
    governor.ceiling = clamp(governor.ceiling, T(governor_floor), beat.reach);
    governor.peak = fill;
    governor.sent = governor.swung = T(0);
    governor.untrusted = false;
}

/// At a frequency above those of the beats so far, bound the ceiling by a bend that is safe by the model.
template <class T>
void expect(Governor<T>& governor, T frequency, T safe) {
    if (frequency <= T(1.02) * governor.frequency) return;
    governor.ceiling = min(governor.ceiling, max(safe, T(governor_floor)));
    governor.frequency = frequency;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
