/// Settled gaits for a host: quantities with names, derivatives by the gait, the path of a beat.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <string_view>

#include "hypertuna/host/directions.hpp"
#include "hypertuna/host/tank.hpp"

namespace hypertuna {

extern const Kernel kernel_portable;

inline constexpr int beat_steps = 128;       // Runge-Kutta steps of a beat
inline constexpr int newton_beats = 60;      // of each stage of Newton's method
inline constexpr int approach_beats = 2000;  // at most in which a start from rest is followed
inline constexpr double neutral = 1 + 1e-6;  // largest multiplier of a body that keeps a disturbance as it is
inline constexpr double straight = 1e6;      // body lengths: a larger turning radius is no turn

enum class Verdict { settled, unsettled, unstable, diverged };

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

/// One row of the kernel, by the names of its columns.
struct SettledRow {
    const double* row;

    static int place(std::string_view name) {
        int k = 0;
        while (kernel_portable.settle_column(k) != name) ++k;
        return k;
    }
    static int width() {
        int k = 0;
        while (kernel_portable.settle_column(k)) ++k;
        return k;
    }
    double operator[](std::string_view name) const { return row[place(name)]; }
};

/// A robot's swimmer: the model, its mass and its length.
struct HostModel {
    Model model;
    double mass;  // kg
};

inline bool spins(double turn) { return pi < std::abs(turn); }

inline Verdict verdict(const SettledRow& row) {
    const bool finite = std::isfinite(row["turn"] + row["power"] + row["loss"] + row["residual"]) &&
                        (std::isfinite(row["speed"] + row["excursion"]) || spins(row["turn"]));
    if (!finite) return Verdict::diverged;
    if (!(row["distance"] < kernel_portable.settled_distance)) return Verdict::unsettled;
    return neutral < spectral_radius(row.row + SettledRow::place("m_00")) ? Verdict::unstable : Verdict::settled;
}

/// A quantity of a settled gait at a frequency.
struct HostQuantity {
    const char* name;
    double (*of)(const SettledRow& row, const HostModel& host, double frequency);
};

#define HYPERTUNA_QUANTITY(name, value)                                                   \
    {name, [](const SettledRow& row, const HostModel& host, double frequency) -> double { \
         const double speed = row["speed"], weight = host.mass * std::abs(speed);         \
         return (void)host, (void)frequency, (void)speed, (void)weight, value;            \
     }}
inline constexpr HostQuantity quantities[] = {
    HYPERTUNA_QUANTITY("status", double(int(verdict(row)))),
    HYPERTUNA_QUANTITY("speed", speed),
    HYPERTUNA_QUANTITY("speed_bl", speed / host.model.length),
    HYPERTUNA_QUANTITY("mechanical_power", row["power"]),
    HYPERTUNA_QUANTITY("mechanical_power_positive", row["power_positive"]),
    HYPERTUNA_QUANTITY("power_to_water", row["loss"]),
    HYPERTUNA_QUANTITY("cost_of_transport", row["power"] / weight),
    HYPERTUNA_QUANTITY("cost_of_transport_positive", row["power_positive"] / weight),
    HYPERTUNA_QUANTITY("efficiency", row["power"] > 0 ? row["towed_power"] / row["power"] : std::nan("")),
    HYPERTUNA_QUANTITY("strouhal", frequency* row["excursion"] / std::abs(speed)),
    HYPERTUNA_QUANTITY("stride_length", speed / (frequency * host.model.length)),
    HYPERTUNA_QUANTITY("tail_excursion", row["excursion"]),
    HYPERTUNA_QUANTITY("torque_peak", row["torque_peak"]),
    HYPERTUNA_QUANTITY("rate_peak", row["rate_peak"]),
    HYPERTUNA_QUANTITY("turn_rate", row["turn"] * frequency),
    HYPERTUNA_QUANTITY("turn_radius", straight* host.model.length <= row["radius"] ? HUGE_VAL : row["radius"]),
    HYPERTUNA_QUANTITY("spectral_radius", spectral_radius(row.row + SettledRow::place("m_00"))),
    HYPERTUNA_QUANTITY("change_per_beat", row["residual"]),
    HYPERTUNA_QUANTITY("distance_to_settled", row["distance"]),
    HYPERTUNA_QUANTITY("beats", row["beats"]),
    HYPERTUNA_QUANTITY("arrived", double(row["approach"] < kernel_portable.arrived_distance)),
    HYPERTUNA_QUANTITY("approach_beats", row["approach_beats"]),
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

/// Rows of the kernel for gaits.
inline std::vector<double> settled_rows(const Model& model, const GaitColumns& gaits, bool follow) {
    const int count = int(gaits.frequency.size());
    std::vector<double> rows(std::size_t(count) * SettledRow::width());
    kernel_portable.settle(model, gaits.batch(), {beat_steps, -1, newton_beats, -1, follow ? approach_beats : 0}, 0,
                           count, rows.data());
    return rows;
}

inline void swim(const HostModel& host, const double* gaits, int count, bool follow, double* out) {
    const GaitColumns columns(gaits, count, host.model.groups);
    const std::vector<double> rows = settled_rows(host.model, columns, follow);
    const int width = SettledRow::width();
    for (int k = 0; k < count; ++k)
        for (const HostQuantity& quantity : quantities)
            *out++ = quantity.of({rows.data() + std::size_t(k) * width}, host, columns.frequency[k]);
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
    const std::vector<double> rows = settled_rows(model, columns, false);
    const SettledRow row{rows.data()};
    std::vector<double> along(std::size_t(parameter_count(model)) * numbers);
    for (int i = 0; i < numbers; ++i) along[std::size_t(i) * numbers + i] = 1;
    int outputs = 0;
    while (kernel_portable.gradient_output(outputs)) ++outputs;
    std::vector<double> rates(std::size_t(outputs) * width);
    kernel_portable.gradient(model, columns.batch(), sort_directions(model, along.data(), numbers, true), 0, 1,
                             row.row + SettledRow::place("p_x"), beat_steps, rates.data());
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
    const Verdict found = verdict(row);
    const bool periodic = found == Verdict::settled || found == Verdict::unstable;
    const double speed = row["speed"];
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
                *out++ = over_speed(((j == 0) * row["excursion"] + frequency * total("excursion", j)) / std::abs(speed),
                                    frequency * row["excursion"] / std::abs(speed), j);
            else {
                const char* const power = name == "cost_of_transport" ? "power" : "power_positive";
                *out++ = over_speed(total(power, j) / weight, row[power] / weight, j);
            }
        }
}

// --- the path of a beat

/// Rows of time, pose of the nose, and the bend of every link's front joint: steps + 1 of them over a settled beat.
inline void path(const HostModel& host, const double* gait, int steps, double* out) {
    const Model& model = host.model;
    const GaitColumns columns(gait, 1, model.groups);
    const std::vector<double> rows = settled_rows(model, columns, false);
    const double* const start = rows.data() + SettledRow::place("p_x");
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
