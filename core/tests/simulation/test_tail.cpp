/// Tests of the tail's forward dynamics: cases by hand, the inverse of the prescribed motion, energy and symmetry.
#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/simulation/tail.hpp"
#include "hypertuna/swimming/stepping.hpp"

using namespace hypertuna;

/// A tail on the body of a Fish, one coordinate per joint group and one for a hinge at the last link.
template <class Law>
struct FreeTail {
    static constexpr int D = 3;
    Fish<double, Law> fish{2, 0.2};
    double share[Fish<double, Law>::links][D] = {{0, 0, 0}, {1, 0, 0}, {0, 0.5, 0}, {0, 0.5, 1}};
    JointMotion<double> joint[4];
    LinkShape<double> shape[4];
    LinkAcceleration<double> acceleration[4];
    double armature[D] = {};
    Tail<double, Law, D> tail{fish.swimmer, share, false, armature, joint, shape, acceleration};
};

/// A chain of uniform rods, 2 kg and 0.3 m each, in a vacuum; one coordinate, the last joint.
template <int links>
struct Rods {
    Link<double> link[links];
    Lumped<double>::Coefficients dry[links];
    double share[links][1] = {};
    JointMotion<double> joint[links];
    LinkShape<double> shape[links];
    LinkAcceleration<double> acceleration[links];
    double armature[1] = {};
    Tail<double, Lumped<double>, 1> tail{{links, link, {dry}}, share, false, armature, joint, shape, acceleration};

    Rods() {
        for (int i = 0; i < links; ++i) {
            link[i] = {0.3, 0.15, 2, 2 * 0.09 / 12};
            dry[i] = {2, 2 * 0.09 / 12, 0, 0};
        }
        share[links - 1][0] = 1;
    }
    Rods(const Rods&) = delete;
};

/// Clamped at the head, a rod turns about its end: moment / (m l^2 / 3). Free, two straight rods turn about their own
/// centers of mass, which no force moves: each by moment / (m l^2 / 12), one against the other.
static void rods_by_hand() {
    Rods<2> rods;
    const double moment[1] = {0.7};
    const TailAcceleration<double, 1> free = tail_acceleration(rods.tail, {{0.0}, {0.0}}, {0, 0, 0}, moment);
    const double turn = 0.7 / (2 * 0.09 / 12);
    CHECK_NEAR(free.bend[0], 2 * turn, 1e-12);
    CHECK_NEAR(free.twist.z, -turn, 1e-12);
    CHECK_NEAR(free.twist.y, 0.15 * turn, 1e-12);  // the nose is ahead of the first rod's center
    CHECK_NEAR(free.twist.x, 0, 1e-12);
    rods.tail.clamped = true;
    const TailAcceleration<double, 1> held = tail_acceleration(rods.tail, {{0.4}, {3.0}}, {0, 0, 0}, moment);
    CHECK_NEAR(held.bend[0], 0.7 / (2 * 0.09 / 3), 1e-12);
    CHECK(held.twist.x == 0 && held.twist.y == 0 && held.twist.z == 0);
}

static void cholesky_by_hand() {
    // L = (2 . ., 1 3 ., -1 2 1), A = L L^T, x = (1, -2, 3)
    double a[3][3] = {{4, 0, 0}, {2, 10, 0}, {-2, 5, 6}}, b[3] = {4 - 4 - 6, 2 - 20 + 15, -2 - 10 + 18};
    solve_cholesky(a, b);
    CHECK_NEAR(b[0], 1, 1e-14);
    CHECK_NEAR(b[1], -2, 1e-14);
    CHECK_NEAR(b[2], 3, 1e-14);
}

/// The moments of a motion by inverse dynamics reproduce its accelerations, also of the head.
template <class Law>
static void inverse_of_prescribed_motion() {
    FreeTail<Law> free;
    Random random;
    constexpr int links = 4, D = 3;
    for (int round = 0; round < 100; ++round) {
        Bend<double, D> bend;
        double wanted[D], torque[links], moment[D] = {};
        for (int d = 0; d < D; ++d) {
            bend.angle[d] = random(-0.7, 0.7);
            bend.rate[d] = random(-10, 10);
            wanted[d] = random(-300, 300);
        }
        const Twist<double> xi{random(-1, 1), random(-1, 1), random(-5, 5)};
        JointMotion<double> joint[links] = {};
        for (int i = 0; i < links; ++i)
            for (int d = 0; d < D; ++d) {
                joint[i].angle += free.share[i][d] * bend.angle[d];
                joint[i].rate += free.share[i][d] * bend.rate[d];
                joint[i].acceleration += free.share[i][d] * wanted[d];
            }
        tabulate(free.fish.swimmer, joint, 0, free.fish.table);
        const Instant<double> now = free.fish.table[0];
        const Twist<double> head = acceleration(free.fish.swimmer, now, xi);
        joint_torques(free.fish.swimmer, now, xi, torque);
        for (int i = 0; i < links; ++i)
            for (int d = 0; d < D; ++d) moment[d] += free.share[i][d] * torque[i];
        const TailAcceleration<double, D> got = tail_acceleration(free.tail, bend, xi, moment);
        for (int d = 0; d < D; ++d) CHECK_NEAR(got.bend[d], wanted[d], 1e-10 * 300);
        CHECK_NEAR(got.twist.x, head.x, 1e-10 * 100);
        CHECK_NEAR(got.twist.y, head.y, 1e-10 * 100);
        CHECK_NEAR(got.twist.z, head.z, 1e-10 * 300);
    }
}

/// State of a free tail for the integrator.
struct Swinging {
    Twist<double> xi;
    Bend<double, 3> bend;
    friend Swinging operator*(double a, const Swinging& b) {
        Swinging out{a * b.xi, {}};
        for (int d = 0; d < 3; ++d) out.bend.angle[d] = a * b.bend.angle[d], out.bend.rate[d] = a * b.bend.rate[d];
        return out;
    }
    friend Swinging operator+(const Swinging& a, const Swinging& b) {
        Swinging out{a.xi + b.xi, {}};
        for (int d = 0; d < 3; ++d) {
            out.bend.angle[d] = a.bend.angle[d] + b.bend.angle[d];
            out.bend.rate[d] = a.bend.rate[d] + b.bend.rate[d];
        }
        return out;
    }
};

static constexpr double spring = 2.0;  // N m/rad on every coordinate

template <class Law>
static double energy(FreeTail<Law>& free, const Swinging& at) {
    bend_tail(free.tail, at.bend);
    double sum = kinetic_energy(free.fish.swimmer, free.shape, at.xi);
    for (double angle : at.bend.angle) sum += 0.5 * spring * angle * angle;
    return sum;
}

/// Energy that a bent tail gains, and that the water takes, while it swings on springs for 0.05 s.
template <class Law>
static double energy_error(FreeTail<Law>& free, int steps) {
    Swinging at{{-0.5, 0.1, 1.0}, {{0.3, -0.4, 0.2}, {2.0, -1.0, 3.0}}};
    const double start = energy(free, at), step = 0.05 / steps;
    double lost = 0;
    for (int k = 0; k < steps; ++k) {
        const auto loss = [&](const Swinging& s) {
            bend_tail(free.tail, s.bend);
            return water_loss(free.fish.swimmer, free.shape, s.xi);
        };
        const auto rate = [&](int, const Swinging& s) {
            const double moment[3] = {-spring * s.bend.angle[0], -spring * s.bend.angle[1], -spring * s.bend.angle[2]};
            const TailAcceleration<double, 3> a = tail_acceleration(free.tail, s.bend, s.xi, moment);
            return Swinging{a.twist,
                            {{s.bend.rate[0], s.bend.rate[1], s.bend.rate[2]}, {a.bend[0], a.bend[1], a.bend[2]}}};
        };
        const double before = loss(at);
        const Swinging middle = runge_kutta_4(0.5 * step, at, rate);
        at = runge_kutta_4(step, at, rate);
        lost += step / 6 * (before + 4 * loss(middle) + loss(at));
    }
    return std::fabs(energy(free, at) - start + lost) / start;
}

/// Without drag the energy is constant; with drag, the water takes the missing energy. Both to the order of RK4.
template <class Law>
static void energy_balance(bool drag) {
    FreeTail<Law> free;
    if (!drag)
        for (auto& k : free.fish.coefficients) {
            k.friction = k.drag = 0;
            if constexpr (requires { k.linear_drag; }) k.linear_friction = k.linear_drag = 0;
        }
    if (!drag) stop_shedding(free.fish.swimmer.water);
    free.tail.fish = free.fish.swimmer;
    const double coarse = energy_error(free, 400), fine = energy_error(free, 800);
    CHECK(fine < 1e-6);
    CHECK(coarse > 10 * fine);
}

/// The mirrored state accelerates as the mirror image.
template <class Law>
static void mirror() {
    FreeTail<Law> free;
    const Bend<double, 3> bend{{0.3, -0.5, 0.2}, {4, 2, -7}}, flipped{{-0.3, 0.5, -0.2}, {-4, -2, 7}};
    const double moment[3] = {0.3, -0.2, 0.1}, against[3] = {-0.3, 0.2, -0.1};
    const auto a = tail_acceleration(free.tail, bend, {-0.5, 0.2, 3}, moment);
    const auto b = tail_acceleration(free.tail, flipped, {-0.5, -0.2, -3}, against);
    CHECK_NEAR(a.twist.x, b.twist.x, 1e-12);
    CHECK_NEAR(a.twist.y, -b.twist.y, 1e-12);
    CHECK_NEAR(a.twist.z, -b.twist.z, 1e-11);
    for (int d = 0; d < 3; ++d) CHECK_NEAR(a.bend[d], -b.bend[d], 1e-11);
}

template <class Law>
static void each_law() {
    inverse_of_prescribed_motion<Law>();
    energy_balance<Law>(false);
    energy_balance<Law>(true);
    mirror<Law>();
}

int main() {
    cholesky_by_hand();
    rods_by_hand();
    WaterLaws::each<double>([](auto law) { each_law<typename decltype(law)::type>(); });
    return failures();
}
