/// Pair: the two circuits of a joint and the joint between them, in air and without mass.
///
/// A pair shows what the hydraulics alone can do: at every instant the bend is where silicone and oil balance. Friction
/// of the braid and viscosity of the silicone are left out; the twin adds water and mass.
#pragma once

#include "hypertuna/actuation/balance.hpp"
#include "hypertuna/actuation/circuit.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Pair {
    Circuit<S> circuit[2];  // left, right
    Joint<S> joint;
    S rest[2];  // m^3 in the units of each side when the joint is straight and filled
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
Pair<S> make_pair(const Circuit<S>& left, const Circuit<S>& right, const Joint<S>& joint) {
    const JointLoad<S> straight = taut_load(joint, S(0), S(0));
    return {{left, right}, joint, {straight.volume[0], straight.volume[1]}};
}

/// Oil in the circuits of both sides.
template <class S>
JointOil<S> oil_of(const Pair<S>& pair, const PairState<S>& state) {
    return {pair.circuit, state.side, pair.rest};
}

/// Bend and strain where moment and axial force of the joint vanish, by Newton's method from `near`.
template <std::floating_point S>
Bent<S> pair_balance(const Pair<S>& pair, const PairState<S>& state, const Bent<S>& near) {
    return joint_balance(pair.joint, near, oil_of(pair, state));
}

/// Time derivatives of both circuits' states with the joint at a bend, and the circuits' outputs.
template <class S>
struct PairRate {
    PairState<S> rate;
    CircuitOutput<S> output[2];
};
template <class S>
PairRate<S> pair_rate(const Pair<S>& pair, const PairState<S>& state, const S* target, const S& supply,
                      const Bent<S>& bent) {
    const JointLoad<S> load = joint_load(pair.joint, bent.angle, bent.strain, oil_of(pair, state));
    PairRate<S> out;
    for (int s = 0; s < 2; ++s) {
        const S space = load.volume[s] - pair.rest[s];
        const CircuitRate<S> side = circuit_rate(pair.circuit[s], state.side[s], target[s], supply, space);
        out.rate.side[s] = side.rate, out.output[s] = side.output;
    }
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
