/// Servo: a geared DC motor with a position loop, its limits, and the electrical power that it draws.
///
/// Angle and rate are states, and rotor and gears have inertia: otherwise the rate would jump when the target does, and
/// the oil's reaction would make the loop algebraic. The loop is critically damped and knows its load, so only the
/// torque-speed line makes the servo lag. The fastest rates are a few hundred 1/s (`servo_rate`).
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Servo {
    S stall_torque;   // N m, at `voltage`
    S speed;          // rad/s without load, at `voltage`
    S bandwidth;      // Hz at which the position loop passes 71 % of a small motion
    S friction;       // N m, friction of the gears in motion, and the most that they hold at rest
    S voltage;        // V that torque, speed and current are given at
    S stall_current;  // A
    S idle_current;   // A: electronics and the motor's own losses
    S inertia;        // kg m^2 of rotor and gears, at the output
};
#define HYPERTUNA_SERVO_COLUMNS \
    "stall_torque", "speed", "bandwidth", "friction", "voltage", "stall_current", "idle_current", "inertia"

/// What a servo does at one instant.
template <class S>
struct ServoDrive {
    S acceleration;  // rad/s^2
    S torque;        // N m that motor and gears make before friction
    S rubbed;        // N m of `torque` that friction takes; negative where friction holds instead of the motor
    S sealed;        // N m of `rubbed` that the seals of a piston take
};

/// Electrical power of a servo by what it goes to; the shares add up to `total`.
template <class S>
struct ServoPower {
    S total;     // W
    S idle;      // W: electronics
    S windings;  // W: heat of the current that torque takes, at rest and in motion
    S load;      // W: work on the load, the oil or a joint, negative where it pushes back
    S gears;     // W: rubbed away in the gears
    S seals;     // W: rubbed away by the piston's seals
    S rotor;     // W: into the rotor, negative while it slows down; a beat's mean is zero
    S braking;   // W: work of load and rotor that comes back and is not regained
};
/// List of the shares of a servo's power: LOSS(name) of each that is lost or stored in the rotor, WORK(name, share) of
/// the work on the oil.
#define HYPERTUNA_SERVO_POWERS(LOSS, WORK) \
    LOSS(idle) LOSS(windings) WORK(hydraulic, load) LOSS(gears) LOSS(seals) LOSS(rotor) LOSS(braking)

/// Rate around which friction sets in smoothly, rad/s: a slower servo counts as at rest.
inline constexpr double servo_rest = 0.05;

/// Natural frequency [1/s] of the critically damped loop per bandwidth [Hz]: |1 / (1 + i w / w0)^2| = 1 / sqrt(2)
/// there.
inline constexpr double servo_loop_rate = 2 * pi / 0.64359425290558262;

/// Natural frequency of the position loop, 1/s.
template <class S>
HYPERTUNA_INLINE S servo_loop(const Servo<S>& servo) {
    return servo.bandwidth * S(base_t<S>(servo_loop_rate));
}

/// Share of the friction that acts at a rate: -1 to 1.
template <class S>
HYPERTUNA_INLINE S rubbing(const S& rate) {
    const S rest = S(base_t<S>(servo_rest));
    return rate / sqrt(rate * rate + rest * rest);
}

/// Turn toward the target against a load as fast as loop and torque-speed line allow.
///
/// |torque| <= stall_torque (supply / voltage -+ rate / speed). At rest friction holds what it can, and the motor
/// makes only the rest. `sealing` is the friction of a piston's seals [N m], which adds to that of the gears.
template <class S>
ServoDrive<S> servo_drive(const Servo<S>& servo, const S& supply, const S& load, const S& target, const S& angle,
                          const S& rate, const S& sealing = S(0)) {
    const S friction = servo.friction + sealing;
    const S loop = servo_loop(servo), share = rubbing(rate), rubbed = friction * share;
    const S drive = servo.stall_torque * (supply / servo.voltage), back = servo.stall_torque * (rate / servo.speed);
    const S desired = servo.inertia * loop * (loop * (target - angle) - S(2) * rate);
    const S spent = back + load + rubbed;
    const S turning = max(S(0) - drive - spent, min(drive - spent, desired));
    const S acceleration = turning / servo.inertia, net = turning + load;
    const S held = max(S(0), min(friction, min(load, net))) + min(S(0), max(S(0) - friction, max(load, net)));
    const S taken = rubbed - (S(1) - abs(share)) * held;
    return {acceleration, net + taken, taken, sealing * share};
}

/// Torque of a servo on the axle of a joint. The loop does not know its load, and acts as a spring and a damper within
/// the torque-speed line. The rotor's inertia is part of the joint's (`Tail::armature`).
template <class S>
ServoDrive<S> axle_drive(const Servo<S>& servo, const S& supply, const S& target, const S& angle, const S& rate) {
    const S loop = servo_loop(servo);
    const S drive = servo.stall_torque * (supply / servo.voltage), back = servo.stall_torque * (rate / servo.speed);
    const S desired = servo.inertia * loop * (loop * (target - angle) - S(2) * rate);
    const S torque = max(S(0) - drive - back, min(drive - back, desired));
    return {S(0), torque, servo.friction * rubbing(rate), S(0)};
}

/// Power of a DC motor, without regeneration: idle + torque rate + heat, and never less than idle.
template <class S>
ServoPower<S> servo_power(const Servo<S>& servo, const ServoDrive<S>& drive, const S& supply, const S& load,
                          const S& rate) {
    const S part = drive.torque / servo.stall_torque;
    const S idle = supply * servo.idle_current, windings = part * part * (servo.voltage * servo.stall_current);
    const S work = load * rate, friction = drive.rubbed * rate, seals = drive.sealed * rate;
    const S rotor = servo.inertia * drive.acceleration * rate;
    const S braking = max(S(0), S(0) - (windings + work + friction + rotor));
    const S total = idle + windings + work + friction + rotor + braking;
    return {total, idle, windings, work, friction - seals, seals, rotor, braking};
}

/// Upper bound of the rates of a servo on an axle, 1/s: of the loop's spring, and of its damper with the torque-speed
/// line and the onset of friction. `mobility` is the axle's acceleration per torque, its own rotor included, rad/s^2
/// per N m.
template <class S>
S axle_stiffness(const Servo<S>& servo, const S& mobility) {
    const S loop = servo_loop(servo), spring = servo.inertia * loop * loop;
    const S line = servo.stall_torque / servo.speed, onset = servo.friction / S(base_t<S>(servo_rest));
    return max(sqrt(spring * mobility), (S(2) * servo.inertia * loop + line + onset) * mobility);
}

/// Upper bound of the servo's own rates, 1/s: the loop, or the torque-speed line and the onset of friction.
template <class S>
S servo_rate(const Servo<S>& servo) {
    const S line = servo.stall_torque / servo.speed + servo.friction / S(base_t<S>(servo_rest));
    return max(S(2) * servo_loop(servo), line / servo.inertia);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
