/// Derivatives of settled beats: those of one beat from a fixed start, plus the effect of the start's own motion, which
/// keeps the beat settled.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/swimming/quantities.hpp"

namespace hypertuna {

/// Derivatives `out` of a settled beat's quantities along n directions, from the derivatives `by` of one beat: a row of
/// State::size + n numbers for each quantity and each number of the state at the end, with respect to the state at the
/// start and along the directions.
///
/// The settled start P0 moves with the parameters p so that the end P1 = P0 stays: dP0/dp = (I - dP1/dP0)^-1 dP1/dp
/// (implicit function theorem). NaN where the equations do not determine the start.
template <class State>
void with_moving_start(const double* by, int n, double* out) {
    const int width = State::size + n, count = derivative_count;
    const double* const P = by + count * width;
    Matrix<double, State::size> remains;
    for (int i = 0; i < State::size; ++i)
        for (int j = 0; j < State::size; ++j) remains.a[i][j] = (i == j) - P[i * width + j];
    for (int j = 0; j < n; ++j) {
        State start;
        for (int i = 0; i < State::size; ++i) component(start, i) = P[i * width + State::size + j];
        start = solve(remains, start);
        for (int k = 0; k < count; ++k) {
            double sum = by[k * width + State::size + j];
            for (int i = 0; i < State::size; ++i) sum += by[k * width + i] * component(start, i);
            out[k * n + j] = std::isfinite(sum) ? sum : std::numeric_limits<double>::quiet_NaN();
        }
    }
}

/// Derivatives (gaits, derivative_count, directions) of gaits [begin, end) whose settled beats start at `momentum`; NaN
/// where they have none.
inline void settled_gradient(const Kernel& kernel, const Model& model, const GaitBatch& gaits,
                             const Directions& directions, int begin, int end, const double* momentum, int steps,
                             double mass, double* derivatives) {
    using State = Momentum<double>;
    const int g = model.groups, n = directions.count, width = State::size + n, count = derivative_count;
    const std::size_t size = std::size_t(count + State::size) * width;  // numbers of one gait's derivatives
    std::vector<double> rates(std::size_t(end - begin) * size);
    const GaitBatch part{gaits.frequency + begin, gaits.amplitude + begin * g, gaits.phase + begin * g,
                         gaits.bias + begin * g};
    kernel.gradient(model, part, directions, 0, end - begin, momentum + State::size * begin, steps, mass, rates.data());
    for (int gait = begin; gait < end; ++gait)
        with_moving_start<State>(rates.data() + std::size_t(gait - begin) * size, n,
                                 derivatives + std::size_t(gait) * count * n);
}

}  // namespace hypertuna
