/// The kernels, compiled once for each instruction set: HYPERTUNA_ARCH names it.
#include "hypertuna/host/kernels.hpp"

#include <algorithm>
#include <limits>

#include "hypertuna/host/real.hpp"
#include "hypertuna/host/tank.hpp"
#include "hypertuna/swimming/parameters.hpp"
#include "hypertuna/swimming/quantities.hpp"

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

/// What a search found besides the quantities, in the order of the columns.
struct Found {
    const Settled<Real>& settled;
    const Approach<Real>& approach;
    Twist<Real> xi;  // at the start of the beat
    Real status;     // but for its stability
};
struct Column {
    const char* name;
    Real (*of)(const Found&);
};
template <int i, int k>
Real monodromy(const Found& found) {
    return found.settled.monodromy.a[i][k];
}
constexpr Column columns[] = {
    {"status", [](const Found& found) { return found.status; }},
    {"arrived",
     [](const Found& found) {
         return select(found.approach.distance < Real(approach_tolerances.arrived), Real(1.0), Real(0.0));
     }},
    {"approach_beats", [](const Found& found) { return found.approach.beats; }},
    {"u", [](const Found& found) { return found.xi.x; }},
    {"v", [](const Found& found) { return found.xi.y; }},
    {"r", [](const Found& found) { return found.xi.z; }},
    {"p_x", [](const Found& found) { return found.settled.start.x; }},
    {"p_y", [](const Found& found) { return found.settled.start.y; }},
    {"l", [](const Found& found) { return found.settled.start.z; }},
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
constexpr int quantity_count = std::size(quantities<Real>), column_count = quantity_count + std::size(columns);

const char* settle_column(int k) {
    if (k < quantity_count) return quantities<Real>[k].about.name;
    return k < column_count ? columns[k - quantity_count].name : nullptr;
}

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
        const Measured<Real> measured{s.beat,
                                      speed,
                                      largest_rate(model.groups, tank.groups.data(), tank.frequency),
                                      tank.frequency,
                                      body.length,
                                      Real(options.mass),
                                      towing_power(tank.fish, speed),
                                      s.residual,
                                      s.distance,
                                      s.beats};
        const Found found{s, way, twist(tank.table[0], s.start), search_status(s, speed)};
        for (int c = 0; c < column_count; ++c) {
            const auto of = quantities<Real>[std::min(c, quantity_count - 1)].of;
            const Real value = quantity_count <= c ? columns[c - quantity_count].of(found) : of ? of(measured) : nan;
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

/// Results that have derivatives: quantities, and the momentum at the end.
constexpr int output_count = derivative_count + 3;

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
                    const std::vector<int>& list, int begin, int end, const double* momentum, int steps, double mass,
                    double* rows) {
    if (list.empty()) return;
    Tank<Derivative, Law, G> tank(model, steps);
    const Derivative zero(Real(0.0));
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
            const Measured<Derivative> m{beat,
                                         mean_speed(beat, tank.frequency),
                                         largest_rate(model.groups, tank.groups.data(), tank.frequency),
                                         tank.frequency,
                                         Derivative(Real(model.length)),
                                         Derivative(Real(mass)),
                                         zero,
                                         zero,
                                         zero,
                                         zero};
            double* row = out;
            const auto write = [&](const Derivative& result) {
                for (std::size_t k = 0; k < lanes && first + k < list.size(); ++k)
                    row[3 + list[first + k]] = lane(result.d[0], static_cast<int>(k));
                row += count;
            };
            for (const auto& [about, of] : quantities<Derivative>)
                if (about.differentiable) write(of(m));
            for (const Derivative& end_of_beat : {beat.end.x, beat.end.y, beat.end.z}) write(end_of_beat);
        }
    }
}

template <class Law>
void gradient_of(const Model& model, const GaitBatch& gaits, const Directions& directions, int begin, int end,
                 const double* momentum, int steps, double mass, double* rows) {
    std::vector<int> moving = directions.moving;
#ifdef HYPERTUNA_SMALL
    moving.insert(moving.begin(), directions.still.begin(), directions.still.end());
#else
    gradient_along<Law, Real>(model, gaits, directions, directions.still, begin, end, momentum, steps, mass, rows);
#endif
    gradient_along<Law, Derivative>(model, gaits, directions, moving, begin, end, momentum, steps, mass, rows);
}

void gradient_any(const Model& model, const GaitBatch& gaits, const Directions& directions, int begin, int end,
                  const double* momentum, int steps, double mass, double* rows) {
    with_law<Derivative>(model.law, [&](auto law) {
        gradient_of<typename decltype(law)::type>(model, gaits, directions, begin, end, momentum, steps, mass, rows);
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
                            for (std::size_t i = 0; i < lanes && first + i < list.size(); ++i) {
                                const std::size_t by = place * (offset + directions.count) + offset + list[first + i];
                                track.gradient[by] = lane(at[axis].d[0], static_cast<int>(i));
                                if (track.rate_gradient)
                                    track.rate_gradient[by] = lane(going[axis].d[0], static_cast<int>(i));
                            }
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

/// Mean force toward the head over the beats of gaits whose head is held, with derivatives along all directions. What
/// the body's momentum takes of the force is back after a beat.
template <class Law>
void held_gaits(const Model& model, const GaitBatch& gaits, const Directions& directions, int begin, int end,
                const double* speed, int steps, double* rows) {
    Tank<Derivative, Law> tank(model, steps);
    const Derivative zero(Real(0.0)), mean(Real(1.0 / tank.table.instants));
    std::vector<int> list = directions.still;
    list.insert(list.end(), directions.moving.begin(), directions.moving.end());
    std::vector<Real> parameters(gait_parameters(model.groups), Real(0.0));
    Momentum<Derivative> none{zero, zero, zero};
    for (int gait = begin; gait < end; ++gait) {
        load_gaits(model, gaits, gait, gait + 1, parameters);
        for (std::size_t i = 0; i < parameters.size(); ++i) tank.parameters[i] = Derivative(parameters[i]);
        const Twist<Derivative> xi{Derivative(Real(-speed[gait])), zero, zero};
        double* const row = rows + static_cast<std::size_t>(gait) * (1 + directions.count);
        for (std::size_t first = 0; first == 0 || first < list.size(); first += lanes) {
            point(directions, list, first, none, tank.parameters);
            tank.fill();
            Derivative force = zero;
            for (int k = 0; k < tank.table.instants; ++k)
                force -= mean * water_wrench(tank.fish, tank.table[k].shape, xi).x;
            row[0] = lane(force.v, 0);
            for (std::size_t k = 0; k < lanes && first + k < list.size(); ++k)
                row[1 + list[first + k]] = lane(force.d[0], static_cast<int>(k));
        }
    }
}

void held_any(const Model& model, const GaitBatch& gaits, const Directions& directions, int begin, int end,
              const double* speed, int steps, double* rows) {
    with_law<Derivative>(model.law, [&](auto law) {
        held_gaits<typename decltype(law)::type>(model, gaits, directions, begin, end, speed, steps, rows);
    });
}
#else
constexpr void (*track_any)(const Model&, const JointSeries&, const Directions&, const Track&) = nullptr;
constexpr void (*held_any)(const Model&, const GaitBatch&, const Directions&, int, int, const double*, int,
                           double*) = nullptr;
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
    .settle = HYPERTUNA_ARCH::settle_any,
    .gradient = HYPERTUNA_ARCH::gradient_any,
    .track = HYPERTUNA_ARCH::track_any,
    .held = HYPERTUNA_ARCH::held_any,
    .settle_column = HYPERTUNA_ARCH::settle_column,
    .machines = machines,
};
}  // namespace hypertuna
