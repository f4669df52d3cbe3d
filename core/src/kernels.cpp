/// The kernels, compiled once for each instruction set, which HYPERTUNA_ARCH names.
#include <algorithm>

#include "hypertuna/host/rows.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

constexpr const char* state_columns[] = {"p_x",  "p_y",  "l",    "m_00", "m_01", "m_02",
                                         "m_10", "m_11", "m_12", "m_20", "m_21", "m_22"};
static_assert(row_width(Momentum<Real>::size) == named_columns + int(std::size(state_columns)));

const char* settle_column(int k) {
    if (k < quantity_count) return quantities<Real>[k].about.name;
    if (k < named_columns) return found_columns[k - quantity_count];
    return k < row_width(Momentum<Real>::size) ? state_columns[k - named_columns] : nullptr;
}

template <class Law>
void settle_gaits(const Model& model, const GaitBatch& gaits, const SettleOptions& options, int begin, int end,
                  double* rows) {
    Tank<Real, Law> tank(model, options.steps);
    for (int first = begin; first < end; first += lanes) {
        load_gaits(model, gaits, first, end, tank.parameters);
        tank.fill();
        const PeriodicSwimmer<Real, Law> body{tank.fish,          tank.joints.data(),         tank.table,
                                              Real(model.length), Real(1.0) / tank.frequency, tank.scratch};
        LaneRows write{rows, row_width(Momentum<Real>::size), first, end};
        settle_into(model, body, tank, options, write);
    }
}

void settle_any(const Model& model, const GaitBatch& gaits, const SettleOptions& options, int begin, int end,
                double* rows) {
    with_law<Real>(model.law, [&](auto law) {
        settle_gaits<typename decltype(law)::type>(model, gaits, options, begin, end, rows);
    });
}

/// Scalar of the derivatives: every lane holds the same value and its derivative in another direction.
using Derivative = Dual<Real, 1>;

/// Number of results that have derivatives: quantities, and the momentum at the end.
constexpr int output_count = derivative_count + 3;

/// Set the lanes' derivatives to directions first, first + 1, ... of a list; beyond the last, the last is repeated.
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

/// Set the derivatives of the joints' shares to the directions, whose rows for shares come after the parameters'.
template <class G>
void point_shares(const Directions& directions, const std::vector<int>& list, std::size_t first, std::size_t row,
                  std::vector<JointShare<G>>& joints) {
    if constexpr (std::same_as<G, Derivative>)
        for (std::size_t i = 0; i < joints.size(); ++i)
            for (int k = 0; k < lanes; ++k) {
                const int direction = list[std::min(first + k, list.size() - 1)];
                const double along = direction < 0 ? 0.0 : directions.along[(row + i) * directions.count + direction];
                set_lane(joints[i].share.d[0], k, along);
            }
}

/// Write derivatives along a list of directions. G has derivatives where the directions change the shape.
template <class Law, class G>
void gradient_along(const Model& model, const GaitBatch& gaits, const Directions& directions,
                    const std::vector<int>& list, int begin, int end, const double* momentum, int steps, double mass,
                    double* rows) {
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
            point_shares(directions, list, first, tank.parameters.size(), tank.joints);
            if (first == 0 || std::same_as<G, Derivative>)
                tank.fill();
            else
                tank.refill();
            const Beat<Derivative> beat = measure_beat(tank.fish, tank.joints.data(), tank.table,
                                                       Derivative(Real(1.0)) / tank.frequency, start, tank.scratch);
            const Measured<Derivative> m = measured(beat, tank, model.length, mass);
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
    const int offset = series.twist ? 3 : 0;  // column of the first direction
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
    if (directions.moving.empty() || !directions.still.empty())  // compute at least once, for the pose itself
        track_along<Law, Real>(model, series, directions, directions.still, track);
    if (!directions.moving.empty()) track_along<Law, Derivative>(model, series, directions, directions.moving, track);
}

void track_any(const Model& model, const JointSeries& series, const Directions& directions, const Track& track) {
    with_law<Derivative>(model.law,
                         [&](auto law) { track_of<typename decltype(law)::type>(model, series, directions, track); });
}

/// Mean force toward the head over the beats of gaits whose head is held, with derivatives along all directions. Over a
/// beat the change of the body's momentum adds nothing to the force.
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
