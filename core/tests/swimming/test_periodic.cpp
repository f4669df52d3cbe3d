/// Tests of the settled beat: Newton's method against waiting, the monodromy against finite differences, the order of
/// Runge-Kutta, gaits that give NaN beside gaits that settle, and a state with more coordinates.
#include <complex>
#include <limits>

#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/swimming/periodic.hpp"

using namespace hypertuna;
using Four = Lanes<double, 4>;

template <class Fish>
static auto settle_by_newton(const Fish& fish) {
    return settle(fish.body(), fish.brisk(), 60);
}

static double distance(const Momentum<double>& a, const Momentum<double>& b) {
    return std::fmax(std::fmax(std::fabs(a.x - b.x), std::fabs(a.y - b.y)), std::fabs(a.z - b.z));
}

static void cramer_and_elimination() {
    const Matrix<double, 3> a = {{{2, 1, 0}, {0, 3, -1}, {1, 0, 4}}}, pivotless = {{{0, 3, -1}, {2, 0, 0}, {1, 0, 4}}};
    CHECK_NEAR(distance(solve(a, {2 * 5 + 1 * 7, 3 * 7 - 11, 5 + 4 * 11}), {5, 7, 11}), 0, 1e-14);
    const Planar<double> b{3 * 7 - 11, 2 * 5, 5 + 4 * 11};
    CHECK_NEAR(distance(solve(pivotless, b), {5, 7, 11}), 0, 1e-14);
    CHECK_NEAR(distance(solve<double, 3, Planar<double>>(pivotless, b), {5, 7, 11}), 0, 1e-14);
}

template <class Law>
static void newton_equals_waiting() {
    const Fish<double, Law> fish(2.0, 0.2);
    const Settled<double> solved = settle_by_newton(fish);
    const Settled<double> waited = wait(fish.body(), fish.rest(), 400);
    CHECK(solved.distance < settle_tolerances.settled && solved.beats < 20);
    const double allowed = settle_tolerances.settled * 0.2;  // of the distance that is traveled, 0.12 to 0.17 m
    CHECK_NEAR(distance(solved.start, waited.start), 0, allowed);
    CHECK_NEAR(solved.beat.displacement.x, waited.beat.displacement.x, allowed);
    CHECK_NEAR(solved.beat.excursion, waited.beat.excursion, allowed);
    CHECK(solved.beat.displacement.x < -0.05 * 0.44);  // it does swim: 5 % of its length a beat and more
    // The water takes the work of the joints: over a settled beat the energy returns to its first value.
    CHECK_NEAR(solved.beat.power / solved.beat.loss, 1, 1e-5);
    CHECK(solved.beat.power_positive >= solved.beat.power);
}

/// Near the settled beat Newton's method converges quadratically: from half the distance, a quarter of the error is
/// left.
template <class Law>
static void quadratic_convergence() {
    const Fish<double, Law> fish(2.0, 0.2);
    const Momentum<double> settled = settle_by_newton(fish).start;
    const auto left = [&](double away) {
        const Momentum<double> P = (1 + away) * settled;
        return distance(P + fish.body().state(newton_step(fish.body(), beat_map(fish.body(), 1, P), P)), settled);
    };
    CHECK(left(0.01) < 1e-3 * distance(settled, {0, 0, 0}));
    CHECK_NEAR(left(0.02) / left(0.01), 4, 0.4);
}

/// A start from rest reaches the settled beat after as many beats as plain waiting takes. It does not reach a beat that
/// it does not lead to, and nothing is simulated for a beat that is NaN.
template <class Law>
static void approach_from_rest() {
    const Fish<double, Law> fish(2.0, 0.2);
    const Momentum<double> settled = settle_by_newton(fish).start;
    const auto follow = [&](const Momentum<double>& target, int beats) { return approach(fish.body(), target, beats); };
    const Approach<double> way = follow(settled, 1000);
    CHECK(way.distance < approach_tolerances.arrived && 5 < way.beats && way.beats < 1000);
    Momentum<double> P = fish.rest();
    for (int k = 0; k < way.beats; ++k) P = fish.body().swim(P, 2);
    CHECK(distance(P, way.end) == 0);
    const Approach<double> backward = follow(-1.0 * settled, 1000);
    CHECK(!(backward.distance < approach_tolerances.arrived));
    CHECK(backward.beats < 1000);  // it settles elsewhere, which ends the search early
    CHECK(follow(settled, 1000).beats < backward.beats);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(follow({nan, 0, 0}, 10).beats == 0);
    CHECK(follow(settled, 3).beats == 3 && follow(settled, 0).beats == 0);
}

template <class Law>
static void monodromy() {
    const Fish<double, Law> fish(2.0, 0.2);
    const Momentum<double> P = fish.brisk();
    const BeatMap<double> map = beat_map(fish.body(), 1, P);
    const auto end = [&](const Momentum<double>& start) { return fish.body().swim(start); };
    CHECK(distance(map.end, end(P)) < 1e-14);
    const double h = 1e-5;
    const Momentum<double> directions[3] = {{h, 0, 0}, {0, h, 0}, {0, 0, h}};
    for (int k = 0; k < 3; ++k) {
        const Momentum<double> rate = 0.5 / h * (end(P + directions[k]) - end(P - directions[k]));
        const auto& m = map.monodromy.a;
        CHECK_NEAR(distance(rate, {m[0][k], m[1][k], m[2][k]}), 0, 1e-6);
    }
}

/// One step of y' = y gives the exponential series up to its fourth power; with twice the steps the error of a beat is
/// 16 times smaller. Drag is linear here, because quadratic drag has a kink in its derivative at every reversal.
static void runge_kutta_order() {
    const double e = runge_kutta_4(1.0, 1.0, [](int, double y) { return y; });
    CHECK_NEAR(e, 1 + 1 + 1 / 2.0 + 1 / 6.0 + 1 / 24.0, 1e-15);

    Fish<double, Strip<double>, 512> fish(2.0, 0.2);
    for (auto& k : fish.coefficients) {
        k.drag = k.beating = k.friction = 0;
        k.linear_drag = 5, k.linear_friction = 0.5;
    }
    stop_shedding(fish.swimmer.water);
    const auto end = [&](int stride) { return fish.body().swim(fish.rest(), stride); };
    const Momentum<double> exact = end(1);
    const double coarse = distance(end(16), exact), middle = distance(end(8), exact), fine = distance(end(4), exact);
    CHECK_NEAR(coarse / middle, 16, 2);
    CHECK_NEAR(middle / fine, 16, 1);
}

/// Without drag the momentum is constant in the axes of the water; it only turns in the body's axes.
static void conservation() {
    Fish<double, Lumped<double>, 256> fish(2.0, 0.2);
    for (auto& k : fish.coefficients) k.friction = k.drag = 0;
    const Momentum<double> P = fish.brisk() + Momentum<double>{0, 0.3 * fish.brisk().x, 0};
    const Beat<double> beat = fish.body().measure(P);
    const auto [x, y, heading] = beat.displacement;
    const double px = std::cos(heading) * beat.end.x - std::sin(heading) * beat.end.y;
    const double py = std::sin(heading) * beat.end.x + std::cos(heading) * beat.end.y;
    CHECK(std::fabs(heading) > 0.01);  // bent to one side, it does turn
    CHECK_NEAR(px, P.x, 1e-9);
    CHECK_NEAR(py, P.y, 1e-9);
    CHECK_NEAR(beat.end.z + x * py - y * px, P.z, 1e-9);
    CHECK(beat.loss == 0);
}

/// Lane 2 has a frequency of NaN; the other lanes must be the same as if it had a valid one, bit for bit.
static void not_a_number() {
    Four frequency(2.0), amplitude(0.2);
    for (int k = 0; k < 4; ++k) frequency.set(k, 1 + 0.5 * k), amplitude.set(k, 0.25 - 0.05 * k);
    const Fish<Four, Lumped<Four>> whole(frequency, amplitude);
    frequency.set(2, std::numeric_limits<double>::quiet_NaN());
    const Fish<Four, Lumped<Four>> broken(frequency, amplitude);
    const Settled<Four> good = settle_by_newton(whole), bad = settle_by_newton(broken);
    for (int k : {0, 1, 3}) {
        CHECK(good.distance[k] < settle_tolerances.settled);
        CHECK(same_bits(good.start.x[k], bad.start.x[k]));
        CHECK(same_bits(good.beat.power[k], bad.beat.power[k]));
        CHECK(same_bits(good.monodromy.a[0][0][k], bad.monodromy.a[0][0][k]));
        CHECK(same_bits(good.beats[k], bad.beats[k]));
    }
    CHECK(!(bad.distance[2] < settle_tolerances.settled));

    const Fish<double, Lumped<double>> alone(std::numeric_limits<double>::quiet_NaN(), 0.2);
    CHECK(!(settle_by_newton(alone).distance < settle_tolerances.settled));
    for (int k = 0; k < 4; ++k) {
        const Fish<double, Lumped<double>> single(1 + 0.5 * k, 0.25 - 0.05 * k);
        CHECK(same_bits(settle_by_newton(single).start.x, good.start.x[k]));
    }
}

/// A state of this test alone: the momentum, and a coordinate on a spring.
template <class S>
struct Sprung {
    static constexpr int size = Momentum<S>::size + 2;
    Planar<S> body;
    S at, rate;

    friend Sprung operator+(const Sprung& a, const Sprung& b) {
        return {a.body + b.body, a.at + b.at, a.rate + b.rate};
    }
    friend Sprung operator-(const Sprung& a, const Sprung& b) {
        return {a.body - b.body, a.at - b.at, a.rate - b.rate};
    }
    friend Sprung operator*(double a, const Sprung& b) { return {a * b.body, a * b.at, a * b.rate}; }
    friend S& component(Sprung& a, int k) {
        return k < a.body.size ? component(a.body, k) : k == a.body.size ? a.at : a.rate;
    }
    friend Sprung select(bool mask, const Sprung& yes, const Sprung& no) { return mask ? yes : no; }
};
template <class V>
static Sprung<V> widen(const Sprung<double>& a) {
    return {widen<V>(a.body), V(a.at), V(a.rate)};
}

/// A swimmer that carries the spring: at'' = pull sin(2 pi f t) - damping at' - stiffness at.
template <class Law>
struct SprungSwimmer : PeriodicSwimmer<double, Law> {
    using Plain = PeriodicSwimmer<double, Law>;
    using State = Sprung<double>;
    double pull, damping, stiffness;

    template <class V>
    Sprung<V> swim(Sprung<V> y, int stride_instants = 1) const {
        const int instants = this->table.instants;
        for (int k = 0; k < instants; k += 2 * stride_instants)
            y = runge_kutta_4(this->period * 2 * stride_instants / instants, y, [&](int half, const Sprung<V>& now) {
                const int instant = k + half * stride_instants;
                const Instant<double> shape = this->table[instant];
                return Sprung<V>{
                    momentum_rate(this->fish, shape, now.body, twist(shape, now.body)), now.rate,
                    pull * std::sin(2 * pi * instant / instants) - damping * now.rate - stiffness * now.at};
            });
        return y;
    }
    Beat<double, State> measure(const State& P) const {
        Beat<double, State> beat{};
        beat.end = swim(P), beat.displacement = Plain::measure(P.body).displacement;
        return beat;
    }
    State motion(const State& change) const { return {Plain::motion(change.body), change.at, change.rate}; }
    State state(const State& d) const { return {Plain::state(d.body), d.at, d.rate}; }
    double size(const State& d) const {
        return std::fmax(Plain::size(d.body), std::fmax(std::fabs(d.at), this->period * std::fabs(d.rate)));
    }
    double stride(const State& P) const { return Plain::stride(P.body); }
    State step_in_square(const State& d, const State& P) const {
        return {Plain::step_in_square(d.body, P.body), d.at, d.rate};
    }
};

/// The settled beat of a larger state: the spring answers with the transfer function H(i w), and the swimmer moves as
/// it does without the spring.
template <class Law>
static void spring_beside_the_momentum() {
    const Fish<double, Law, 256> fish(2.0, 0.2);
    const double w = 2 * pi * 2.0, pull = 30, damping = 0.3 * w, stiffness = 2.25 * w * w;
    const SprungSwimmer<Law> body{{fish.body()}, pull, damping, stiffness};
    const std::complex<double> response = pull / std::complex<double>(stiffness - w * w, damping * w);
    const Settled<double> plain = settle_by_newton(fish);
    const auto compare = [&](const Sprung<double>& start, double allowed) {
        CHECK_NEAR(start.at / std::abs(response), response.imag() / std::abs(response), allowed);
        CHECK_NEAR(start.rate / std::abs(response) / w, response.real() / std::abs(response), allowed);
        CHECK_NEAR(distance(start.body, plain.start) / distance(plain.start, {0, 0, 0}), 0, allowed);
    };
    const auto solved = settle(body, Sprung<double>{fish.brisk(), 0, 0}, 60);
    CHECK(solved.distance < settle_tolerances.settled && solved.beats < 20);
    compare(solved.start, 1e-6);
    const auto waited = wait(body, Sprung<double>{}, 400);
    compare(waited.start, 1e-6);
    CHECK_NEAR(solved.beat.displacement.x / plain.beat.displacement.x, 1, 1e-6);
    // A disturbance of the spring decays by e^(-damping / 2) a second in both of its numbers.
    const auto& m = solved.monodromy.a;
    CHECK_NEAR((m[3][3] * m[4][4] - m[3][4] * m[4][3]) / std::exp(-damping / 2.0), 1, 1e-6);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) CHECK_NEAR(m[i][k], plain.monodromy.a[i][k], 1e-3);
    CHECK(approach(body, solved.start, 1000).distance < approach_tolerances.arrived);
    CHECK(!(approach(body, -1.0 * solved.start, 1000).distance < approach_tolerances.arrived));
}

int main() {
    cramer_and_elimination();
    WaterLaws::each<double>([](auto law) {
        using Law = typename decltype(law)::type;
        newton_equals_waiting<Law>();
        quadratic_convergence<Law>();
        approach_from_rest<Law>();
        monodromy<Law>();
        spring_beside_the_momentum<Law>();
    });
    runge_kutta_order();
    conservation();
    not_a_number();
    return failures();
}
