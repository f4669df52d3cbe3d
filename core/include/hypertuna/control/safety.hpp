/// Safety: validity of readings, limits of the amplitude of a joint and of the pressure of a pump, and the status.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "hypertuna/control/cpg.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

// The one limit of joint groups; the others follow. Memory and messages of a board have room for fewer.
inline constexpr int board_joints = 4;
#ifdef HYPERTUNA_BOARD
inline constexpr int max_joints = board_joints;
#else
inline constexpr int max_joints = 12;
#endif
inline constexpr int max_coordinates = max_joints + 1;  // of a tail: joint groups and hinges
inline constexpr int max_circuits = 2 * max_joints;
inline constexpr int max_servos = max_circuits + 2;
/// Servos of a robot: two a joint, and those of the two pectoral fins.
constexpr int servos_of(int joints) { return 2 * joints + 2; }

/// A bit per joint, circuit or servo.
using Places =
    std::conditional_t<max_servos <= std::numeric_limits<std::uint16_t>::digits, std::uint16_t, std::uint32_t>;

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

/// Within bounds; what is no number comes to the upper one.
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
    T repeats;    // equal readings in a row that make a fault, of a robot in full motion: more of them where it is slow
};

/// The past of one sensor. `bucket` fills where readings are bad and drains where they are good.
template <class T>
struct Health {
    T last;     // last finite reading within range
    T repeats;  // of that reading, each as far as the robot moved
    int bucket;
    bool faulty, seen;
};

inline constexpr int bucket_bad = 4;      // a bad reading weighs as much as four good ones
inline constexpr int bucket_faulty = 20;  // five bad readings in a row, or every fourth of them bad
inline constexpr int bucket_max = 100;    // a second of good readings at 100 Hz redeems the worst sensor
inline constexpr float repeats_fast = 6,
                       repeats_slow = 25;  // equal readings: of what moves with each beat, of the rest

template <class T>
struct ReadingQuality {
    bool usable;    // finite, within range and step, not stuck
    bool repeated;  // the very same number as before
};

/// Judge one reading. `expected` is what it may be one step away from: the last reading, or a prediction. `motion` of
/// the robot is from 0, at rest, to 1; `agrees` is whether nothing else contradicts the reading.
template <class T>
ReadingQuality<T> judge(const Plausible<T>& limits, Health<T>& health, T reading, T expected,
                        std::type_identity_t<T> motion, bool agrees = true) {
    const bool inside = limits.low <= reading && reading <= limits.high;  // false for what is no number
    bool near = false, repeated = false;
    if (inside) {
        near = abs(reading - expected) <= limits.step || !health.seen;
        repeated = reading == health.last && health.seen;
        health.last = reading, health.seen = true;
    }
    health.repeats = repeated ? min(health.repeats + motion, limits.repeats) : T(0);
    const bool usable = near && agrees && health.repeats < limits.repeats;
    if (usable && health.bucket == 0) return {true, repeated};  // as nearly always: not faulty, nothing to drain
    const int bucket = health.bucket + (usable ? -1 : bucket_bad);
    health.bucket = bucket < bucket_max ? bucket : bucket_max;
    health.faulty = health.bucket >= bucket_faulty || (health.faulty && health.bucket > 0);
    return {usable && !health.faulty, repeated};
}

/// Whether a sensor shows the same number for the third time, in full motion: it may be stuck, long before that counts
/// as a fault.
template <class T>
bool repeats(const Health<T>& health) {
    return T(1.9) < health.repeats;
}

inline constexpr int hold_terms = 4;

/// What the supervisor knows of one circuit.
template <class T>
struct SupervisorModel {
    T speed;             // rad/s of the servo without load, at the rated voltage
    T stall;             // Pa at which it stalls, at the rated voltage
    T fill;              // Pa: pressure at rest
    T compliance;        // rad/Pa: how far the servo turns for a pressure at the soft limit, where the joint is held
    T line;              // Pa s/rad: drop along the line per rate of the servo, with the thickest oil that flows
    T hammer;            // Pa s/rad: hammer of the line's oil per rate of the servo
    T draw;              // rad/s: largest rate of the servo that draws oil, whose hammer leaves no cavity
    T smooth;            // rad/s: largest change of its rate within a tick, of which the line does not ring
    T spare;             // rad/s/Pa: how much slower it draws for a trough below the fill; 0 where readings show none
    T hold[hold_terms];  // Pa/rad to Pa/rad^4: by powers of a bend to its side, what holds it at rest, above the fill

    /// Whether its line is so long that a pump that jerks makes it ring.
    bool rings() const { return smooth < T(1e6); }
};

/// Pressure that holds a bend at rest, Pa.
template <class T>
T held(const SupervisorModel<T>& model, T bend) {
    const T* term = model.hold;
    return model.fill + (((term[3] * bend + term[2]) * bend + term[1]) * bend + term[0]) * bend;
}

/// A sensor is astray whose mean over `astray_time` differs from the model's pressure by more than this part of the
/// room from fill to soft limit, and of what the bend takes. The mean has little of the water's loads.
inline constexpr double astray_time = 0.6;  // s
inline constexpr double astray_room = 0.2, astray_held = 0.25;

/// Part of the way to a lower reading that the crest of a line that rings falls within a tick; its trough rises
/// likewise.
inline constexpr double rung_out = 0.15;

/// Two readings of a trusted sensor in a row above the hard limit release a joint, and this many of any sensor.
inline constexpr int hard_trusted = 2, hard_any = 5;

template <class T>
struct SupervisorState {
    T pressure;         // Pa: last valid reading, the fill pressure before the first
    T before;           // Pa: the one before
    T crest, trough;    // Pa: of the readings, of a line that rings
    T change;           // rad: of the servo's angle that the last tick commanded
    Follower<T> servo;  // rad: where the servo is, as long as no load slows it down
    T turned[2];        // rad: its change in the two ticks before
    T astray;           // Pa: how far the sensor reads from what bend and stroke make of the pressure, a mean
    bool wrong, bent;   // that is too far, and the pressure sensor is to blame, or the bend sensor
    int hard;           // readings in a row above the hard limit, trusted or not
    bool stopped;       // released by the hard limit
};

/// Within a tick: the furthest angle a pump may be sent to. Beyond the soft limit it goes back by what takes the
/// pressure off, but for no more than the hard limit's: a sensor may lie; and no faster than so that the hammer of
/// going back takes it off: in a long line it would come again.
template <class T>
T furthest(const SupervisorModel<T>& model, T sent, T pressure, T soft, T hard, T tick) {
    const T over = min(pressure, hard) - soft;
    return over < T(0) ? T(1e3) : sent - min(model.compliance, tick / model.hammer) * over;
}

/// From beat to beat: the widest bend of a joint, amplitude and bias, that its pressures allow.
template <class T>
struct Governor {
    T ceiling;      // rad: what the beats so far allow
    T bend_limit;   // rad: what is allowed now, on its way to that
    T frequency;    // Hz that the ceiling was found at
    T proven;       // rad: widest bend of the last beat that was seen to keep the limit
    T peak;         // Pa: largest pressure read in the beat so far
    T sent, swung;  // rad: largest bend that the joint was sent to, and that was read, in the beat so far
    bool doubt;     // a reading of this beat is not to be trusted
};

inline constexpr double governor_swing = 0.8;   // of the rate that the oil allows: a joint that swings faster is cut
inline constexpr double governor_min = 0.6;     // a bend falls to this part from beat to beat at most,
inline constexpr double governor_max = 2.0;     // and grows to this one
inline constexpr double governor_floor = 0.02;  // rad: a bend is never governed below

/// A beat that ends, and what its joint allows.
template <class T>
struct BeatEnd {
    T bend;       // rad: widest bend that is allowed at its end
    T frequency;  // Hz that is commanded
    T reach;      // rad: largest bend of the joint
    T rate;       // rad/s: largest rate of its bend
};

/// End of a beat. Pressure above the fill grows with the bend in proportion, in water up to its square, and it takes
/// some beats to come about: cut in proportion, and grow by the fourth root, from a ceiling that may have fallen within
/// the beat.
template <class T>
void govern(Governor<T>& governor, const BeatEnd<T>& beat, T fill, T work) {
    const T room = work - fill;
    // A joint that swings wider than it was sent is carried by its inertia: the oil that it presses out hammers.
    const T swing = T(2 * pi) * max(beat.frequency, T(0.1)) * max(governor.swung, T(governor_floor));
    const T part = min(room / max(governor.peak - fill, T(0.01) * room), T(governor_swing) * beat.rate / swing);
    if (part < T(1)) {
        governor.ceiling = min(governor.ceiling, beat.bend * max(part, T(governor_min)));
        governor.proven = min(governor.proven, governor.ceiling);
    } else if (!governor.doubt) {
        const T grown = min(beat.bend, governor.ceiling) * min(sqrt(sqrt(part)), T(governor_max));
        governor.ceiling = max(governor.ceiling, grown);
        governor.proven = governor.sent;
        governor.frequency = beat.frequency;
    }
    governor.ceiling = clamp(governor.ceiling, T(governor_floor), beat.reach);
    governor.peak = fill;
    governor.sent = governor.swung = T(0);
    governor.doubt = false;
}

/// A frequency that no beat was seen at yet begins with a bend that the model holds safe.
template <class T>
void expect(Governor<T>& governor, T frequency, T safe) {
    if (frequency <= T(1.02) * governor.frequency) return;
    governor.ceiling = min(governor.ceiling, max(safe, T(governor_floor)));
    governor.frequency = frequency;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
