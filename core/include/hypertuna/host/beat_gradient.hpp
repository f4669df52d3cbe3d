/// Derivatives of settled beats: those of a beat, and of the start that moves so that the beat stays settled.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "hypertuna/host/kernels.hpp"
#include "hypertuna/swimming/quantities.hpp"

namespace hypertuna {

/// Solve a x = b for n right-hand sides (3, n) by Gauss with pivots; false where a is singular.
inline bool solve3(double (&a)[3][3], double* b, int n) {
    for (int k = 0; k < 3; ++k) {
        int pivot = k;
        for (int i = k + 1; i < 3; ++i)
            if (std::abs(a[pivot][k]) < std::abs(a[i][k])) pivot = i;
        if (!(0 < std::abs(a[pivot][k]))) return false;
        std::swap(a[k], a[pivot]);
        std::swap_ranges(b + k * n, b + (k + 1) * n, b + pivot * n);
        for (int i = 0; i < 3; ++i) {
            if (i == k) continue;
            const double factor = a[i][k] / a[k][k];
            for (int j = k; j < 3; ++j) a[i][j] -= factor * a[k][j];
            for (int j = 0; j < n; ++j) b[i * n + j] -= factor * b[k * n + j];
        }
    }
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < n; ++j) b[k * n + j] /= a[k][k];
    return true;
}

/// Derivatives (gaits, derivative_count, directions) of gaits [begin, end) whose settled beats start at `momentum`; NaN
/// where they have none.
///
/// One beat in dual numbers gives the derivatives of its end P1 and its quantities by the start P0 and the parameters
/// p. The settled start moves with p so that P1 = P0 stays: dP0/dp = (I - dP1/dP0)^-1 dP1/dp (implicit function
/// theorem).
inline void settled_gradient(const Kernel& kernel, const Model& model, const GaitBatch& gaits,
                             const Directions& directions, int begin, int end, const double* momentum, int steps,
                             double mass, double* derivatives) {
    const int g = model.groups, n = directions.count, width = 3 + n, count = derivative_count;
    const std::size_t size = std::size_t(count + 3) * width;  // of a gait's rates
    std::vector<double> rates(std::size_t(end - begin) * size), start(3 * std::size_t(n));
    const GaitBatch part{gaits.frequency + begin, gaits.amplitude + begin * g, gaits.phase + begin * g,
                         gaits.bias + begin * g};
    kernel.gradient(model, part, directions, 0, end - begin, momentum + 3 * begin, steps, mass, rates.data());
    for (int gait = begin; gait < end; ++gait) {
        const double *by = rates.data() + std::size_t(gait - begin) * size, *const P = by + count * width;
        double* out = derivatives + std::size_t(gait) * count * n;
        double remains[3][3];
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) remains[i][j] = (i == j) - P[i * width + j];
            std::copy(P + i * width + 3, P + (i + 1) * width, start.begin() + i * n);
        }
        if (!solve3(remains, start.data(), n)) {
            std::fill_n(out, count * n, std::numeric_limits<double>::quiet_NaN());
            continue;
        }
        for (int k = 0; k < count; ++k, by += width)
            for (int j = 0; j < n; ++j)
                *out++ = by[3 + j] + by[0] * start[j] + by[1] * start[n + j] + by[2] * start[2 * n + j];
    }
}

}  // namespace hypertuna
