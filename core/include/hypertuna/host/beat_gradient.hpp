/// Derivatives of settled beats: those of a beat, and of the start that moves so that the beat stays settled.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/swimming/quantities.hpp"

namespace hypertuna {

/// Derivatives (gaits, derivative_count, directions) of gaits [begin, end) whose settled beats start at `momentum`; NaN
/// where they have none.
///
/// One beat in dual numbers gives the derivatives of its end P1 and its quantities by the start P0 and the parameters
/// p. The settled start moves with p so that P1 = P0 stays: dP0/dp = (I - dP1/dP0)^-1 dP1/dp (implicit function
/// theorem).
inline void settled_gradient(const Kernel& kernel, const Model& model, const GaitBatch& gaits,
                             const Directions& directions, int begin, int end, const double* momentum, int steps,
                             double mass, double* derivatives) {
    using State = Momentum<double>;
    const int g = model.groups, n = directions.count, width = State::size + n, count = derivative_count;
    const std::size_t size = std::size_t(count + State::size) * width;  // of a gait's rates
    std::vector<double> rates(std::size_t(end - begin) * size);
    const GaitBatch part{gaits.frequency + begin, gaits.amplitude + begin * g, gaits.phase + begin * g,
                         gaits.bias + begin * g};
    kernel.gradient(model, part, directions, 0, end - begin, momentum + State::size * begin, steps, mass, rates.data());
    for (int gait = begin; gait < end; ++gait) {
        const double *by = rates.data() + std::size_t(gait - begin) * size, *const P = by + count * width;
        double* out = derivatives + std::size_t(gait) * count * n;
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
}

}  // namespace hypertuna
