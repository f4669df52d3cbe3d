/// Settled gaits for a host: quantities with names, derivatives by the gait, the path of a beat.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <string_view>

#include "hypertuna/host/beat_gradient.hpp"
#include "hypertuna/host/beat_status.hpp"
#include "hypertuna/host/directions.hpp"
#include "hypertuna/host/tank.hpp"

namespace hypertuna {

extern const Kernel kernel_portable;

/// Largest modulus of the eigenvalues of a real 3 x 3 matrix (row by row), the roots of its characteristic polynomial.
inline double spectral_radius(const double* m) {
    const double trace = m[0] + m[4] + m[8];
    const double minors = m[0] * m[4] - m[1] * m[3] + m[0] * m[8] - m[2] * m[6] + m[4] * m[8] - m[5] * m[7];
    const double det =
        m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
    if (!std::isfinite(trace + minors + det)) return std::nan("");
    // All three roots at once (Durand-Kerner): it converges from any distinct start, quadratically at simple roots.
    using Complex = std::complex<double>;
    const double bound = 1 + std::max({std::abs(trace), std::abs(minors), std::abs(det)});
    Complex root[3] = {bound, bound * Complex(-0.5, 0.8), bound * Complex(-0.4, -0.9)};
    for (int k = 0; k < 100; ++k) {
        double change = 0;
        for (int i = 0; i < 3; ++i) {
            const Complex x = root[i];
            const Complex step =
                (((x - trace) * x + minors) * x - det) / ((x - root[(i + 1) % 3]) * (x - root[(i + 2) % 3]));
            if (!std::isfinite(step.real() + step.imag())) continue;
            root[i] -= step;
            change = std::max(change, std::abs(step));
        }
        if (change < 1e-15 * bound) break;
    }
    return std::max({std::abs(root[0]), std::abs(root[1]), std::abs(root[2])});
}

/// A robot's swimmer: the model, its mass and its length.
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
            const double radius = *at(k, "spectral_radius") = spectral_radius(at(k, "m_00"));
            double& status = *at(k, "status");
            status = int(status_of(status, radius));
        }
    }
    /// Where the column of a name begins in the row of a gait.
    double* at(int gait, std::string_view name) {
        int k = 0;
        while (kernel_portable.settle_column(k) != name) ++k;
        return rows_.data() + std::size_t(gait) * width_ + k;
    }

  private:
    int width_ = 0;
    std::vector<double> rows_;
};

inline void swim(const HostModel& host, const double* gaits, int count, bool follow, double* out) {
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
    std::vector<double> along(std::size_t(parameter_count(host.model)) * numbers);
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
