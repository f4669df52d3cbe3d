/// The kernels, compiled once for each instruction set: HYPERTUNA_ARCH names it.
#include "hypertuna/host/kernels.hpp"

#include <algorithm>
#include <limits>

#include "hypertuna/host/real.hpp"
#include "hypertuna/host/tank.hpp"
#include "hypertuna/swimming/parameters.hpp"
#include "hypertuna/swimming/settle.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Parameters of the model with W gaits in the lanes; beyond the last gait the last one is repeated.
void load_gaits(const Model& model, const GaitBatch& gaits, int first, int end, std::vector<Real>& parameters) {
    const int g = model.groups;
    for (int k = 0; k < lanes; ++k) {
        const int gait = std::min(first + k, end - 1);
        set_lane(parameters[0], k, gaits.frequency[gait]);
        for (int i = 0; i < g; ++i) {
            set_lane(parameters[1 + i], k, gaits.amplitude[gait * g + i]);
            set_lane(parameters[1 + g + i], k, gaits.phase[gait * g + i]);
            set_lane(parameters[1 + 2 * g + i], k, gaits.bias[gait * g + i]);
        }
    }
}

/// Results of a settled beat, in the order of their columns.
struct Row {
    const Settled<Real>& settled;
    const Approach<Real>& approach;
    Twist<Real> xi;  // at the start of the beat
    Real speed, towed_power, rate_peak;
};
struct Column {
    const char* name;
    Real (*of)(const Row&);
};
template <int i, int k>
Real monodromy(const Row& row) {
    return row.settled.monodromy.a[i][k];
}
constexpr Column columns[] = {
    {"speed", [](const Row& row) { return row.speed; }},
    {"turn", [](const Row& row) { return row.settled.beat.displacement.heading; }},
    {"radius", [](const Row& row) { return row.settled.beat.radius; }},
    {"excursion", [](const Row& row) { return row.settled.beat.excursion; }},
    {"power", [](const Row& row) { return row.settled.beat.power; }},
    {"power_positive", [](const Row& row) { return row.settled.beat.power_positive; }},
    {"loss", [](const Row& row) { return row.settled.beat.loss; }},
    {"towed_power", [](const Row& row) { return row.towed_power; }},
    {"torque_peak", [](const Row& row) { return row.settled.beat.torque_peak; }},
    {"rate_peak", [](const Row& row) { return row.rate_peak; }},
    {"residual", [](const Row& row) { return row.settled.residual; }},
    {"distance", [](const Row& row) { return row.settled.distance; }},
    {"beats", [](const Row& row) { return row.settled.beats; }},
    {"approach", [](const Row& row) { return row.approach.distance; }},
    {"approach_beats", [](const Row& row) { return row.approach.beats; }},
    {"u", [](const Row& row) { return row.xi.x; }},
    {"v", [](const Row& row) { return row.xi.y; }},
    {"r", [](const Row& row) { return row.xi.z; }},
    {"p_x", [](const Row& row) { return row.settled.start.x; }},
    {"p_y", [](const Row& row) { return row.settled.start.y; }},
    {"l", [](const Row& row) { return row.settled.start.z; }},
    {"m_00", monodromy<0, 0>},
    {"m_01", monodromy<0, 1>},
    {"m_02", monodromy<0, 2>},
    {"m_10", monodromy<1, 0>},
    {"m_11", monodromy<1, 1>},
    {"m_12", monodromy<1, 2>},
    {"m_20", monodromy<2, 0>},
    {"m_21", monodromy<2, 1>},
    {"m_22", monodromy<2, 2>},
};
constexpr int column_count = sizeof(columns) / sizeof(columns[0]);

const char* settle_column(int k) { return k < column_count ? columns[k].name : nullptr; }

/// The settled beat of the gaits in the tank: by waiting, or by Newton's method.
template <class Law>
Settled<Real> settle_tank(const PeriodicSwimmer<Real, Law>& body, Tank<Real, Law>& tank, const SettleOptions& options) {
    const auto rest = filled<Momentum<Real>>(Real(0.0));  // joints that set in cannot give momentum
    if (options.wait >= 0) return wait(body, rest, options.wait);
    Momentum<Real> guess = rest;
    for (int k = 0; k < options.from_rest; ++k) guess = body.swim(guess);
    if (options.from_rest < 0)
        guess = brisk_start(tank.table, int(tank.groups.size()), tank.swings.data(), tank.frequency, body.length);
    return settle(body, guess, options.max_beats);
}

template <class Law>
void settle_gaits(const Model& model, const GaitBatch& gaits, const SettleOptions& options, int begin, int end,
                  double* rows) {
    Tank<Real, Law> tank(model, options.steps);
    const Real nan(std::numeric_limits<double>::quiet_NaN());
    for (int first = begin; first < end; first += lanes) {
        load_gaits(model, gaits, first, end, tank.parameters);
        tank.fill();
        const PeriodicSwimmer<Real, Law> body{tank.fish,          tank.joints.data(),         tank.table,
                                              Real(model.length), Real(1.0) / tank.frequency, tank.scratch};
        const Settled<Real> s = settle_tank(body, tank, options);
        // Toward what is not settled no start is followed: its distance is NaN.
        const Momentum<Real> target =
            select(s.distance < Real(settle_tolerances.settled), s.start, filled<Momentum<Real>>(nan));
        const Approach<Real> way = approach(body, target, options.approach);
        const Real speed = mean_speed(s.beat, tank.frequency);
        const Row row{s,
                      way,
                      twist(tank.table[0], s.start),
                      speed,
                      towing_power(tank.fish, speed),
                      largest_rate(model.groups, tank.groups.data(), tank.frequency)};
        for (int c = 0; c < column_count; ++c) {
            const Real value = columns[c].of(row);
            for (int k = 0; k < lanes && first + k < end; ++k) rows[(first + k) * column_count + c] = lane(value, k);
        }
    }
}

void settle_any(const Model& model, const GaitBatch& gaits, const SettleOptions& options, int begin, int end,
                double* rows) {
    with_law<Real>(model.law, [&](auto law) {
        settle_gaits<typename decltype(law)::type>(model, gaits, options, begin, end, rows);
    });
}

/// Derivatives fill the lanes: every lane holds the same value and its derivative in a direction of its own.
using Derivative = Dual<Real, 1>;

/// Results that have derivatives, in the order of their rows.
struct Measured {
    Beat<Derivative> beat;
    Derivative speed, rate_peak;
};
struct Differentiated {
    const char* name;
    Derivative (*of)(const Measured&);
};
constexpr Differentiated outputs[] = {
    {"speed", [](const Measured& m) { return m.speed; }},
    {"power", [](const Measured& m) { return m.beat.power; }},
    {"power_positive", [](const Measured& m) { return m.beat.power_positive; }},
    {"loss", [](const Measured& m) { return m.beat.loss; }},
    {"torque_peak", [](const Measured& m) { return m.beat.torque_peak; }},
    {"rate_peak", [](const Measured& m) { return m.rate_peak; }},
    {"excursion", [](const Measured& m) { return m.beat.excursion; }},
    {"end_p_x", [](const Measured& m) { return m.beat.end.x; }},
    {"end_p_y", [](const Measured& m) { return m.beat.end.y; }},
    {"end_l", [](const Measured& m) { return m.beat.end.z; }},
};
constexpr int output_count = sizeof(outputs) / sizeof(outputs[0]);

const char* gradient_output(int k) { return k < output_count ? outputs[k].name : nullptr; }

/// Point the lanes into directions first, first + 1, ... of a list; beyond the last, the last is repeated.
void point(const Directions& directions, const std::vector<int>& list, std::size_t first, Momentum<Derivative>& start,
           std::vector<Derivative>& parameters) {
    Derivative* const axes[3] = {&start.x, &start.y, &start.z};
    for (int k = 0; k < lanes && !list.empty(); ++k) {
        const int direction = list[std::min(first + k, list.size() - 1)];
        for (int i = 0; i < 3; ++i) set_lane(axes[i]->d[0], k, direction == i - 3 ? 1.0 : 0.0);
        for (std::size_t i = 0; i < parameters.size(); ++i)
            set_lane(parameters[i].d[0], k, direction < 0 ? 0.0 : directions.along[i * directions.count + direction]);
    }
}

/// Derivatives along a list of directions. G has derivatives where the directions change the shape.
template <class Law, class G>
void gradient_along(const Model& model, const GaitBatch& gaits, const Directions& directions,
                    const std::vector<int>& list, int begin, int end, const double* momentum, int steps, double* rows) {
    if (list.empty()) return;
    Tank<Derivative, Law, G> tank(model, steps);
    const int count = 3 + directions.count;
    std::vector<Real> parameters(gait_parameters(model.groups), Real(0.0));
    for (int gait = begin; gait < end; ++gait) {
        load_gaits(model, gaits, gait, gait + 1, parameters);
        for (std::size_t i = 0; i < parameters.size(); ++i) tank.parameters[i] = Derivative(parameters[i]);
        const double* const P = momentum + 3 * gait;
        Momentum<Derivative> start{Derivative(Real(P[0])), Derivative(Real(P[1])), Derivative(Real(P[2]))};
        double* const out = rows + static_cast<std::size_t>(gait) * output_count * count;
        for (std::size_t first = 0; first < list.size(); first += lanes) {
            point(directions, list, first, start, tank.parameters);
            if (first == 0 || std::same_as<G, Derivative>)
                tank.fill();
            else
                tank.refill();
            const Beat<Derivative> beat = measure_beat(tank.fish, tank.joints.data(), tank.table,
                                                       Derivative(Real(1.0)) / tank.frequency, start, tank.scratch);
            const Measured m{beat, mean_speed(beat, tank.frequency),
                             largest_rate(model.groups, tank.groups.data(), tank.frequency)};
            for (int o = 0; o < output_count; ++o) {
                const Real derivative = outputs[o].of(m).d[0];
                for (std::size_t k = 0; k < lanes && first + k < list.size(); ++k)
                    out[o * count + 3 + list[first + k]] = lane(derivative, static_cast<int>(k));
            }
        }
    }
}

template <class Law>
void gradient_of(const Model& model, const GaitBatch& gaits, const Directions& directions, int begin, int end,
                 const double* momentum, int steps, double* rows) {
    std::vector<int> moving = directions.moving;
#ifdef HYPERTUNA_SMALL
    moving.insert(moving.begin(), directions.still.begin(), directions.still.end());
#else
    gradient_along<Law, Real>(model, gaits, directions, directions.still, begin, end, momentum, steps, rows);
#endif
    gradient_along<Law, Derivative>(model, gaits, directions, moving, begin, end, momentum, steps, rows);
}

void gradient_any(const Model& model, const GaitBatch& gaits, const Directions& directions, int begin, int end,
                  const double* momentum, int steps, double* rows) {
    with_law<Derivative>(model.law, [&](auto law) {
        gradient_of<typename decltype(law)::type>(model, gaits, directions, begin, end, momentum, steps, rows);
    });
}

#ifndef HYPERTUNA_SMALL
template <class Law, class G>
void track_along(const Model& model, const JointSeries& series, const Directions& directions,
                 const std::vector<int>& list, const Track& track) {
    Tank<Derivative, Law, G> tank(model, block_steps + 1);
    std::vector<JointMotion<G>> joints(model.links);
    const auto joints_at = [&](std::size_t k) {
        const double* at = series.motion + 3 * model.links * k;
        for (JointMotion<G>& joint : joints) {
            joint = {G(Real(at[0])), G(Real(at[1])), G(Real(at[2]))};
            at += 3;
        }
        return joints.data();
    };
    const Derivative zero(Real(0.0));
    const double still[3] = {0, 0, 0}, *const xi = series.twist ? series.twist : still;
    const int offset = series.twist ? 3 : 0;  // of the column of the first direction
    Twist<Derivative> start{Derivative(Real(xi[0])), Derivative(Real(xi[1])), Derivative(Real(xi[2]))};
    for (std::size_t first = 0; first == 0 || first < list.size(); first += lanes) {
        point(directions, list, first, start, tank.parameters);
        tank.read();
        Momentum<Derivative> momentum{zero, zero, zero};
        if (series.twist) {
            tabulate(tank.fish, joints_at(0), 0, tank.table);
            const auto [m, b] = composite(tank.fish, tank.table.shape);
            momentum = m * start + b;
        }
        swim_joints(tank, series.steps, Derivative(Real(series.step)), {momentum, {zero, zero, zero}}, joints_at,
                    [&](std::size_t k, const Instant<Derivative, G>& now, const Motion<Derivative>& motion) {
                        const Pose<Derivative>& pose = motion.pose;
                        const Pose<Derivative> rate = pose_rate(pose, twist(now, motion.momentum));
                        const Derivative at[3] = {pose.x, pose.y, pose.heading};
                        const Derivative going[3] = {rate.x, rate.y, rate.heading};
                        for (int axis = 0; axis < 3; ++axis) {
                            const std::size_t place = 3 * k + axis;
                            track.pose[place] = lane(at[axis].v, 0);
                            track.rate[place] = lane(going[axis].v, 0);
                            for (std::size_t i = 0; i < lanes && first + i < list.size(); ++i)
                                track.gradient[place * (offset + directions.count) + offset + list[first + i]] =
                                    lane(at[axis].d[0], static_cast<int>(i));
                        }
                    });
    }
}

template <class Law>
void track_of(const Model& model, const JointSeries& series, const Directions& directions, const Track& track) {
    if (directions.moving.empty() || !directions.still.empty())  // once at least, for the pose itself
        track_along<Law, Real>(model, series, directions, directions.still, track);
    if (!directions.moving.empty()) track_along<Law, Derivative>(model, series, directions, directions.moving, track);
}

void track_any(const Model& model, const JointSeries& series, const Directions& directions, const Track& track) {
    with_law<Derivative>(model.law,
                         [&](auto law) { track_of<typename decltype(law)::type>(model, series, directions, track); });
}
#else
constexpr void (*track_any)(const Model&, const JointSeries&, const Directions&, const Track&) = nullptr;
#endif

}  // namespace hypertuna::inline HYPERTUNA_ARCH

#define HYPERTUNA_TEXT(x) #x
#define HYPERTUNA_NAME(x) HYPERTUNA_TEXT(x)
#define HYPERTUNA_JOIN(a, b) a##b
#define HYPERTUNA_SYMBOL(a, b) HYPERTUNA_JOIN(a, b)

namespace hypertuna {
#ifdef HYPERTUNA_SMALL
static constexpr const MachineKernel* machines = nullptr;
#else
#define HYPERTUNA_MACHINES HYPERTUNA_SYMBOL(HYPERTUNA_SYMBOL(machines_, HYPERTUNA_ARCH), _exact)
extern const MachineKernel HYPERTUNA_MACHINES;
static constexpr const MachineKernel* machines = &HYPERTUNA_MACHINES;
#endif
extern const Kernel HYPERTUNA_SYMBOL(kernel_, HYPERTUNA_ARCH);
const Kernel HYPERTUNA_SYMBOL(kernel_, HYPERTUNA_ARCH) = {
    .name = HYPERTUNA_NAME(HYPERTUNA_ARCH),
    .lanes = HYPERTUNA_ARCH::lanes,
    .settled_distance = HYPERTUNA_ARCH::settle_tolerances.settled,
    .arrived_distance = HYPERTUNA_ARCH::approach_tolerances.arrived,
    .settle = HYPERTUNA_ARCH::settle_any,
    .gradient = HYPERTUNA_ARCH::gradient_any,
    .track = HYPERTUNA_ARCH::track_any,
    .settle_column = HYPERTUNA_ARCH::settle_column,
    .gradient_output = HYPERTUNA_ARCH::gradient_output,
    .machines = machines,
};
}  // namespace hypertuna
