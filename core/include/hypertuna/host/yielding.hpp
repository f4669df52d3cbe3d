/// What the kernels do with joints that yield: plain numbers in, plain numbers out.
#pragma once

#include <type_traits>

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/swimming/yielding_beat.hpp"

namespace hypertuna {

inline constexpr int max_hinges = 3;  // largest number of hinges that is compiled

/// Call work(std::integral_constant) with a number of hinges.
template <class Work>
void with_hinges(int count, const Work& work) {
    if (count == 1) work(std::integral_constant<int, 1>());
    if (count == 2) work(std::integral_constant<int, 2>());
    if (count == 3) work(std::integral_constant<int, 3>());
}
inline constexpr int yield_state(int hinges) { return 3 + 2 * hinges; }  // size of the state
inline constexpr int yield_swings(int hinges) { return 5 * hinges; }

/// Gaits of a robot whose joints at the fronts of `links` yield, head to tail: for each gait the numbers of each
/// spring.
struct YieldBatch {
    GaitBatch gaits;
    const int* links;
    int hinges;
    const double* spring;
};

struct YieldKernel {
    /// Compute the settled beats of gaits [begin, end), one row each: the named columns of Kernel, the state at the
    /// start, the monodromy, then for each hinge mean, sine, cosine and peak of its swing, and the mean power of its
    /// damper.
    void (*settle)(const Model&, const YieldBatch&, const SettleOptions&, int begin, int end, double* rows);
    /// Derivatives of one beat, as in Kernel, of yield_state + directions numbers; the last rows of `along` are the
    /// springs'.
    void (*gradient)(const Model&, const YieldBatch&, const Directions&, int begin, int end, const double* state,
                     int steps, double mass, double* rows);
    /// Angle, rate and acceleration of each hinge at `count` instants from a state on, `steps` of them a beat.
    void (*bends)(const Model&, const YieldBatch&, const double* state, int steps, int count, double* out);
    /// Inertia that the straight, free body opposes to hinges that turn alike, kg m^2.
    double (*reduced_inertia)(const Model&, const int* links, int hinges);
    int (*row_width)(int hinges);  // numbers in a row that `settle` writes
};

}  // namespace hypertuna
