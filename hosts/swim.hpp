/// Settled gaits for a host: quantities with names, derivatives by the gait, the path of a beat.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <string_view>

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

/// A settled beat: a row of the kernel as numbers with names.
struct SettledBeat {
    double speed, turn, radius, excursion, power, power_positive, loss, towed_power, torque_peak, rate_peak;
    double residual, distance, beats, approach, approach_beats;
    double momentum[3];      // at the start
    double spectral_radius;  // of the monodromy
};
inline constexpr std::pair<const char*, double SettledBeat::*> settled_fields[] = {
    {"speed", &SettledBeat::speed},
    {"turn", &SettledBeat::turn},
    {"radius", &SettledBeat::radius},
    {"excursion", &SettledBeat::excursion},
    {"power", &SettledBeat::power},
    {"power_positive", &SettledBeat::power_positive},
    {"loss", &SettledBeat::loss},
    {"towed_power", &SettledBeat::towed_power},
    {"torque_peak", &SettledBeat::torque_peak},
    {"rate_peak", &SettledBeat::rate_peak},
    {"residual", &SettledBeat::residual},
    {"distance", &SettledBeat::distance},
    {"beats", &SettledBeat::beats},
    {"approach", &SettledBeat::approach},
    {"approach_beats", &SettledBeat::approach_beats},
};

/// Rows of the kernel for gaits.
class SettledRows {
  public:
    SettledRows(const Model& model, const GaitBatch& gaits, int count, bool follow) {
        while (kernel_portable.settle_column(width_)) ++width_;
        std::transform(std::begin(settled_fields), std::end(settled_fields), places_,
                       [](const auto& field) { return find(field.first); });
        momentum_ = find("p_x");
        monodromy_ = find("m_00");
        rows_.resize(std::size_t(count) * width_);
        kernel_portable.settle(model, gaits, {beat_steps, -1, newton_beats, -1, follow ? approach_beats : 0}, 0, count,
                               rows_.data());
    }
    SettledBeat operator[](int k) const {
        const double* const row = rows_.data() + std::size_t(k) * width_;
        SettledBeat beat;
        const int* place = places_;
        for (const auto& [name, field] : settled_fields) beat.*field = row[*place++];
        std::copy(row + momentum_, row + momentum_ + 3, beat.momentum);
        beat.spectral_radius = spectral_radius(row + monodromy_);
        return beat;
    }

  private:
    static int find(std::string_view name) {
        int k = 0;
        while (kernel_portable.settle_column(k) != name) ++k;
        return k;
    }

    int width_ = 0, momentum_, monodromy_;
    int places_[std::size(settled_fields)];  // of each field in a row
    std::vector<double> rows_;
};

/// A robot's swimmer: the model, its mass and its length.
struct HostModel {
    Model model;
    double mass;  // kg
};

inline BeatStatus status_of(const SettledBeat& beat) {
    const bool finite = std::isfinite(beat.turn + beat.power + beat.loss + beat.residual) &&
                        (std::isfinite(beat.speed + beat.excursion) || spins(beat.turn));
    if (!finite) return BeatStatus::diverged;
    if (!(beat.distance < kernel_portable.settled_distance)) return BeatStatus::unsettled;
    return neutral < beat.spectral_radius ? BeatStatus::unstable : BeatStatus::settled;
}

/// A quantity of a settled gait at a frequency.
struct HostQuantity {
    const char* name;
    double (*of)(const SettledBeat& beat, const HostModel& host, double frequency);
};

#define HYPERTUNA_QUANTITY(name, value)                                                     \
    {name, [](const SettledBeat& beat, const HostModel& host, double frequency) -> double { \
         const double speed = beat.speed, weight = host.mass * std::abs(speed);             \
         return (void)host, (void)frequency, (void)speed, (void)weight, value;              \
     }}
inline constexpr HostQuantity quantities[] = {
    HYPERTUNA_QUANTITY("status", double(int(status_of(beat)))),
    HYPERTUNA_QUANTITY("speed", speed),
    HYPERTUNA_QUANTITY("speed_bl", speed / host.model.length),
    HYPERTUNA_QUANTITY("mechanical_power", beat.power),
    HYPERTUNA_QUANTITY("mechanical_power_positive", beat.power_positive),
    HYPERTUNA_QUANTITY("power_to_water", beat.loss),
    HYPERTUNA_QUANTITY("cost_of_transport", beat.power / weight),
    HYPERTUNA_QUANTITY("cost_of_transport_positive", beat.power_positive / weight),
    HYPERTUNA_QUANTITY("efficiency", beat.power > 0 ? beat.towed_power / beat.power : std::nan("")),
    HYPERTUNA_QUANTITY("strouhal", frequency* beat.excursion / std::abs(speed)),
    HYPERTUNA_QUANTITY("stride_length", speed / (frequency * host.model.length)),
    HYPERTUNA_QUANTITY("tail_excursion", beat.excursion),
    HYPERTUNA_QUANTITY("torque_peak", beat.torque_peak),
    HYPERTUNA_QUANTITY("rate_peak", beat.rate_peak),
    HYPERTUNA_QUANTITY("turn_rate", beat.turn* frequency),
    HYPERTUNA_QUANTITY("turn_radius", straight* host.model.length <= beat.radius ? HUGE_VAL : beat.radius),
    HYPERTUNA_QUANTITY("spectral_radius", beat.spectral_radius),
    HYPERTUNA_QUANTITY("change_per_beat", beat.residual),
    HYPERTUNA_QUANTITY("distance_to_settled", beat.distance),
    HYPERTUNA_QUANTITY("beats", beat.beats),
    HYPERTUNA_QUANTITY("arrived", double(beat.approach < kernel_portable.arrived_distance)),
    HYPERTUNA_QUANTITY("approach_beats", beat.approach_beats),
};
#undef HYPERTUNA_QUANTITY
inline constexpr int quantity_count = sizeof(quantities) / sizeof(quantities[0]);

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

inline void swim(const HostModel& host, const double* gaits, int count, bool follow, double* out) {
    const GaitColumns columns(gaits, count, host.model.groups);
    const SettledRows rows(host.model, columns.batch(), count, follow);
    for (int k = 0; k < count; ++k) {
        const SettledBeat beat = rows[k];
        for (const HostQuantity& quantity : quantities) *out++ = quantity.of(beat, host, columns.frequency[k]);
    }
}

// --- derivatives

/// A derivative that the kernel has under a name of its own, or a quantity over the speed that has none.
struct HostDerivative {
    const char *name, *output;
};
inline constexpr HostDerivative derivatives[] = {
    {"speed", "speed"},
    {"mechanical_power", "power"},
    {"mechanical_power_positive", "power_positive"},
    {"power_to_water", "loss"},
    {"torque_peak", "torque_peak"},
    {"rate_peak", "rate_peak"},
    {"tail_excursion", "excursion"},
    {"cost_of_transport", nullptr},
    {"cost_of_transport_positive", nullptr},
    {"strouhal", nullptr},
};
inline constexpr int derivative_count = sizeof(derivatives) / sizeof(derivatives[0]);

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

/// Derivatives (derivative_count, 1 + 3 groups) of a settled gait by its numbers.
///
/// One beat in dual numbers gives the derivatives of its end P1 and its results by the start P0 and the gait p. The
/// settled start moves with p so that P1 = P0 stays: dP0/dp = (I - dP1/dP0)^-1 dP1/dp.
inline void gait_gradient(const HostModel& host, const double* gait, double* out) {
    const Model& model = host.model;
    const int numbers = gait_parameters(model.groups), width = 3 + numbers;
    const GaitColumns columns(gait, 1, model.groups);
    const SettledBeat beat = SettledRows(model, columns.batch(), 1, false)[0];
    std::vector<double> along(std::size_t(parameter_count(model)) * numbers);
    for (int i = 0; i < numbers; ++i) along[std::size_t(i) * numbers + i] = 1;
    int outputs = 0;
    while (kernel_portable.gradient_output(outputs)) ++outputs;
    std::vector<double> rates(std::size_t(outputs) * width);
    kernel_portable.gradient(model, columns.batch(), sort_directions(model, along.data(), numbers, true), 0, 1,
                             beat.momentum, beat_steps, rates.data());
    const auto rate = [&](std::string_view name) {
        int k = 0;
        while (kernel_portable.gradient_output(k) != name) ++k;
        return rates.data() + std::size_t(k) * width;
    };
    double remains[3][3];
    std::vector<double> start(3 * std::size_t(numbers));
    const double* const end = rate("end_p_x");
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) remains[i][j] = (i == j) - end[i * width + j];
        std::copy(end + i * width + 3, end + (i + 1) * width, start.begin() + i * numbers);
    }
    const BeatStatus found = status_of(beat);
    const bool periodic = found == BeatStatus::settled || found == BeatStatus::unstable;
    const double speed = beat.speed;
    if (!periodic || !std::isfinite(speed) || !solve3(remains, start.data(), numbers)) {
        std::fill(out, out + derivative_count * numbers, std::nan(""));
        return;
    }
    const auto total = [&](std::string_view name, int j) {
        const double* const by = rate(name);
        double sum = by[3 + j];
        for (int i = 0; i < 3; ++i) sum += by[i] * start[i * numbers + j];
        return sum;
    };
    const double frequency = gait[0], weight = host.mass * std::abs(speed);
    // d(a / |U|) = da / |U| - a / |U| dU / U
    const auto over_speed = [&](double change, double value, int j) {
        return change - value * total("speed", j) / speed;
    };
    for (const auto& [derivative, output] : derivatives)
        for (int j = 0; j < numbers; ++j) {
            const std::string_view name = derivative;
            if (output)
                *out++ = total(output, j);
            else if (name == "strouhal")
                *out++ = over_speed(((j == 0) * beat.excursion + frequency * total("excursion", j)) / std::abs(speed),
                                    frequency * beat.excursion / std::abs(speed), j);
            else {
                const bool all = name == "cost_of_transport";
                const double power = all ? beat.power : beat.power_positive;
                *out++ = over_speed(total(all ? "power" : "power_positive", j) / weight, power / weight, j);
            }
        }
}

// --- the path of a beat

/// Rows of time, pose of the nose, and the bend of every link's front joint: steps + 1 of them over a settled beat.
inline void path(const HostModel& host, const double* gait, int steps, double* out) {
    const Model& model = host.model;
    const GaitColumns columns(gait, 1, model.groups);
    const SettledBeat beat = SettledRows(model, columns.batch(), 1, false)[0];
    const double* const start = beat.momentum;
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
