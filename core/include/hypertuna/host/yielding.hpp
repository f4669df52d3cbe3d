/// What the kernels do with a joint that yields: plain numbers in, plain numbers out.
#pragma once

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/swimming/yielding_beat.hpp"

namespace hypertuna {

inline constexpr int yield_state = YieldingState<double, 1>::size;

/// Gaits of a robot whose joint at the front of `link` yields: for each gait stiffness, damping and rest angle of
/// its spring.
struct YieldBatch {
    GaitBatch gaits;
    int link;
    const double* spring;
};

struct YieldKernel {
    /// Settled beats of gaits [begin, end) into rows: the columns by name, then the state at the start, then the
    /// monodromy.
    void (*settle)(const Model&, const YieldBatch&, const SettleOptions&, int begin, int end, double* rows);
    /// Derivatives of one beat, as in Kernel, of 5 + directions numbers; three more rows of `along` are the spring's.
    void (*gradient)(const Model&, const YieldBatch&, const Directions&, int begin, int end, const double* state,
                     int steps, double mass, double* rows);
    /// Angle, rate and acceleration of the joint at `count` instants from a state on, `steps` of them a beat.
    void (*bends)(const Model&, const YieldBatch&, const double* state, int steps, int count, double* out);
    /// Inertia that the straight, free body opposes to the joint, kg m^2.
    double (*reduced_inertia)(const Model&, int hinge);
    const char* (*column)(int);  // name, null after the last
};

}  // namespace hypertuna
