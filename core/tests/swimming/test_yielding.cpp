/// Joints that yield: their dynamics against the twin's, energy, the stiff limit, similarity, and starts from rest.
#include <initializer_list>
#include <memory>

#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/simulation/tail.hpp"
#include "hypertuna/swimming/yielding_beat.hpp"

using namespace hypertuna;

/// A Fish whose last D joints yield and are not driven.
template <class Law, int D, int steps>
struct Yielding {
    using Body = YieldingSwimmer<double, Law, D>;
    using State = YieldingState<double, D>;
    static constexpr int links = Fish<double, Law>::links, first = links - D;

    Fish<double, Law, steps> fish;
    int behind[D];
    JointMotion<double> table[2 * steps * links], joint[links];
    Composite<double> ahead[2 * steps];
    double moment[2 * steps][D];
    LinkShape<double> shape[links];
    LinkAcceleration<double> acceleration[links];
    Spring<double> spring[D];
    Swinging<double, D> swings;

    Yielding(double frequency, double amplitude, double stiffness, double damping, double rest)
        : fish(frequency, amplitude) {
        for (int d = 0; d < D; ++d) {
            behind[d] = first + d;
            fish.joints[first + d] = {-1, 0};
            spring[d] = {stiffness, damping, rest, 0.5 * stiffness, 0.2, 5 * stiffness, 0.1, 0, 0};
        }
        fill();
    }
    /// Let moments drive the joints too.
    void drive() {
        for (int d = 0; d < D; ++d) spring[d].moment = 0.05, spring[d].moment_phase = 0.7 + d;
        fill();
    }
    YieldTable<double, D> yields() { return {behind, table, ahead, moment}; }
    void fill() {
        tabulate_yielding(fish.swimmer, fish.joints, fish.swings, fish.frequency, spring, fish.table, yields());
    }
    Body body() {
        Body out{fish.swimmer, fish.joints,  fish.table, yields(), fish.length,  fish.period,
                 {},           fish.scratch, joint,      shape,    acceleration, &swings};
        for (int d = 0; d < D; ++d) out.spring[d] = spring[d];
        return out;
    }
    State guess() const { return {fish.brisk(), {}, {}}; }
    Settled<double, State> settled() {
        const auto found = settle(body(), guess(), 60);
        CHECK(found.retry == 0 && found.distance < settle_tolerances.settled);
        return found;
    }
};

/// Accelerations of the coordinates from inverse dynamics equal the twin's forward dynamics, and momenta change as the
/// rates of the state say.
template <class Law, int D>
static void forward_dynamics() {
    constexpr int steps = 256;
    Yielding<Law, D, steps> fish(2, 0.2, 0.5, 0.01, 0.1);
    fish.drive();
    const auto body = fish.body();
    YieldingState<double, D> y{{-0.3, 0.05, 0.01}, {}, {}};
    for (int d = 0; d < D; ++d) y.angle[d] = 0.2 - 0.1 * d, y.momentum[d] = 0.002 * (d + 1);
    Hung<double, D> hung;
    const int k = 37;
    const Moving<double, D> now = body.move(k, y, hung);
    double accelerations[D];
    body.bend(k, y, now, accelerations);
    // The twin's coordinates: all joints, of which the driven ones have the accelerations of the gait.
    constexpr int links = Fish<double, Law>::links;
    const Composite<double> whole = composite(fish.fish.swimmer, fish.shape);
    const Momentum<double> P = whole.inertia * now.xi + whole.momentum;
    CHECK_NEAR(P.x, y.body.x, 1e-13), CHECK_NEAR(P.y, y.body.y, 1e-13), CHECK_NEAR(P.z, y.body.z, 1e-13);
    double torque[links];
    const Symmetric<double> mobility = inverse(whole.inertia);
    joint_torques(fish.fish.swimmer, Instant<double>{fish.shape, fish.acceleration, mobility, whole.momentum}, now.xi,
                  torque);
    for (int d = 0; d < D; ++d)
        CHECK_NEAR(torque[fish.first + d], fish.spring[d].passive(y.angle[d], now.rate[d]) + fish.moment[k][d], 1e-12);
    double all[links][links - 1] = {};
    double armature[links - 1] = {}, moment[links - 1];
    Bend<double, links - 1> bend;
    for (int i = 1; i < links; ++i) {
        all[i][i - 1] = 1;
        bend.angle[i - 1] = fish.joint[i].angle, bend.rate[i - 1] = fish.joint[i].rate, moment[i - 1] = torque[i];
    }
    JointMotion<double> joint[links];
    LinkShape<double> shape[links];
    LinkAcceleration<double> acceleration[links];
    const Tail<double, Law, links - 1> tail{fish.fish.swimmer, all, false, armature, joint, shape, acceleration};
    const auto twin = tail_acceleration(tail, bend, now.xi, moment);
    for (int i = 1; i < links; ++i)
        CHECK_NEAR(twin.bend[i - 1], fish.joint[i].acceleration, 1e-9 * (1 + std::fabs(fish.joint[i].acceleration)));
    // dp/dt is what the momenta are a moment later, along the accelerations.
    const double h = 1e-6;
    Twist<double> xi;
    const YieldingState<double, D> rate = body.rate(k, y, xi);
    for (int d = 0; d < D; ++d) CHECK_NEAR(rate.angle[d], now.rate[d], 1e-14);
    double change[2][D];
    for (int side = 0; side < 2; ++side) {
        const double dt = side ? h : -h;
        JointMotion<double> later[links];
        for (int i = 0; i < links; ++i) {
            const JointMotion<double>& at = fish.joint[i];
            later[i] = {at.angle + dt * (at.rate + 0.5 * dt * at.acceleration), at.rate + dt * at.acceleration, 0};
        }
        const Twist<double> moved = now.xi + dt * twin.twist;
        hypertuna::shape(links, fish.fish.link, later, shape, acceleration);
        for (int d = 0; d < D; ++d) {
            change[side][d] = 0;
            const Planar<double> at = joint_position(shape[fish.first + d], fish.fish.link[fish.first + d]);
            for (int i = fish.first + d; i < links; ++i) {
                const Momentum<double> own =
                    shape[i].wrench(fish.fish.swimmer.water.inertia(i) * shape[i].velocity(moved));
                change[side][d] += own.z - (at.x * own.y - at.y * own.x);
            }
        }
    }
    for (int d = 0; d < D; ++d) {
        const double slope = (change[1][d] - change[0][d]) / (2 * h);
        CHECK_NEAR(rate.momentum[d] / (1e-3 + std::fabs(slope)), slope / (1e-3 + std::fabs(slope)), 1e-7);
    }
}

/// Derivatives of the rate by every number of the state equal differences; its value is that without derivatives.
template <class Law, int D>
static void derivatives() {
    constexpr int size = 3 + 2 * D;
    Yielding<Law, D, 64> fish(2, 0.2, 0.5, 0.01, 0.1);
    fish.drive();
    const auto body = fish.body();
    YieldingState<double, D> y{{-0.3, 0.05, 0.01}, {}, {}};
    for (int d = 0; d < D; ++d) y.angle[d] = 0.25 - 0.2 * d, y.momentum[d] = 0.002 * (d + 1);
    auto with = widen<Dual<double, size>>(y);
    for (int n = 0; n < size; ++n) component(with, n).d[n] = 1;
    Twist<double> xi;
    const int k = 37;
    const auto rate = body.rate(k, with);
    const YieldingState<double, D> value = body.rate(k, y, xi);
    for (int n = 0; n < size; ++n) {
        CHECK_NEAR(component(rate, n).v, component(value, n), 1e-12 * (1 + std::fabs(component(value, n))));
        const double h = 1e-6;
        YieldingState<double, D> more = y, less = y;
        component(more, n) += h, component(less, n) -= h;
        const YieldingState<double, D> change = body.rate(k, more, xi) - body.rate(k, less, xi);
        for (int i = 0; i < size; ++i) {
            const double slope = component(change, i) / (2 * h);
            CHECK_NEAR(component(rate, i).d[n] - slope, 0, 1e-6 * (1 + std::fabs(slope)));
        }
    }
}

/// Work in equals losses, at fourth order.
template <class Law, int D>
static void energy() {
    double off[2];
    const auto balance = [&](auto& fish) {
        fish.drive();
        const auto found = fish.settled();
        double taken = 0;
        for (const double power : fish.swings.damping) taken += power;
        CHECK(taken > 1e-3 * found.beat.power);
        return found.beat.power / (found.beat.loss + taken) - 1;
    };
    auto coarse = std::make_unique<Yielding<Law, D, 128>>(2, 0.2, 1.0, 0.01, 0.0);
    auto fine = std::make_unique<Yielding<Law, D, 512>>(2, 0.2, 1.0, 0.01, 0.0);
    off[0] = balance(*coarse), off[1] = balance(*fine);
    // 256 times smaller, except for the kinks of drag; soft tails of a plate that turns much have larger kinks.
    CHECK(std::fabs(off[0]) < 2e-4 && std::fabs(off[1]) < std::fabs(off[0]) / 40);
}

/// The settled beat is the beat to which beats from rest converge.
template <class Law, int D>
static void newton_equals_waiting() {
    auto fish = std::make_unique<Yielding<Law, D, 64>>(2, 0.2, 1.0, 0.01, 0.05);
    fish->drive();
    const auto found = fish->settled();
    const auto waited = wait(fish->body(), YieldingState<double, D>{}, 400);
    YieldingState<double, D> apart = found.start - waited.start, start = found.start;
    for (int k = 0; k < 3 + 2 * D; ++k)
        CHECK_NEAR(component(apart, k) / (1e-3 + std::fabs(component(start, k))), 0, 1e-6);
    CHECK_NEAR(waited.beat.power / found.beat.power, 1, 1e-8);
    // Another solution from there is the same, to rounding.
    Search<double, YieldingState<double, D>> search = search_from(found.start, 0.0);
    newton(fish->body(), 1, 1e-9, false, 10, search);
    apart = search.P - waited.start;
    for (int k = 0; k < 3 + 2 * D; ++k)
        CHECK_NEAR(component(apart, k) / (1e-3 + std::fabs(component(start, k))), 0, 1e-9);
}

/// A stiff joint moves like a prescribed one: the difference falls in proportion to its compliance.
template <class Law>
static void stiff_limit() {
    Fish<double, Law, 512> rigid(2, 0.2);
    rigid.joints[3] = {-1, 0};
    rigid.fill();
    const auto prescribed = settle(rigid.body(), rigid.brisk(), 60);
    double off[2];
    for (int k = 0; k < 2; ++k) {
        auto fish = std::make_unique<Yielding<Law, 1, 512>>(2, 0.2, k ? 200.0 : 100.0, 0.0, 0.0);
        off[k] = fish->settled().beat.arc / prescribed.beat.arc - 1;
    }
    CHECK(std::fabs(off[0]) < 0.02);
    CHECK_NEAR(off[0] / off[1], 2, 0.05);
}

/// In water that is quadratic alone, stiffness as the square of the frequency and damping as the frequency give the
/// same motion: here by 2, which rounds nothing.
static void similarity() {
    using Law = Elongated<double>;
    auto slow = std::make_unique<Yielding<Law, 1, 64>>(1, 0.2, 1.0, 0.01, 0.05);
    auto fast = std::make_unique<Yielding<Law, 1, 64>>(2, 0.2, 4.0, 0.02, 0.05);
    for (auto* fish : {slow.get(), fast.get()}) {
        for (int g = 0; g < 2; ++g) fish->fish.harmonics[g].bandwidth = 5 * fish->fish.frequency;
        for (int g = 0; g < 2; ++g) fish->fish.swings[g] = response(fish->fish.harmonics[g], fish->fish.frequency);
        fish->fill();
    }
    const auto a = slow->settled(), b = fast->settled();
    CHECK_NEAR(b.beat.arc / a.beat.arc, 1, 1e-12);
    CHECK_NEAR(b.beat.power / (8 * a.beat.power), 1, 1e-12);
    CHECK_NEAR(b.start.angle[0], a.start.angle[0], 1e-12);
}

/// The inertia against which a joint turns the free body is that of the state's equations.
static void inertia_of_a_joint() {
    auto fish = std::make_unique<Yielding<Elongated<double>, 1, 64>>(2, 0.0, 1.0, 0.0, 0.0);
    for (int g = 0; g < 2; ++g) fish->fish.swings[g] = {0, 0, 0};
    fish->fill();
    Hung<double, 1> hung;
    const auto now = fish->body().move(0, YieldingState<double, 1>{}, hung);
    const auto reduced = [](auto& fish, std::initializer_list<int> hinges) {
        return reduced_inertia(fish->fish.swimmer, hinges.begin(), int(hinges.size()), fish->shape, fish->acceleration,
                               fish->joint);
    };
    CHECK_NEAR(reduced(fish, {3}) / now.reduced[0][0], 1, 1e-13);
    // Two joints that turn alike: their own inertias, and twice the coupling between them.
    auto both = std::make_unique<Yielding<Elongated<double>, 2, 64>>(2, 0.0, 1.0, 0.0, 0.0);
    for (int g = 0; g < 2; ++g) both->fish.swings[g] = {0, 0, 0};
    both->fill();
    Hung<double, 2> hung_both;
    const auto pair = both->body().move(0, YieldingState<double, 2>{}, hung_both);
    const double own = pair.reduced[0][0] + pair.reduced[1][1];
    CHECK_NEAR(reduced(both, {2, 3}) / (own + 2 * pair.reduced[1][0]), 1, 1e-13);
}

int main() {
    WaterLaws::each<double>([](auto law) {
        using Law = typename decltype(law)::type;
        forward_dynamics<Law, 1>();
        forward_dynamics<Law, 2>();
        derivatives<Law, 1>();
        derivatives<Law, 3>();
        energy<Law, 1>();
        energy<Law, 2>();
        newton_equals_waiting<Law, 1>();
        newton_equals_waiting<Law, 2>();
        stiff_limit<Law>();
    });
    similarity();
    inertia_of_a_joint();
    return failures();
}
