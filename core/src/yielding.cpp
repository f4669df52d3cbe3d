/// The kernels of joints that yield, compiled once for each instruction set: HYPERTUNA_ARCH names it.
#include "hypertuna/host/yielding.hpp"

#include <algorithm>

#include "hypertuna/host/real.hpp"
#include "hypertuna/host/tank.hpp"
#include "hypertuna/swimming/quantities.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

using State = YieldingState<Real, 1>;

/// A tank for a body with one joint that yields.
template <class S, class Law>
struct YieldTank {
    Tank<S, Law> tank;
    Spring<S> spring[1];

    YieldTank(const Model& model, int hinge, int steps)
        : tank(model, steps),
          spring{},
          hinge_(hinge),
          length_(model.length),
          share_(model.links),
          table_(2 * steps * model.links),
          ahead_(2 * steps),
          joint_(model.links),
          shape_(model.links),
          acceleration_(model.links) {
        share_[hinge].part[0] = 1;
    }

    /// Read the parameters and tabulate the beat.
    YieldingSwimmer<S, Law, 1> fill() {
        tank.read();
        static_assert(sizeof(Share) == sizeof(base_t<S>[1]));
        const YieldTable<S, 1> yields{hinge_, &share_.data()->part, table_.data(), ahead_.data()};
        tabulate_yielding(tank.fish, tank.joints.data(), tank.swings.data(), tank.frequency, spring, tank.table,
                          yields);
        return {tank.fish,     tank.joints.data(),    tank.table,
                yields,        S(base_t<S>(length_)), S(base_t<S>(1)) / tank.frequency,
                {spring[0]},   tank.scratch,          joint_.data(),
                shape_.data(), acceleration_.data()};
    }
    S reduced() {
        tank.read();
        return reduced_inertia(tank.fish, hinge_, shape_.data(), acceleration_.data(), joint_.data());
    }

  private:
    struct Share {
        base_t<S> part[1];
    };
    int hinge_;
    double length_;
    std::vector<Share> share_;
    std::vector<JointMotion<S>> table_;
    std::vector<Composite<S>> ahead_;
    std::vector<JointMotion<S>> joint_;
    std::vector<LinkShape<S>> shape_;
    std::vector<LinkAcceleration<S>> acceleration_;
};

/// Write gaits into the lanes of parameters and spring; beyond the last gait the last one is repeated.
template <class S>
void load(const Model& model, const YieldBatch& batch, int first, int end, std::vector<S>& parameters,
          Spring<S>& spring) {
    const int g = model.groups;
    const auto put = [](S& x, int k, double y) {
        if constexpr (requires { x.d; })
            set_lane(x.v, k, y);
        else
            set_lane(x, k, y);
    };
    for (int k = 0; k < lanes; ++k) {
        const int gait = std::min(first + k, end - 1);
        put(parameters[0], k, batch.gaits.frequency[gait]);
        for (int i = 0; i < g; ++i) {
            put(parameters[1 + i], k, batch.gaits.amplitude[gait * g + i]);
            put(parameters[1 + g + i], k, batch.gaits.phase[gait * g + i]);
            put(parameters[1 + 2 * g + i], k, batch.gaits.bias[gait * g + i]);
        }
        S* const of_spring[] = {&spring.stiffness, &spring.damping, &spring.rest};
        for (int i = 0; i < 3; ++i) put(*of_spring[i], k, batch.spring[gait * 3 + i]);
    }
}

/// What a search found, as of a body without joints that yield.
Settled<Real> without_bend(const Settled<Real, State>& s) {
    const auto& b = s.beat;
    return {{b.end.body, b.displacement, b.power, b.power_positive, b.loss, b.torque_peak, b.excursion, b.arc, b.radius,
             b.advance},
            s.start.body,
            {},
            s.residual,
            s.distance,
            s.beats};
}

constexpr const char* yield_columns[] = {
    "status", "arrived",   "approach_beats", "rung",        "u",         "v",
    "r",      "bend_mean", "bend_sine",      "bend_cosine", "bend_peak", "damping_power"};
constexpr int named = int(std::size(quantities<Real>) + std::size(yield_columns)),
              row_size = named + yield_state * (1 + yield_state);

const char* yield_column(int k) {
    const int count = int(std::size(quantities<Real>));
    return k < count ? quantities<Real>[k].about.name : k < named ? yield_columns[k - count] : nullptr;
}

template <class Law>
void settle_gaits(const Model& model, const YieldBatch& batch, const SettleOptions& options, int begin, int end,
                  double* rows) {
    YieldTank<Real, Law> yield(model, batch.link, options.steps);
    Tank<Real, Law>& tank = yield.tank;
    const Real nan(std::numeric_limits<double>::quiet_NaN());
    for (int first = begin; first < end; first += lanes) {
        load(model, batch, first, end, tank.parameters, yield.spring[0]);
        const YieldingSwimmer<Real, Law, 1> body = yield.fill();
        const State rest = filled<State>(Real(0.0));
        State guess = rest;
        for (int k = 0; k < options.from_rest; ++k) guess = body.swim(guess);
        if (options.from_rest < 0)
            guess.body =
                brisk_start(tank.table, int(tank.groups.size()), tank.swings.data(), tank.frequency, body.length);
        Real rung(0.0);
        Swinging<Real> swings;
        const Settled<Real, State> found =
            options.wait >= 0 ? wait(Measuring<YieldingSwimmer<Real, Law, 1>>{body, &swings}, rest, options.wait)
                              : settle_yielding(body, guess, options.max_beats, rung, swings);
        const State target = select(found.distance < Real(settle_tolerances.settled), found.start, filled<State>(nan));
        const Approach<Real, State> way = approach(body, target, options.approach);
        Hung<Real, 1> hung[max_hung];
        const Twist<Real> xi = body.move(0, found.start, hung).xi;
        const Settled<Real> s = without_bend(found);
        const Real speed = mean_speed(s.beat, tank.frequency);
        const Measured<Real> m{s.beat,
                               speed,
                               largest_rate(model.groups, tank.groups.data(), tank.frequency),
                               tank.frequency,
                               body.length,
                               Real(options.mass),
                               towing_power(tank.fish, speed),
                               s.residual,
                               s.distance,
                               s.beats};
        const Real here = select(way.distance < Real(approach_tolerances.arrived), Real(1.0), Real(0.0));
        const Real extra[] = {
            search_status(s, speed), here,        way.beats,     rung, xi.x, xi.y, xi.z, swings.mean, swings.sine,
            swings.cosine,           swings.peak, swings.damping};
        int c = 0;
        const auto write = [&](const Real& value) {
            for (int k = 0; k < lanes && first + k < end; ++k)
                rows[std::size_t(first + k) * row_size + c] = lane(value, k);
            ++c;
        };
        for (const auto& quantity : quantities<Real>) write(quantity.of ? quantity.of(m) : nan);
        for (const Real& value : extra) write(value);
        State start = found.start;
        for (int i = 0; i < yield_state; ++i) write(component(start, i));
        for (const auto& row : found.monodromy.a)
            for (const Real& value : row) write(value);
    }
}

void settle_any(const Model& model, const YieldBatch& batch, const SettleOptions& options, int begin, int end,
                double* rows) {
    with_law<Real>(model.law, [&](auto law) {
        settle_gaits<typename decltype(law)::type>(model, batch, options, begin, end, rows);
    });
}

using Derivative = Dual<Real, 1>;

template <class Law>
void gradient_of(const Model& model, const YieldBatch& batch, const Directions& directions, int begin, int end,
                 const double* state, int steps, double mass, double* rows) {
    YieldTank<Derivative, Law> yield(model, batch.link, steps);
    Tank<Derivative, Law>& tank = yield.tank;
    const Derivative zero(Real(0.0));
    const int count = yield_state + directions.count, all = int(tank.parameters.size());
    for (int gait = begin; gait < end; ++gait) {
        load(model, batch, gait, gait + 1, tank.parameters, yield.spring[0]);
        double* const out = rows + std::size_t(gait) * (derivative_count + yield_state) * count;
        for (int first = 0; first < count; first += lanes) {
            YieldingState<Derivative, 1> start{};
            Derivative* const spring[] = {&yield.spring[0].stiffness, &yield.spring[0].damping, &yield.spring[0].rest};
            for (int i = 0; i < yield_state; ++i)
                component(start, i) = Derivative(Real(state[std::size_t(gait) * yield_state + i]));
            for (int k = 0; k < lanes; ++k) {
                const int at = std::min(first + k, count - 1), direction = at - yield_state;
                for (int i = 0; i < yield_state; ++i) set_lane(component(start, i).d[0], k, at == i ? 1.0 : 0.0);
                const auto part = [&](int i) {
                    return direction < 0 ? 0.0 : directions.along[std::size_t(i) * directions.count + direction];
                };
                for (int i = 0; i < all; ++i) set_lane(tank.parameters[i].d[0], k, part(i));
                for (int i = 0; i < 3; ++i) set_lane(spring[i]->d[0], k, part(all + i));
            }
            const auto body = yield.fill();
            const auto b = body.measure(start);
            const Beat<Derivative> beat{b.end.body,    b.displacement, b.power, b.power_positive, b.loss,
                                        b.torque_peak, b.excursion,    b.arc,   b.radius,         b.advance};
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
                for (int k = 0; k < lanes && first + k < count; ++k) row[first + k] = lane(result.d[0], k);
                row += count;
            };
            for (const auto& [about, of] : quantities<Derivative>)
                if (about.differentiable) write(of(m));
            YieldingState<Derivative, 1> last = b.end;
            for (int i = 0; i < yield_state; ++i) write(component(last, i));
        }
    }
}

void gradient_any(const Model& model, const YieldBatch& batch, const Directions& directions, int begin, int end,
                  const double* state, int steps, double mass, double* rows) {
    with_law<Derivative>(model.law, [&](auto law) {
        gradient_of<typename decltype(law)::type>(model, batch, directions, begin, end, state, steps, mass, rows);
    });
}

void bends_any(const Model& model, const YieldBatch& batch, const double* state, int steps, int count, double* out) {
    with_law<Real>(model.law, [&](auto law) {
        YieldTank<Real, typename decltype(law)::type> yield(model, batch.link, steps);
        load(model, batch, 0, 1, yield.tank.parameters, yield.spring[0]);
        const auto body = yield.fill();
        State y = filled<State>(Real(0.0));
        for (int i = 0; i < yield_state; ++i) component(y, i) = Real(state[i]);
        for (int n = 0; n < count; ++n) {
            const int k = 2 * (n % steps);
            Hung<Real, 1> hung[max_hung];
            const auto now = body.move(k, y, hung);
            Real acceleration[1];
            body.bend(k, y, now, acceleration);
            const Real numbers[] = {y.angle[0], now.rate[0], acceleration[0]};
            for (int i = 0; i < 3; ++i) out[3 * n + i] = lane(numbers[i], 0);
            y = runge_kutta_4(body.period * Real(1.0 / steps), y, [&](int half, const State& at) {
                Twist<Real> xi;
                return body.rate(k + half, at, xi);
            });
        }
    });
}

double reduced_any(const Model& model, int hinge) {
    double inertia = 0;
    with_law<Real>(model.law, [&](auto law) {
        YieldTank<Real, typename decltype(law)::type> yield(model, hinge, 4);
        inertia = lane(yield.reduced(), 0);
    });
    return inertia;
}

#define HYPERTUNA_JOIN(a, b) a##b
#define HYPERTUNA_NAME(arch) HYPERTUNA_JOIN(kernel_, arch)

}  // namespace hypertuna::inline HYPERTUNA_ARCH

namespace hypertuna {

extern const YieldKernel HYPERTUNA_NAME(HYPERTUNA_ARCH);
const YieldKernel HYPERTUNA_NAME(HYPERTUNA_ARCH) = {settle_any, gradient_any, bends_any, reduced_any, yield_column};

}  // namespace hypertuna
