/// Settled gaits for a host: quantities with names, derivatives by the gait, the path of a beat.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "hypertuna/host/beat_gradient.hpp"
#include "hypertuna/host/beat_status.hpp"
#include "hypertuna/host/directions.hpp"
#include "hypertuna/host/tank.hpp"

namespace hypertuna {

extern const Kernel kernel_portable;

/// Largest modulus of the eigenvalues of a matrix: that of A^(2^k) is its 2^k-th power, and nearly its largest number.
template <int N>
double spectral_radius(Matrix<double, N> m) {
    double power = 0;  // of 2, by which the root of A^(2^k) is larger than that of m
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

/// A robot's swimmer: the model, and the mass of the whole body.
struct HostModel {
    Model model;
    double mass;  // kg
};

/// A quantity of a settled gait: those of the core, its status, and how a start from rest comes to it; null after them.
inline const QuantityAbout* quantity(int k) {
    constexpr int count = std::size(quantities<double>);
    static constexpr QuantityAbout more[] = {
        {"status", "", "status", "how the search ended, of the statuses", Shown::data, Better::neither, false},
        {"arrived", "", "arrived", "1 where a start from rest leads to this beat", Shown::data, Better::neither, false},
        {"approach_beats", "", "beats from rest", "beats of that start", Shown::data, Better::neither, false}};
    if (k < 0 || count + int(std::size(more)) <= k) return nullptr;
    return k < count ? &quantities<double>[k].about : &more[k - count];
}

/// Place of a name among those that `name(k)` gives.
template <class Name>
int place_of(std::string_view wanted, const Name& name) {
    int k = 0;
    while (name(k) != wanted) ++k;
    return k;
}

/// Gaits (count, 1 + 3 groups) as the kernel takes them.
struct GaitColumns {
    std::vector<double> frequency, kind[3];

    GaitColumns(const double* rows, int count, int groups) {
        for (int k = 0; k < count; ++k, rows += gait_parameters(groups)) {
            frequency.push_back(rows[0]);
            for (int i = 0; i < 3; ++i)
                kind[i].insert(kind[i].end(), rows + 1 + i * groups, rows + 1 + (i + 1) * groups);
        }
    }
    GaitBatch batch() const { return {frequency.data(), kind[0].data(), kind[1].data(), kind[2].data()}; }
};

/// Rows of the kernel for gaits.
class SettledRows {
  public:
    SettledRows(const HostModel& host, const GaitBatch& gaits, int count, bool follow) {
        while (kernel_portable.settle_column(width_)) ++width_;
        rows_.resize(std::size_t(count) * width_);
        const int approach = follow ? approach_beats : 0;
        kernel_portable.settle(host.model, gaits, {beat_steps, -1, newton_beats, -1, approach, host.mass}, 0, count,
                               rows_.data());
        for (int k = 0; k < count; ++k) {
            Matrix<double, Momentum<double>::size> monodromy;
            std::memcpy(&monodromy, at(k, "m_00"), sizeof(monodromy));
            const double radius = *at(k, "spectral_radius") = spectral_radius(monodromy);
            double& status = *at(k, "status");
            status = int(status_of(status, radius));
        }
    }
    /// Where the column of a name begins in the row of a gait.
    double* at(int gait, std::string_view name) {
        return rows_.data() + std::size_t(gait) * width_ + place_of(name, kernel_portable.settle_column);
    }

  private:
    int width_ = 0;
    std::vector<double> rows_;
};

inline void swim_rows(const HostModel& host, const double* gaits, int count, bool follow, double* out) {
    const GaitColumns columns(gaits, count, host.model.groups);
    SettledRows rows(host, columns.batch(), count, follow);
    for (int k = 0; k < count; ++k)
        for (int i = 0; quantity(i); ++i) *out++ = *rows.at(k, quantity(i)->name);
}

/// Derivatives (those of the core, 1 + 3 groups) of a settled gait by its numbers.
inline void gait_gradient(const HostModel& host, const double* gait, double* out) {
    const int numbers = gait_parameters(host.model.groups);
    const GaitColumns columns(gait, 1, host.model.groups);
    SettledRows rows(host, columns.batch(), 1, false);
    const BeatStatus status = BeatStatus(int(*rows.at(0, "status")));
    const bool periodic = status == BeatStatus::settled || status == BeatStatus::unstable;
    if (!periodic || !std::isfinite(*rows.at(0, "speed"))) {
        std::fill_n(out, derivative_count * numbers, std::nan(""));
        return;
    }
    std::vector<double> along(std::size_t(beat_rows(host.model)) * numbers);
    for (int i = 0; i < numbers; ++i) along[std::size_t(i) * numbers + i] = 1;
    settled_gradient(kernel_portable, host.model, columns.batch(),
                     sort_directions(host.model, along.data(), numbers, true), 0, 1, rows.at(0, "p_x"), beat_steps,
                     host.mass, out);
}

// --- the path of a beat

/// Rows of time, pose of the nose, and the bend of every link's front joint: steps + 1 of them over a settled beat.
inline void path(const HostModel& host, const double* gait, int steps, double* out) {
    const Model& model = host.model;
    const GaitColumns columns(gait, 1, model.groups);
    SettledRows rows(host, columns.batch(), 1, false);
    const double* const start = rows.at(0, "p_x");
    with_law<double>(model.law, [&](auto law) {
        Tank<double, typename decltype(law)::type> tank(model, steps);
        std::copy(gait, gait + gait_parameters(model.groups), tank.parameters.begin());
        tank.fill();
        std::vector<JointMotion<double>> joints(model.links);
        Motion<double> motion{{start[0], start[1], start[2]}, {0, 0, 0}};
        const double step = 1 / (gait[0] * steps);
        for (int k = 0; k <= steps; ++k) {
            joint_motion(model.links, tank.joints.data(), tank.swings.data(), gait[0], sincos(2 * pi * k / steps),
                         joints.data());
            for (double number : {k * step, motion.pose.x, motion.pose.y, motion.pose.heading}) *out++ = number;
            for (const JointMotion<double>& joint : joints) *out++ = joint.angle;
            if (k < steps) motion = swim_step(tank.fish, tank.table, 2 * k, 1, step, motion);
        }
    });
}

}  // namespace hypertuna
