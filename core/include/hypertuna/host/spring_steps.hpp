/// How many steps of a beat follow springs, whose motion may be faster than the beat's.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "hypertuna/host/spectral.hpp"
#include "hypertuna/host/yielding.hpp"

namespace hypertuna {

inline constexpr int most_spring_steps = 1024;  // of a beat, that a stiff spring may ask for by itself
inline constexpr double stable_steps = 2.3;     // for each radian of a spring's fastest motion: RK4's limit
inline constexpr double accurate_steps = 20.0;  // for each 1/e of its fastest decay: powers then balance to 1.3e-3
inline constexpr double bent = 0.5;             // rad from rest, up to which steps follow a spring without stops
inline constexpr double compressed = 0.1;       // rad beyond a stop, up to which steps follow its dissipation

/// Inertia that the free, straight body opposes to its hinges, row by row, kg m^2.
inline std::vector<double> hinge_inertia(const YieldKernel& kernel, const Model& model, const int* links, int hinges) {
    std::vector<double> inertia(hinges * hinges);
    for (int i = 0; i < hinges; ++i) inertia[i * hinges + i] = kernel.reduced_inertia(model, links + i, 1);
    for (int i = 0; i < hinges; ++i)
        for (int k = 0; k < i; ++k) {
            const int pair[] = {links[k], links[i]};  // which turn alike: their own inertias, and twice the coupling
            const double both = kernel.reduced_inertia(model, pair, 2);
            const double own = inertia[i * hinges + i] + inertia[k * hinges + k];
            inertia[i * hinges + k] = inertia[k * hinges + i] = (both - own) / 2;
        }
    return inertia;
}

/// Rates at which hinges swing in the free, straight body, 1/s.
struct SpringRates {
    double fastest;  // largest modulus of an eigenvalue
    double decay;    // largest negative real part
};

/// Matrix of the motion y' = A y of hinges, y their angles and their rates over `unit` [1/s], over that unit.
template <int D>
Matrix<double, 2 * D> spring_motion(const double* inertia, const double* stiffness, const double* damping,
                                    double unit) {
    Matrix<double, 2 * D> a{};
    for (int i = 0; i < D; ++i) a.a[i][D + i] = 1;
    for (int j = 0; j < D; ++j) {
        double m[D][D], column[D]{};  // of the inverse inertia
        std::copy(inertia, inertia + D * D, &m[0][0]);
        column[j] = 1;
        solve_positive(m, column);
        for (int i = 0; i < D; ++i) {
            a.a[D + i][j] = -column[i] * stiffness[j] / (unit * unit);
            a.a[D + i][D + j] = -column[i] * damping[j] / unit;
        }
    }
    return a;
}

/// Rates of springs and dampers, N m/rad and N m s/rad. The decay is that of exp(-A t), whose largest eigenvalue is
/// exp(decay t).
template <int D>
SpringRates spring_rates(const double* inertia, const double* stiffness, const double* damping) {
    constexpr int n = 2 * D;
    const double fastest = spectral_radius(spring_motion<D>(inertia, stiffness, damping, 1));
    if (!(0 < fastest)) return {fastest, 0};
    const Matrix<double, n> a = spring_motion<D>(inertia, stiffness, damping, fastest);
    Matrix<double, n> sum{}, term{};
    for (int i = 0; i < n; ++i) sum.a[i][i] = term.a[i][i] = 1;
    for (int k = 1; k < 60; ++k) {  // Taylor's series
        Matrix<double, n> next{};
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                for (int l = 0; l < n; ++l) next.a[i][j] -= term.a[i][l] * a.a[l][j] / k;
        term = next;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) sum.a[i][j] += term.a[i][j];
    }
    return {fastest, fastest * std::log(spectral_radius(sum))};
}

/// Rates of the hinges of a model; stops ask for as many steps as a decay as fast as they swing.
inline SpringRates spring_rates(const YieldKernel& kernel, const Model& model, const std::vector<int>& links,
                                const std::vector<Spring<double>>& springs) {
    const int hinges = int(links.size());
    const std::vector<double> inertia = hinge_inertia(kernel, model, links.data(), hinges);
    std::vector<double> stiffness, damping;  // where moments rise the fastest
    bool stops = false;
    for (const Spring<double>& spring : springs) {
        const bool stopped = 0 < spring.stop_stiffness;
        const double far = stopped ? spring.stop + std::abs(spring.rest) : bent;
        stiffness.push_back(spring.stiffness + 3 * spring.cubic * far * far + spring.stop_stiffness);
        damping.push_back(spring.damping + spring.stop_dissipation * compressed);
        stops |= stopped;
    }
    SpringRates rates{};
    with_hinges(hinges,
                [&](auto D) { rates = spring_rates<D.value>(inertia.data(), stiffness.data(), damping.data()); });
    return {rates.fastest, std::max(rates.decay, stops ? rates.fastest : 0.0)};
}

/// Steps of a beat of some frequency [Hz] that follow the springs: `steps`, doubled until half of them do; 0 if not
/// even the most do. Decays get more steps, as far as there are, so that powers of dampers are accurate.
inline int spring_steps(const SpringRates& rates, double frequency, int steps) {
    const double beat = 2 * pi * frequency, needed = 2 * stable_steps * rates.fastest / beat;
    const double most = std::max(steps, most_spring_steps);
    if (!(needed <= most)) return 0;
    while (steps < std::max(needed, std::min(accurate_steps * rates.decay / beat, most))) steps *= 2;
    return steps;
}

}  // namespace hypertuna
