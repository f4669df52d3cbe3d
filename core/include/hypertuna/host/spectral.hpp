/// The largest eigenvalue of a matrix, without the others.
#pragma once

#include <algorithm>
#include <cmath>

#include "hypertuna/swimming/periodic.hpp"

namespace hypertuna {

/// Largest modulus of a matrix' eigenvalues. That of A^(2^k) is its 2^k-th power, and nearly the largest element of
/// A^(2^k).
template <int N>
double spectral_radius(Matrix<double, N> m) {
    double power = 0;  // exponent of the power of 2 that was divided out of the matrix, as it acts on the result
    for (double root = 1; 1e-18 < root; root /= 2) {
        double largest = 0, sum = 0;
        for (const auto& row : m.a)
            for (double x : row) largest = std::max(largest, std::abs(x)), sum += x;
        if (!std::isfinite(sum)) return std::nan("");
        if (largest == 0) return 0;
        const int exponent = std::ilogb(largest);
        power += exponent * root;
        const Matrix<double, N> before = m;
        for (int i = 0; i < N; ++i)
            for (int j = 0; j < N; ++j) {
                m.a[i][j] = 0;
                for (int k = 0; k < N; ++k)
                    m.a[i][j] += std::ldexp(before.a[i][k], -exponent) * std::ldexp(before.a[k][j], -exponent);
            }
    }
    return std::exp2(power);
}

}  // namespace hypertuna
