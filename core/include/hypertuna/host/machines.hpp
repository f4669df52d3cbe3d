/// Interface of machines side by side in lanes, independent of the processor: plain numbers in, plain numbers out.
#pragma once

#include "hypertuna/control/safety.hpp"
#include "hypertuna/host/model.hpp"

namespace hypertuna {

/// Number of coordinates for which code is compiled, for a tail of some coordinates: the same up to `exact_tail`, else
/// the largest possible.
inline constexpr int exact_tail = 5;
constexpr int tail_size(int coordinates) { return coordinates <= exact_tail ? coordinates : max_coordinates; }

/// Call work(std::integral_constant<int, D>) with the number of coordinates.
template <int D = 1, class Work>
void with_coordinates(int coordinates, const Work& work) {
    if constexpr (D < max_coordinates)
        if (coordinates != D) return with_coordinates<tail_size(D + 1)>(coordinates, work);
    work(std::integral_constant<int, D>());
}

/// A plant in the plane as rows of numbers.
struct PlantNumbers {
    const Model* model;
    int coordinates, joints;
    bool clamped;
    const bool* direct;       // joints
    const double* gear;       // joints
    const double* share;      // links x coordinates
    const double* armature;   // coordinates
    const double* joint;      // joints x (joint_columns, and the stretch limits)
    const double* circuit;    // 2 joints x circuit_columns
    const double* unit_rest;  // 2 joints
    const double* spring;     // max_coordinates x spring_numbers, those of the hinges first
    const double* battery;    // battery_columns
    double idle;
};

/// Functions on as many machines as there are lanes, which have the same structure. States and ticks are
/// MachineState<double, D> and MachineTick<double, D> as numbers, one pointer per lane; two lanes may share one.
struct MachineKernel {
    int lanes;
    void* (*make)(const PlantNumbers* const* robots, double tick, int steps);
    void (*free)(void* machines);
    /// Evaluate the plants at the start of the tick, and write what can be sensed there to each tick's `seen`.
    void (*look)(void* machines, const double* const* states, double* const* ticks);
    /// Simulate the rest of the tick, while the targets hold.
    void (*follow)(void* machines, double* const* states, double* const* ticks);
};

}  // namespace hypertuna
