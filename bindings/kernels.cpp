/// The kernels, compiled once for each instruction set: HYPERTUNA_ARCH names it.
#include "kernels.hpp"

#include <algorithm>

#include "hypertuna/parameters.hpp"
#include "hypertuna/settle.hpp"
#include "tank.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

#if defined(__AVX512F__)
inline constexpr int lanes = 8;
#elif defined(__AVX__)
inline constexpr int lanes = 4;
#elif defined(__SSE4_2__) || defined(__aarch64__)
inline constexpr int lanes = 2;
#else
inline constexpr int lanes = 1;
#endif

template <int W>
struct Pack {
    using type = Lanes<double, W>;
};
template <>
struct Pack<1> {
    using type = double;
};
using Real = typename Pack<lanes>::type;

HYPERTUNA_INLINE double lane(double x, int) { return x; }
HYPERTUNA_INLINE void set_lane(double& x, int, double y) { x = y; }
template <int W>
HYPERTUNA_INLINE double lane(const Lanes<double, W>& x, int k) {
    return x[k];
}
template <int W>
HYPERTUNA_INLINE void set_lane(Lanes<double, W>& x, int k, double y) {
    x.set(k, y);
}

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

void store(const Settled<Real>& s, const Twist<Real>& xi, int k, double* row) {
    const auto& m = s.monodromy.a;
    const Real values[column::count] = {s.beat.displacement.x,
                                        s.beat.displacement.y,
                                        s.beat.displacement.heading,
                                        s.beat.power,
                                        s.beat.power_positive,
                                        s.beat.loss,
                                        s.beat.excursion,
                                        s.beat.arc,
                                        s.beat.radius,
                                        s.beat.advance,
                                        s.residual,
                                        s.distance,
                                        s.beats,
                                        xi.x,
                                        xi.y,
                                        xi.z,
                                        s.start.x,
                                        s.start.y,
                                        s.start.z,
                                        m[0][0],
                                        m[0][1],
                                        m[0][2],
                                        m[1][0],
                                        m[1][1],
                                        m[1][2],
                                        m[2][0],
                                        m[2][1],
                                        m[2][2]};
    for (int c = 0; c < column::count; ++c) row[c] = lane(values[c], k);
}

template <class Law>
void settle_gaits(const Model& model, const GaitBatch& gaits, const SettleOptions& options, int begin, int end,
                  double* rows) {
    Tank<Real, Law> tank(model, options.steps);
    const Real length(model.length);
    for (int first = begin; first < end; first += lanes) {
        load_gaits(model, gaits, first, end, tank.parameters);
        tank.fill();
        const Real period = Real(1.0) / tank.frequency;
        const Momentum<Real> rest{Real(0.0), Real(0.0), Real(0.0)};  // joints that set in cannot give momentum
        const Momentum<Real> brisk = brisk_start(tank.table, model.groups, tank.swings.data(), tank.frequency, length);
        const Settled<Real> s = options.wait >= 0 ? wait(tank.fish, tank.joints.data(), tank.table, length, period,
                                                         rest, options.wait, tank.scratch)
                                                  : settle(tank.fish, tank.joints.data(), tank.table, length, period,
                                                           brisk, options.most_beats, tank.scratch);
        const Twist<Real> xi = twist(tank.table[0], s.start);
        for (int k = 0; k < lanes && first + k < end; ++k) store(s, xi, k, rows + (first + k) * column::count);
    }
}

void settle_any(const Model& model, const GaitBatch& gaits, const SettleOptions& options, int begin, int end,
                double* rows) {
    if (model.law == WaterLaw::lumped)
        settle_gaits<Lumped<Real>>(model, gaits, options, begin, end, rows);
    else
        settle_gaits<Strip<Real>>(model, gaits, options, begin, end, rows);
}

/// Derivatives fill the lanes: every lane holds the same value and its derivative in a direction of its own.
using Slope = Dual<Real, 1>;

template <class Law>
void gradient_of(const Model& model, const GaitBatch& gaits, int gait, const double* momentum, int steps,
                 double* rows) {
    Tank<Slope, Law> tank(model, steps);
    const int g = model.groups, count = 3 + parameter_count(model);
    std::vector<Real> parameters(tank.parameters.size(), Real(0.0));
    load_gaits(model, gaits, gait, gait + 1, parameters);
    for (int i = 0; i < gait_parameters(g) - g; ++i) tank.parameters[i] = Slope(parameters[i]);
    Momentum<Slope> start{Slope(Real(momentum[0])), Slope(Real(momentum[1])), Slope(Real(momentum[2]))};
    const auto seed = [&](int direction) -> Slope& {
        Slope* const moment[3] = {&start.x, &start.y, &start.z};
        return direction < 3 ? *moment[direction] : tank.parameters[direction - 3];
    };
    for (int first = 0; first < count; first += lanes) {
        const int here = std::min(lanes, count - first);
        for (int k = 0; k < here; ++k) set_lane(seed(first + k).d[0], k, 1.0);
        tank.fill();
        const Beat<Slope> b = measure_beat(tank.fish, tank.joints.data(), tank.table, Slope(Real(1.0)) / tank.frequency,
                                           start, tank.scratch);
        const Slope* const outputs[output::count] = {&b.arc,   &b.power, &b.power_positive, &b.loss,
                                                     &b.end.x, &b.end.y, &b.end.z};
        for (int o = 0; o < output::count; ++o)
            for (int k = 0; k < here; ++k) rows[o * count + first + k] = lane(outputs[o]->d[0], k);
        for (int k = 0; k < here; ++k) set_lane(seed(first + k).d[0], k, 0.0);
    }
}

void gradient_any(const Model& model, const GaitBatch& gaits, int gait, const double* momentum, int steps,
                  double* rows) {
    if (model.law == WaterLaw::lumped)
        gradient_of<Lumped<Slope>>(model, gaits, gait, momentum, steps, rows);
    else
        gradient_of<Strip<Slope>>(model, gaits, gait, momentum, steps, rows);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH

#define HYPERTUNA_TEXT(x) #x
#define HYPERTUNA_NAME(x) HYPERTUNA_TEXT(x)
#define HYPERTUNA_JOIN(a, b) a##b
#define HYPERTUNA_SYMBOL(a, b) HYPERTUNA_JOIN(a, b)

namespace hypertuna {
extern const Kernel HYPERTUNA_SYMBOL(kernel_, HYPERTUNA_ARCH);
const Kernel HYPERTUNA_SYMBOL(kernel_, HYPERTUNA_ARCH) = {HYPERTUNA_NAME(HYPERTUNA_ARCH), HYPERTUNA_ARCH::lanes,
                                                          HYPERTUNA_ARCH::settle_tolerances.settled,
                                                          HYPERTUNA_ARCH::settle_any, HYPERTUNA_ARCH::gradient_any};
}  // namespace hypertuna
