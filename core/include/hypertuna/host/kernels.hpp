/// Interface of the kernels, independent of the processor: plain numbers in, plain numbers out.
#pragma once

#include <cstddef>
#include <vector>

#include "hypertuna/host/machines.hpp"

namespace hypertuna {

/// Gaits side by side; each array is row-major, gaits x groups.
struct GaitBatch {
    const double *frequency, *amplitude, *phase, *bias;
};

struct SettleOptions {
    int steps;      // per beat, a multiple of 4
    int wait;       // beats from rest instead of Newton's method; negative for Newton
    int max_beats;  // largest number in each of the stages of Newton's method
    int from_rest;  // beats from rest before Newton's method begins; negative: it begins at a brisk speed
    int approach;   // largest number of beats over which a start from rest is followed toward the settled beat; 0 for
                    // none
    double mass;    // kg, of the whole body
};

/// A joint motion given at every half step: angle, rate and acceleration, 2 steps + 1 x links x 3.
struct JointSeries {
    const double* motion;
    std::size_t steps;
    double step;          // s
    const double* twist;  // twist of the head at the start [m/s, m/s, rad/s], null at rest in the water
};

/// Pose of the nose at every step, its rate, and the derivatives of both: steps + 1 x 3 (x directions), row-major. With
/// a twist at the start, derivatives with respect to its components come first.
struct Track {
    double *pose, *rate, *gradient;
    double* rate_gradient;  // null where it is not wanted
};

/// Directions in the space of all parameters: parameters x count, row-major; -3, -2, -1 are the
/// components of the momentum or twist at the start.
struct Directions {
    const double* along;
    int count;
    std::vector<int> still, moving;  // directions that leave the shape of the body as it is, and those that change it
};

struct Kernel {
    const char* name;
    int lanes;
    /// Write settled beats of gaits [begin, end) into rows with settle_columns as columns: all quantities, then the
    /// results of the search.
    void (*settle)(const Model&, const GaitBatch&, const SettleOptions&, int begin, int end, double* rows);
    /// Write derivatives of one beat of gaits [begin, end) that start at `momentum`. Each gait has a row for each
    /// differentiable quantity and three for the momentum at the end; a row has 3 + directions numbers, with respect to
    /// the momentum at the start and along the directions. `mass` is the whole body's [kg].
    void (*gradient)(const Model&, const GaitBatch&, const Directions&, int begin, int end, const double* momentum,
                     int steps, double mass, double* rows);
    /// Swim a joint motion from rest, with derivatives along directions.
    void (*track)(const Model&, const JointSeries&, const Directions&, const Track&);
    /// Write the mean force toward the head of gaits [begin, end) whose head is held on a straight path at `speed`
    /// [m/s] each: for each gait the force [N], then its derivatives along directions.
    void (*held)(const Model&, const GaitBatch&, const Directions&, int begin, int end, const double* speed, int steps,
                 double* rows);
    const char* (*settle_column)(int);  // name of a column, null after the last
    const MachineKernel* machines;      // null with HYPERTUNA_SMALL
};

}  // namespace hypertuna
