/// The kernels of joints that yield, compiled once for each instruction set, which HYPERTUNA_ARCH names.
#include "hypertuna/host/yielding.hpp"

#include <algorithm>

#include "hypertuna/host/rows.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A tank for a body with D joints that yield.
template <class S, class Law, int D>
struct YieldTank {
    using Body = YieldingSwimmer<S, Law, D>;
    Tank<S, Law> tank;
    Spring<S> spring[D];
    Swinging<S, D> swings;

    YieldTank(const Model& model, const int* hinges, int steps)
        : tank(model, steps),
          spring{},
          swings{},
          hinges_(hinges),
          length_(model.length),
          table_(2 * steps * model.links),
          ahead_(2 * steps),
          moment_(2 * steps),
          joint_(model.links),
          shape_(model.links),
          acceleration_(model.links) {}

    /// Read the parameters and tabulate the beat.
    Body fill() {
        tank.read();
        static_assert(sizeof(Moments) == sizeof(S[D]));
        const YieldTable<S, D> yields{hinges_, table_.data(), ahead_.data(), &moment_.data()->of};
        tabulate_yielding(tank.fish, tank.joints.data(), tank.swings.data(), tank.frequency, spring, tank.table,
                          yields);
        Body body{tank.fish,
                  tank.joints.data(),
                  tank.table,
                  yields,
                  S(base_t<S>(length_)),
                  S(base_t<S>(1)) / tank.frequency,
                  {},
                  tank.scratch,
                  joint_.data(),
                  shape_.data(),
                  acceleration_.data(),
                  &swings};
        std::copy(spring, spring + D, body.spring);
        return body;
    }

  private:
    struct Moments {
        S of[D];
    };
    const int* hinges_;
    double length_;
    std::vector<JointMotion<S>> table_;
    std::vector<Composite<S>> ahead_;
    std::vector<Moments> moment_;
    std::vector<JointMotion<S>> joint_;
    std::vector<LinkShape<S>> shape_;
    std::vector<LinkAcceleration<S>> acceleration_;
};

/// Write gaits into the lanes of parameters and springs; beyond the last gait the last one is repeated.
template <class S, class Law, int D>
void load(const Model& model, const YieldBatch& batch, int first, int end, YieldTank<S, Law, D>& yield) {
    load_gaits(model, batch.gaits, first, end, yield.tank.parameters);
    for (int k = 0; k < lanes; ++k) {
        const double* number = batch.spring + std::size_t(std::min(first + k, end - 1)) * D * spring_numbers;
        for (Spring<S>& spring : yield.spring)
            for (int i = 0; i < spring_numbers; ++i) put_lane(component(spring, i), k, *number++);
    }
}

/// Call work with the law and the number of hinges.
template <class S, class Work>
void with_yielding(const Model& model, int hinges, const Work& work) {
    with_law<S>(model.law, [&](auto law) {
        with_hinges(hinges, [&](auto D) { work.template operator()<typename decltype(law)::type, D.value>(); });
    });
}

int width_of_row(int hinges) { return row_width(yield_state(hinges)) + yield_swings(hinges); }

void settle_any(const Model& model, const YieldBatch& batch, const SettleOptions& options, int begin, int end,
                double* rows) {
    with_yielding<Real>(model, batch.hinges, [&]<class Law, int D>() {
        YieldTank<Real, Law, D> yield(model, batch.links, options.steps);
        for (int first = begin; first < end; first += lanes) {
            load(model, batch, first, end, yield);
            const auto body = yield.fill();
            LaneRows write{rows, width_of_row(D), first, end};
            const auto found = settle_into(model, body, yield.tank, options, write);
            if (any(Real(0.0) < found.retry))
                body.measure(found.start);  // the beat measured last was that of another start
            const Swinging<Real, D>& swings = yield.swings;
            for (int d = 0; d < D; ++d)
                for (const Real& value :
                     {swings.mean[d], swings.sine[d], swings.cosine[d], swings.peak[d], swings.damping[d]})
                    write(value);
        }
    });
}

using Derivative = Dual<Real, 1>;

/// Write derivatives of the beat in the tank with respect to the start and along the directions, one lane for each.
template <class Law, int D>
void gradient_of(const Model& model, const Directions& directions, const double* state, double mass,
                 YieldTank<Derivative, Law, D>& yield, double* out) {
    constexpr int size = yield_state(D);
    const int count = size + directions.count, all = int(yield.tank.parameters.size());
    for (int first = 0; first < count; first += lanes) {
        YieldingState<Derivative, D> start{};
        for (int i = 0; i < size; ++i) component(start, i) = Derivative(Real(state[i]));
        for (int k = 0; k < lanes; ++k) {
            const int at = std::min(first + k, count - 1), direction = at - size;
            for (int i = 0; i < size; ++i) set_lane(component(start, i).d[0], k, at == i ? 1.0 : 0.0);
            const auto part = [&](int i) {
                return direction < 0 ? 0.0 : directions.along[std::size_t(i) * directions.count + direction];
            };
            for (int i = 0; i < all; ++i) set_lane(yield.tank.parameters[i].d[0], k, part(i));
            for (int i = 0; i < D * spring_numbers; ++i)
                set_lane(component(yield.spring[i / spring_numbers], i % spring_numbers).d[0], k, part(all + i));
        }
        auto beat = yield.fill().measure(start);
        const Measured<Derivative> m = measured(beat, yield.tank, model.length, mass);
        double* row = out;
        const auto write = [&](const Derivative& result) {
            for (int k = 0; k < lanes && first + k < count; ++k) row[first + k] = lane(result.d[0], k);
            row += count;
        };
        for (const auto& [about, of] : quantities<Derivative>)
            if (about.differentiable) write(of(m));
        for (int i = 0; i < size; ++i) write(component(beat.end, i));
    }
}

void gradient_any(const Model& model, const YieldBatch& batch, const Directions& directions, int begin, int end,
                  const double* state, int steps, double mass, double* rows) {
    with_yielding<Derivative>(model, batch.hinges, [&]<class Law, int D>() {
        constexpr int size = yield_state(D);
        YieldTank<Derivative, Law, D> yield(model, batch.links, steps);
        for (int gait = begin; gait < end; ++gait) {
            load(model, batch, gait, gait + 1, yield);
            gradient_of(model, directions, state + std::size_t(gait) * size, mass, yield,
                        rows + std::size_t(gait) * (derivative_count + size) * (size + directions.count));
        }
    });
}

void bends_any(const Model& model, const YieldBatch& batch, const double* state, int steps, int count, double* out) {
    with_yielding<Real>(model, batch.hinges, [&]<class Law, int D>() {
        YieldTank<Real, Law, D> yield(model, batch.links, steps);
        load(model, batch, 0, 1, yield);
        const auto body = yield.fill();
        YieldingState<Real, D> y;
        for (int i = 0; i < yield_state(D); ++i) component(y, i) = Real(state[i]);
        for (int n = 0; n < count; ++n) {
            const int k = 2 * (n % steps);
            Hung<Real, D> hung;
            const auto now = body.move(k, y, hung);
            Real acceleration[D];
            body.bend(k, y, now, acceleration);
            for (int d = 0; d < D; ++d)
                for (const Real& number : {y.angle[d] + yield.spring[d].rest, now.rate[d], acceleration[d]})
                    *out++ = lane(number, 0);
            y = runge_kutta_4(body.period * Real(1.0 / steps), y, [&](int half, const auto& at) {
                Twist<Real> xi;
                return body.rate(k + half, at, xi);
            });
        }
    });
}

double reduced_any(const Model& model, const int* links, int hinges) {
    double inertia = 0;
    with_law<Real>(model.law, [&](auto law) {
        Tank<Real, typename decltype(law)::type> tank(model, 4);
        std::vector<LinkShape<Real>> shape(model.links);
        std::vector<LinkAcceleration<Real>> acceleration(model.links);
        std::vector<JointMotion<Real>> joint(model.links);
        inertia = lane(reduced_inertia(tank.fish, links, hinges, shape.data(), acceleration.data(), joint.data()), 0);
    });
    return inertia;
}

#define HYPERTUNA_JOIN(a, b) a##b
#define HYPERTUNA_NAME(arch) HYPERTUNA_JOIN(kernel_, arch)

}  // namespace hypertuna::inline HYPERTUNA_ARCH

namespace hypertuna {

extern const YieldKernel HYPERTUNA_NAME(HYPERTUNA_ARCH);
const YieldKernel HYPERTUNA_NAME(HYPERTUNA_ARCH) = {settle_any, gradient_any, bends_any, reduced_any, width_of_row};

}  // namespace hypertuna
