/// Settled gaits for a host: quantities with names, derivatives with respect to the gait, and the path of a beat.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "hypertuna/host/beat_gradient.hpp"
#include "hypertuna/host/beat_status.hpp"
#include "hypertuna/host/directions.hpp"
#include "hypertuna/host/spring_steps.hpp"
#include "hypertuna/host/tank.hpp"

namespace hypertuna {

extern const Kernel kernel_portable;
extern const YieldKernel kernel_portable_yielding;

/// A robot's swimmer: the model, the mass of the whole body, and the hinges that yield.
struct HostModel {
    Model model;
    double mass;              // kg
    std::vector<int> hinges;  // links behind the hinges, head to tail
    std::vector<Spring<double>> springs;
    SpringRates rates;

    YieldBatch yielding(const GaitBatch& gaits, std::vector<Spring<double>>& each, int count) const {
        each.clear();
        for (int k = 0; k < count; ++k) each.insert(each.end(), springs.begin(), springs.end());
        return {gaits, hinges.data(), int(hinges.size()), &each.data()->stiffness};
    }
    int state() const { return yield_state(int(hinges.size())); }
    int steps(double frequency) const {
        return hinges.empty() ? beat_steps : spring_steps(rates, frequency, beat_steps);
    }
};

/// Description of quantity k of a settled gait: first the core's quantities, then the status and the start from rest;
/// null after the last.
inline const QuantityAbout* quantity(int k) {
    constexpr int count = std::size(quantities<double>);
    static constexpr QuantityAbout more[] = {
        {"status", "", "status", "how the search ended, of the statuses", Shown::data, Better::neither, false},
        {"arrived", "", "arrived", "1 where a start from rest leads to this beat", Shown::data, Better::neither, false},
        {"approach_beats", "", "beats from rest", "beats of that start", Shown::data, Better::neither, false}};
    if (k < 0 || count + int(std::size(more)) <= k) return nullptr;
    return k < count ? &quantities<double>[k].about : &more[k - count];
}

/// Index k at which `name(k)` is the wanted name.
template <class Name>
int place_of(std::string_view wanted, const Name& name) {
    int k = 0;
    while (name(k) != wanted) ++k;
    return k;
}

/// Gaits (count, 1 + 3 groups), split into the columns that the kernel takes.
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

/// Call work(std::integral_constant) with the size of a state.
template <class Work>
void with_state(int size, const Work& work) {
    if (size == yield_state(0)) work(std::integral_constant<int, yield_state(0)>());
    with_hinges((size - 3) / 2, [&](auto D) { work(std::integral_constant<int, yield_state(D.value)>()); });
}

/// The kernel's rows for gaits, with spectral radius and status completed.
class SettledRows {
  public:
    SettledRows(const HostModel& host, const GaitColumns& gaits, int count, bool follow)
        : named_(place_of("p_x", kernel_portable.settle_column)), size_(host.state()) {
        const int hinges = int(host.hinges.size());
        width_ = hinges ? kernel_portable_yielding.row_width(hinges) : named_ + size_ * (1 + size_);
        rows_.resize(std::size_t(count) * width_, std::nan(""));
        std::vector<Spring<double>> springs;
        for (int first = 0, end; first < count; first = end) {
            const int steps = host.steps(gaits.frequency[first]);
            for (end = first + 1; end < count && host.steps(gaits.frequency[end]) == steps;) ++end;
            const SettleOptions options{steps, -1, newton_beats, -1, follow ? approach_beats : 0, host.mass};
            if (steps == 0)  // no steps follow the springs
                for (int k = first; k < end; ++k) *at(k, "status") = int(BeatStatus::unresolved);
            else if (hinges)
                kernel_portable_yielding.settle(host.model, host.yielding(gaits.batch(), springs, count), options,
                                                first, end, rows_.data());
            else
                kernel_portable.settle(host.model, gaits.batch(), options, first, end, rows_.data());
        }
        for (int k = 0; k < count; ++k) {
            double& radius = *at(k, "spectral_radius");
            with_state(size_, [&](auto N) {
                Matrix<double, N.value> monodromy;
                std::memcpy(&monodromy, state(k) + N.value, sizeof(monodromy));
                radius = spectral_radius(monodromy);
            });
            double& status = *at(k, "status");
            status = int(status_of(status, radius));
        }
    }
    /// The named column in a gait's row; `state` is the state at the start of the gait's beat.
    double* at(int gait, std::string_view name) { return row(gait) + place_of(name, kernel_portable.settle_column); }
    const double* state(int gait) { return row(gait) + named_; }

  private:
    double* row(int gait) { return rows_.data() + std::size_t(gait) * width_; }

    int named_, size_, width_ = 0;
    std::vector<double> rows_;
};

inline void swim_rows(const HostModel& host, const double* gaits, int count, bool follow, double* out) {
    const GaitColumns columns(gaits, count, host.model.groups);
    SettledRows rows(host, columns, count, follow);
    for (int k = 0; k < count; ++k)
        for (int i = 0; quantity(i); ++i) *out++ = *rows.at(k, quantity(i)->name);
}

/// Derivatives (differentiable quantities, 1 + 3 groups) of a settled gait's quantities with respect to the gait's
/// numbers.
inline void gait_gradient(const HostModel& host, const double* gait, double* out) {
    const int numbers = gait_parameters(host.model.groups), steps = host.steps(gait[0]);
    const GaitColumns columns(gait, 1, host.model.groups);
    SettledRows rows(host, columns, 1, false);
    const BeatStatus status = BeatStatus(int(*rows.at(0, "status")));
    const bool periodic = status == BeatStatus::settled || status == BeatStatus::unstable;
    if (!periodic || !std::isfinite(*rows.at(0, "speed"))) {
        std::fill_n(out, derivative_count * numbers, std::nan(""));
        return;
    }
    std::vector<double> along((beat_rows(host.model) + spring_numbers * host.springs.size()) * numbers);
    for (int i = 0; i < numbers; ++i) along[std::size_t(i) * numbers + i] = 1;
    if (host.hinges.empty())
        return settled_gradient(kernel_portable, host.model, columns.batch(),
                                sort_directions(host.model, along.data(), numbers, true), 0, 1, rows.state(0), steps,
                                host.mass, out);
    std::vector<Spring<double>> springs;
    std::vector<double> by(std::size_t(derivative_count + host.state()) * (host.state() + numbers));
    kernel_portable_yielding.gradient(host.model, host.yielding(columns.batch(), springs, 1),
                                      {along.data(), numbers, {}, {}}, 0, 1, rows.state(0), steps, host.mass,
                                      by.data());
    with_hinges(int(host.hinges.size()),
                [&](auto D) { with_moving_start<YieldingState<double, D.value>>(by.data(), numbers, out); });
}

// --- the path of a beat

/// Angle, rate and acceleration of the hinges at `instants` equal parts of a settled beat that starts in a state.
inline std::vector<double> hinge_motion(const HostModel& host, const GaitBatch& gait, const double* state,
                                        int instants) {
    const int hinges = int(host.hinges.size());
    int finer = 1;
    while (finer * instants < host.steps(*gait.frequency)) finer *= 2;
    std::vector<Spring<double>> springs;
    std::vector<double> all(std::size_t(finer * instants + 1) * 3 * hinges), out;
    kernel_portable_yielding.bends(host.model, host.yielding(gait, springs, 1), state, finer * instants,
                                   finer * instants + 1, all.data());
    for (std::size_t k = 0; k < all.size(); k += std::size_t(finer) * 3 * hinges)
        out.insert(out.end(), all.begin() + k, all.begin() + k + 3 * hinges);
    return out;
}

/// Write steps + 1 rows over a settled beat: time, pose of the nose, and the bend of every link's front joint.
inline void path(const HostModel& host, const double* gait, int steps, double* out) {
    const Model& model = host.model;
    const int hinges = int(host.hinges.size());
    const GaitColumns columns(gait, 1, model.groups);
    SettledRows rows(host, columns, 1, false);
    const double* const start = rows.state(0);
    std::vector<double> bends;
    if (hinges) bends = hinge_motion(host, columns.batch(), start, 2 * steps);
    with_law<double>(model.law, [&](auto law) {
        Tank<double, typename decltype(law)::type> tank(model, steps);
        std::copy(gait, gait + gait_parameters(model.groups), tank.parameters.begin());
        tank.read();
        std::vector<JointMotion<double>> joints(model.links);
        const auto set_joints = [&](int half) {
            joint_motion(model.links, tank.joints.data(), tank.swings.data(), gait[0], sincos(pi * half / steps),
                         joints.data());
            const double* bend = bends.data() + std::size_t(half) * 3 * hinges;
            for (int link : host.hinges) {
                joints[link].angle += *bend++;
                joints[link].rate += *bend++;
                joints[link].acceleration += *bend++;
            }
        };
        for (int half = 0; half < 2 * steps; ++half)
            set_joints(half), tabulate(tank.fish, joints.data(), half, tank.table);
        Motion<double> motion{{start[0], start[1], start[2]}, {0, 0, 0}};
        const double step = 1 / (gait[0] * steps);
        for (int k = 0; k <= steps; ++k) {
            set_joints(2 * k);
            for (double number : {k * step, motion.pose.x, motion.pose.y, motion.pose.heading}) *out++ = number;
            for (const JointMotion<double>& joint : joints) *out++ = joint.angle;
            if (k < steps) motion = swim_step(tank.fish, tank.table, 2 * k, 1, step, motion);
        }
    });
}

}  // namespace hypertuna
