/// Pair: the two circuits of a joint and the joint between them, in air and without mass.
///
/// What hydraulics alone can do: the bend is where silicone and oil balance at every instant. Friction of the braid and
/// viscosity of the silicone are left out; water and mass are the twin's.
#pragma once

#include "hypertuna/actuation/circuit.hpp"
#include "hypertuna/actuation/joint_table.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Pair {
    Circuit<S> circuit[2];  // left, right
    JointTable<S> joint;
    S rest[2];  // m^3 in the units of each side when the joint is straight
};

template <class S>
struct PairState {
    CircuitState<S> side[2];

    template <class A>
    friend HYPERTUNA_INLINE PairState operator*(const A& a, const PairState& b) {
        return {a * b.side[0], a * b.side[1]};
    }
    friend HYPERTUNA_INLINE PairState operator+(const PairState& a, const PairState& b) {
        return {a.side[0] + b.side[0], a.side[1] + b.side[1]};
    }
};

template <class S>
Pair<S> make_pair(const Circuit<S>& left, const Circuit<S>& right, const JointTable<S>& joint) {
    const JointLoad<S> straight = joint_load(joint, S(0));
    return {{left, right}, joint, {straight.volume[0], straight.volume[1]}};
}

/// Moment of silicone and oil on the joint at an angle, N m.
template <class S>
S pair_moment(const Pair<S>& pair, const PairState<S>& state, const S& angle) {
    const JointLoad<S> load = joint_load(pair.joint, angle);
    S pressure[2];
    for (int s = 0; s < 2; ++s)
        pressure[s] = unit_pressure(pair.circuit[s], state.side[s], load.volume[s] - pair.rest[s]).pressure;
    return joint_moment(load, pressure);
}

/// Angle where the moments balance, by the secant method from a nearby angle, to 1e-12 rad.
template <class S>
S pair_angle(const Pair<S>& pair, const PairState<S>& state, S near) {
    S last = near + S(base_t<S>(1e-4)), before = pair_moment(pair, state, last), now = pair_moment(pair, state, near);
    for (int k = 0; k < 20 && before != now; ++k) {
        const S step = now * (last - near) / (now - before);
        last = near, before = now;
        near += step;
        if (abs(step) < S(base_t<S>(1e-12))) break;
        now = pair_moment(pair, state, near);
    }
    return near;
}

/// How the states change, and what is seen of them, with the joint at an angle.
template <class S>
struct PairRate {
    PairState<S> rate;
    CircuitOutput<S> output[2];
};
template <class S>
PairRate<S> pair_rate(const Pair<S>& pair, const PairState<S>& state, const S* target, const S& supply,
                      const S& angle) {
    const JointLoad<S> load = joint_load(pair.joint, angle);
    PairRate<S> out;
    for (int s = 0; s < 2; ++s) {
        const S space = load.volume[s] - pair.rest[s];
        const CircuitRate<S> side = circuit_rate(pair.circuit[s], state.side[s], target[s], supply, space);
        out.rate.side[s] = side.rate, out.output[s] = side.output;
    }
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
