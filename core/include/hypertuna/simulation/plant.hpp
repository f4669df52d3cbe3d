/// Plant: all of the robot that physics alone moves, from the servos' targets to the wake.
///
/// Oil pressures push on the joints in proportion to how the bend changes the units' volume (virtual work), the joints
/// bend the tail against the water, and the bend in turn takes oil out of the circuits. Each soft joint also shortens,
/// without mass: its viscosity balances its axial force. The links keep their lengths (docs/twin.md).
///
/// A joint without oil has a servo on its axle or on tendons that do not stretch: the servo of circuit 2 j, which turns
/// `gear` times as far as the joint bends and pulls `gear` times as hard; circuit 2 j + 1 rests.
///
/// Coordinates of the tail are the bends of the joints, with circuits 2 j (left) and 2 j + 1 (right) on joint j;
/// passive hinges may follow. The body is one in the plane (tail.hpp) or in space (body6.hpp).
#pragma once

#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/actuation/joint.hpp"
#include "hypertuna/simulation/losses.hpp"
#include "hypertuna/simulation/tail.hpp"
#include "hypertuna/swimming/spring.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class Body>
struct Plant {
    using S = typename Body::Scalar;

    Body body;
    int joints;                 // coordinates that circuits bend; the others are passive hinges
    const Joint<S>* joint;      // one per joint
    const bool* direct;         // joints: whether a servo moves the joint, not oil
    const S* gear;              // joints: turns of that servo per bend, 1 on the axle
    const Circuit<S>* circuit;  // two per joint
    const S* unit_rest;         // 2 joints: m^3 of oil in the muscles of the straight, filled joint
    const Spring<S>* spring;    // spring of each hinge
};

template <class S, int D, class Space = InPlane>
struct PlantState {
    typename HeadOf<S, Space>::Twist xi;
    typename HeadOf<S, Space>::Pose pose;
    Bend<S, D> bend;
    S strain[D];                     // strain of each joint's axis relative to the filled joint; zero for a hinge
    CircuitState<S> circuit[2 * D];  // circuits of the joints; those of a hinge stay at zero
    S energy[2 * D];                 // J, electrical energy that each servo has drawn

    template <class A>
    friend HYPERTUNA_INLINE PlantState operator*(const A& a, const PlantState& b) {
        PlantState out;
        out.xi = a * b.xi;
        out.pose = a * b.pose;
        for (int d = 0; d < D; ++d) {
            out.bend.angle[d] = a * b.bend.angle[d];
            out.bend.rate[d] = a * b.bend.rate[d];
            out.strain[d] = a * b.strain[d];
        }
        for (int c = 0; c < 2 * D; ++c) {
            out.circuit[c] = a * b.circuit[c];
            out.energy[c] = a * b.energy[c];
        }
        return out;
    }
    friend HYPERTUNA_INLINE PlantState operator+(const PlantState& a, const PlantState& b) {
        PlantState out;
        out.xi = a.xi + b.xi;
        out.pose = a.pose + b.pose;
        for (int d = 0; d < D; ++d) {
            out.bend.angle[d] = a.bend.angle[d] + b.bend.angle[d];
            out.bend.rate[d] = a.bend.rate[d] + b.bend.rate[d];
            out.strain[d] = a.strain[d] + b.strain[d];
        }
        for (int c = 0; c < 2 * D; ++c) {
            out.circuit[c] = a.circuit[c] + b.circuit[c];
            out.energy[c] = a.energy[c] + b.energy[c];
        }
        return out;
    }
};

template <class Body>
using PlantStateOf = PlantState<typename Body::Scalar, Body::coordinates, typename Body::Space>;

/// Targets of the servos and their voltage, held from one control step to the next.
template <class S, int D>
struct ServoTargets {
    S angle[2 * D];  // rad
    S supply;        // V
    S fin[2];        // rad, of the pectoral fins, for a body in space
};

/// Quantities of one instant that follow from the state.
template <class S, int D, class Space = InPlane>
struct PlantOutput {
    CircuitOutput<S> circuit[2 * D];
    S moment[D];  // N m on each coordinate
    typename HeadOf<S, Space>::Twist twist_rate;
    Losses<S> losses;
};
template <class Body>
using PlantOutputOf = PlantOutput<typename Body::Scalar, Body::coordinates, typename Body::Space>;

/// Rate around which the units' friction sets in smoothly, rad/s: a slower joint counts as at rest. So friction neither
/// chatters nor forces small steps.
inline constexpr double joint_rest = 0.05;

/// Share of Coulomb friction that acts at a rate: -1 to 1.
template <class S>
HYPERTUNA_INLINE S sliding(const S& rate) {
    const S rest = S(base_t<S>(joint_rest));
    return rate / sqrt(rate * rate + rest * rest);
}

/// Moment on a joint's bend: of oil and silicone, viscosity, and friction of the units that pressure holds in their
/// braids.
template <class S>
HYPERTUNA_INLINE S bend_moment(const Joint<S>& joint, const JointLoad<S>& load, const S& rate) {
    return joint_moment(load) - joint.viscosity * rate - joint_friction(load) * sliding(rate);
}

/// Add a servo's own losses.
template <class S>
HYPERTUNA_INLINE void add_servo(Losses<S>& to, const ServoPower<S>& power) {
#define HYPERTUNA_LOSS(name) to.name += power.name;
#define HYPERTUNA_WORK(name, share)
    HYPERTUNA_SERVO_POWERS(HYPERTUNA_LOSS, HYPERTUNA_WORK)
#undef HYPERTUNA_WORK
#undef HYPERTUNA_LOSS
}

/// Add the losses of both sides' oil, from the cylinders to a joint whose bend and strain change at these rates: what
/// neither line nor joint takes goes into springs, of oil, air, hoses and silicone.
template <class S>
HYPERTUNA_INLINE void add_oil(Losses<S>& to, const Joint<S>& joint, const JointLoad<S>& load,
                              const CircuitOutput<S>* circuit, const S& rate, const S& strain_rate) {
    const S line = circuit[0].line + circuit[1].line, pumped = circuit[0].power.load + circuit[1].power.load;
    to.line += line;
    to.braid += joint_friction(load) * sliding(rate) * rate;
    to.silicone += joint.viscosity * rate * rate + joint.axial_viscosity * strain_rate * strain_rate;
    to.elastic += pumped - line - joint_moment(load) * rate - joint_thrust(load) * strain_rate;
}

/// A joint that oil bends: set the rates of its circuits and its strain, and return the moment on its bend.
template <class Body>
HYPERTUNA_INLINE auto bend_by_oil(const Plant<Body>& plant, const PlantStateOf<Body>& at,
                                  const ServoTargets<typename Body::Scalar, Body::coordinates>& targets, int j,
                                  PlantStateOf<Body>& rate, PlantOutputOf<Body>* seen) {
    using S = typename Body::Scalar;
    const JointOil<S> oil{plant.circuit + 2 * j, at.circuit + 2 * j, plant.unit_rest + 2 * j};
    const JointLoad<S> load = joint_load(plant.joint[j], at.bend.angle[j], at.strain[j], oil);
    for (int side = 0; side < 2; ++side) {
        const int c = 2 * j + side;
        const CircuitRate<S> circuit = circuit_rate(plant.circuit[c], at.circuit[c], targets.angle[c], targets.supply,
                                                    load.volume[side] - plant.unit_rest[c]);
        rate.circuit[c] = circuit.rate;
        rate.energy[c] = circuit.output.power.total;
        seen->circuit[c] = circuit.output;
        add_servo(seen->losses, circuit.output.power);
    }
    rate.strain[j] = joint_thrust(load) / plant.joint[j].axial_viscosity;
    add_oil(seen->losses, plant.joint[j], load, seen->circuit + 2 * j, at.bend.rate[j], rate.strain[j]);
    return bend_moment(plant.joint[j], load, at.bend.rate[j]);
}

/// A joint with a servo: set the power that the servo draws, and return the moment on the bend, by virtual work.
template <class Body>
HYPERTUNA_INLINE auto turn_by_servo(const Plant<Body>& plant, const PlantStateOf<Body>& at,
                                    const ServoTargets<typename Body::Scalar, Body::coordinates>& targets, int j,
                                    PlantStateOf<Body>& rate, PlantOutputOf<Body>* seen) {
    using S = typename Body::Scalar;
    const int c = 2 * j;
    const Servo<S>& servo = plant.circuit[c].servo;
    const S &gear = plant.gear[j], turning = gear * at.bend.rate[j];
    const ServoDrive<S> drive = axle_drive(servo, targets.supply, targets.angle[c], gear * at.bend.angle[j], turning);
    const S moment = drive.torque - drive.rubbed;
    const ServoPower<S> power = servo_power(servo, drive, targets.supply, moment, turning);
    rate.circuit[c + 1] = {S(0), S(0), S(0), S(0)};
    rate.energy[c] = power.total, rate.energy[c + 1] = S(0);
    rate.strain[j] = S(0);
    seen->circuit[c] = {{S(0), S(0)}, {S(0), S(0)}, moment, drive.torque, power, S(0)};
    seen->circuit[c + 1] = {};
    add_servo(seen->losses, power);
    return gear * moment;
}

/// The state at rest, with the hinges where their springs rest.
template <class S, int D, class Space>
PlantState<S, D, Space> at_rest(int joints, const Spring<S>* spring) {
    PlantState<S, D, Space> state{};
    for (int d = joints; d < D; ++d) state.bend.angle[d] = spring[d - joints].rest;
    return state;
}
template <class Body>
PlantStateOf<Body> at_rest(const Plant<Body>& plant) {
    return at_rest<typename Body::Scalar, Body::coordinates, typename Body::Space>(plant.joints, plant.spring);
}

/// Time derivative of the plant's state. `seen` receives the output of the instant.
template <class Body>
HYPERTUNA_NOINLINE PlantStateOf<Body> plant_rate(const Plant<Body>& plant, const PlantStateOf<Body>& at,
                                                 const ServoTargets<typename Body::Scalar, Body::coordinates>& targets,
                                                 PlantOutputOf<Body>* seen) {
    using S = typename Body::Scalar;
    constexpr int D = Body::coordinates;
    PlantStateOf<Body> rate;
    S moment[D];
    seen->losses = {};
    for (int j = 0; j < plant.joints; ++j)
        moment[j] = plant.direct[j] ? turn_by_servo(plant, at, targets, j, rate, seen)
                                    : bend_by_oil(plant, at, targets, j, rate, seen);
    for (int d = plant.joints; d < D; ++d) {
        for (int c = 2 * d; c < 2 * d + 2; ++c) {
            rate.circuit[c] = {S(0), S(0), S(0), S(0)};
            rate.energy[c] = S(0);
        }
        rate.strain[d] = S(0);
        const Spring<S>& spring = plant.spring[d - plant.joints];
        const S angle = at.bend.angle[d] - spring.rest;
        moment[d] = spring.elastic(angle) - spring.drag(angle) * at.bend.rate[d];
        seen->losses.hinge -= moment[d] * at.bend.rate[d];
    }
    const auto body = body_acceleration(plant.body, at.bend, at.xi, at.pose, moment);
    rate.xi = body.twist;
    rate.pose = pose_rate(plant.body, at.pose, at.xi, targets.fin);
    for (int d = 0; d < D; ++d) {
        rate.bend.angle[d] = at.bend.rate[d];
        rate.bend.rate[d] = body.bend[d];
        if (d < plant.joints && plant.direct[d])
            rate.circuit[2 * d] = {plant.gear[d] * at.bend.rate[d], plant.gear[d] * body.bend[d], S(0), S(0)};
        seen->moment[d] = moment[d], seen->losses.water += moment[d] * at.bend.rate[d];
    }
    seen->twist_rate = body.twist;
    return rate;
}

/// One step of fourth-order Runge-Kutta; `seen` receives the outputs at its start and middle, and the losses of the
/// step [J] are added to `losses`.
template <class Body>
PlantStateOf<Body> plant_step(const Plant<Body>& plant, const PlantStateOf<Body>& at,
                              const ServoTargets<typename Body::Scalar, Body::coordinates>& targets,
                              const typename Body::Scalar& step, PlantOutputOf<Body> (&seen)[2],
                              Losses<typename Body::Scalar>& losses) {
    using S = typename Body::Scalar;
    using State = PlantStateOf<Body>;
    const auto rate = [&](const State& now, PlantOutputOf<Body>& out, const S& weight) {
        const State change = plant_rate(plant, now, targets, &out);
        add(losses, weight, out.losses);
        return change;
    };
    const S half = S(base_t<S>(0.5)) * step, sixth = S(base_t<S>(1.0 / 6)) * step, third = sixth + sixth;
    PlantOutputOf<Body> end;
    const State k1 = rate(at, seen[0], sixth);
    const State k2 = rate(at + half * k1, seen[1], third);
    const State k3 = rate(at + half * k2, seen[1], third);
    const State k4 = rate(at + step * k3, end, sixth);
    State next = at + sixth * k1 + third * k2 + third * k3 + sixth * k4;
    next.pose = tidied(next.pose);
    return next;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
