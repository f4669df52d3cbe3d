/// A learned policy: a multilayer perceptron whose output is a command to the controller.
///
/// The command takes the place of a ground station's, and the controller bounds it in the same way.
#pragma once

#include "hypertuna/control/controller_model.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int max_neurons = 128;  // largest number of neurons in a layer, and of numbers in an observation

template <class T>
struct Layer {
    int inputs, outputs;
    const T* weight;  // outputs x inputs
    const T* bias;    // outputs
};

/// Layers with tanh between them, and the scales of its actions, which are from -1 to 1.
template <class T>
struct Policy {
    int layers;
    const Layer<T>* layer;
    int ticks;  // ticks of the controller per step of the policy
    int joints;
    T frequency;                     // Hz, the largest
    T bend[max_joints], lag, steer;  // rad: largest amplitude; largest lag; part of the bend that steers
};

/// Compute the action for an observation, each number from -1 to 1. Four partial sums round less than one running sum.
template <class T>
void act(const Policy<T>& policy, const T* observation, T* action) {
    T values[2][max_neurons];
    const T* in = observation;
    for (int k = 0; k < policy.layers; ++k) {
        const Layer<T>& layer = policy.layer[k];
        const bool last = k + 1 == policy.layers;
        T* const out = last ? action : values[k % 2];
        const T* weight = layer.weight;
        for (int o = 0; o < layer.outputs; ++o, weight += layer.inputs) {
            T a = layer.bias[o], b(0), c(0), d(0);
            int i = 0;
            for (; i + 3 < layer.inputs; i += 4) {
                a += weight[i] * in[i], b += weight[i + 1] * in[i + 1];
                c += weight[i + 2] * in[i + 2], d += weight[i + 3] * in[i + 3];
            }
            for (; i < layer.inputs; ++i) a += weight[i] * in[i];
            const T value = (a + b) + (c + d);
            out[o] = !last ? std::tanh(value) : is_finite(value) ? clamp(value, T(-1), T(1)) : value;
        }
        in = out;
    }
}

/// The command that an action stands for, scaled as in learning/spans.py: frequency, amplitudes, lags, biases. An
/// action with a NaN is not sent as a command: the tail comes to rest, as without a ground station.
template <class T>
Command<T> command_of(const Policy<T>& policy, const T* action) {
    const auto part = [](T number) { return (number + T(1)) / T(2); };
    Command<T> out{};
    out.fresh = out.armed = true;
    for (int k = 0; k < 3 * policy.joints; ++k) out.fresh = out.fresh && is_finite(action[k]);
    if (!out.fresh) return out;
    out.frequency = policy.frequency * part(*action++);
    for (int j = 0; j < policy.joints; ++j) out.amplitude[j] = policy.bend[j] * part(*action++);
    for (int j = 1; j < policy.joints; ++j) out.phase[j] = out.phase[j - 1] + policy.lag * part(*action++);
    for (int j = 0; j < policy.joints; ++j) out.bias[j] = policy.steer * policy.bend[j] * *action++;
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
