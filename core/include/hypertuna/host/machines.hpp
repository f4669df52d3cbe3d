/// Machines side by side in lanes, without saying for which processor: plain numbers in, plain numbers out.
#pragma once

#include "hypertuna/control/safety.hpp"
#include "hypertuna/host/model.hpp"

namespace hypertuna {

/// Coordinates of the tail that there is code for, for a tail of some: as many up to `exact_tail`, else the most.
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

/// As many machines as there are lanes, which fit each other. States and ticks are MachineState<double, D> and
/// MachineTick<double, D> as numbers, one pointer per lane; a place may be given twice.
struct MachineKernel {
    int lanes;
    void* (*make)(const PlantNumbers* const* robots, double tick, int steps);
    void (*free)(void* machines);
    /// What the start of a tick shows: the output `seen` of each tick.
    void (*look)(void* machines, const double* const* states, double* const* ticks);
    /// The rest of the tick, while the targets hold.
    void (*follow)(void* machines, double* const* states, double* const* ticks);
};

}  // namespace hypertuna
