/// The swimming equations: one rigid link by Kirchhoff's closed forms; then a moving shape, whose momentum,
/// acceleration, joint torques and energy must fit together.
#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/swimming/swimmer.hpp"

using namespace hypertuna;

/// A rigid body without drag, 2 kg along and 5 kg across with its added mass, 3 kg m^2, center of mass `com` behind the
/// nose.
struct Rigid {
    Link<double> link;
    Strip<double>::Coefficients k{{2, 5, 0, 3}, 0, 0, 0, 0, 0, 0, 0.5};
    Swimmer<double, Strip<double>> fish;
    LinkShape<double> shape;
    LinkAcceleration<double> still;
    Composite<double> whole;
    Symmetric<double> mobility;

    explicit Rigid(double com) : link{1, com, 0, 0}, fish{1, &link, {&k, {}, false}} {
        const JointMotion<double> straight{0, 0, 0};
        hypertuna::shape(1, &link, &straight, &shape, &still);
        whole = composite(fish, &shape);
        mobility = inverse(whole.inertia);
    }
    Rigid(const Rigid&) = delete;
    Instant<double> now() const { return {&shape, &still, mobility, whole.momentum}; }
};

/// Kirchhoff: 2 du/dt = 5 v r, 5 dv/dt = -2 u r, 3 dr/dt = (2 - 5) u v (Munk's moment turns it broadside).
static void kirchhoff() {
    const Rigid body(0);
    const Twist<double> xi{7, 11, 13};
    const Twist<double> a = acceleration(body.fish, body.now(), xi);
    CHECK_NEAR(a.x, 5 * 11 * 13 / 2.0, 1e-12);
    CHECK_NEAR(a.y, -2 * 7 * 13 / 5.0, 1e-12);
    CHECK_NEAR(a.z, -7 * 11, 1e-12);
    const Momentum<double> P{2 * 7, 5 * 11, 3 * 13}, rate = momentum_rate(body.fish, body.now(), P, xi);
    CHECK(rate.x == 13 * 55 && rate.y == -13 * 14 && rate.z == -(7 * 55 - 11 * 14));
    CHECK_NEAR(kinetic_energy(body.fish, &body.shape, xi), (2 * 49 + 5 * 121 + 3 * 169) / 2.0, 1e-12);
}

/// Center of mass 0.5 m behind the nose: parallel axes, 3 + 5 0.25 about the nose, and 5 0.5 couples sway with turning.
static void parallel_axes() {
    const Rigid body(0.5);
    const Composite<double>& whole = body.whole;
    const double got[9] = {whole.inertia.xx, whole.inertia.xy, whole.inertia.xz, whole.inertia.yy, whole.inertia.yz,
                           whole.inertia.zz, whole.momentum.x, whole.momentum.y, whole.momentum.z};
    const double wanted[9] = {2, 0, 0, 5, 2.5, 4.25, 0, 0, 0};
    for (int k = 0; k < 9; ++k) CHECK_NEAR(got[k], wanted[k], 1e-15);
    const Twist<double> xi{0.3, -0.2, 0.9}, back = body.mobility * (whole.inertia * xi);
    CHECK_NEAR(back.x, xi.x, 1e-15);
    CHECK_NEAR(back.y, xi.y, 1e-15);
    CHECK_NEAR(back.z, xi.z, 1e-15);
}

/// The force of the tail's wake acts where its fin is, here at the trailing edge 0.5 m behind the center of mass, and
/// follows from the speed there: 0.3 + 0.5 2.
static void tail() {
    Rigid body(0.5);
    body.fish.water.fin.sense = body.fish.water.fin.act = 0.5;
    body.fish.water.fin.lift = 4;
    const Along<double> f = water_force(body.fish, 0, Along<double>{-3, 0.3, 2}, body.shape.bending());
    CHECK(f.t == 0);
    CHECK_NEAR(f.n, -4 * 3 * 1.3, 1e-14);
    CHECK_NEAR(f.w, 0.5 * f.n, 1e-14);
}

/// The functions that are differentiated below, at one phase of the beat and one twist.
struct Sample {
    Momentum<double> momentum;
    double energy;
};
template <class Law>
static Sample sample(Fish<double, Law>& fish, double phase, const Twist<double>& xi) {
    const Instant<double> now = fish.at_phase(phase);
    return {inverse(now.mobility) * xi + now.momentum, kinetic_energy(fish.swimmer, now.shape, xi)};
}

/// For a moving shape d/dt (M xi + b) equals momentum_rate when xi advances with acceleration(), and the joints' power
/// equals the gain of energy plus the power that the water takes.
template <class Law>
static void moving_shape(unsigned flags) {
    Fish<double, Law> fish(2.0, 0.2, flags);
    const double h = 1e-5, omega = 2 * pi * fish.frequency;
    Random random;
    for (int k = 0; k < 50; ++k) {
        const double phase = random(0, 2 * pi);
        const Twist<double> xi{random(-1, 1), random(-1, 1), random(-4, 4)};
        const Instant<double> now = fish.at_phase(phase);
        const Momentum<double> P = inverse(now.mobility) * xi + now.momentum;
        const Twist<double> back = twist(now, P), a = acceleration(fish.swimmer, now, xi);
        const Momentum<double> rate = momentum_rate(fish.swimmer, now, P, xi);
        double torque[4], power = -water_loss(fish.swimmer, now.shape, xi);
        joint_torques(fish.swimmer, now, xi, torque);
        for (int i = 1; i < fish.links; ++i) power += torque[i] * joint_rate(now.shape, i);
        CHECK_NEAR(back.x, xi.x, 1e-13);
        CHECK_NEAR(back.y, xi.y, 1e-13);
        CHECK_NEAR(back.z, xi.z, 1e-13);
        CHECK_NEAR(torque[0], 0, 1e-11);  // no torque holds the nose

        const Sample after = sample(fish, phase + omega * h, xi + h * a);
        const Sample before = sample(fish, phase - omega * h, xi - h * a);
        // Central differences: h^2 omega^2 / 6 = 3e-9 of rates of some ten, a few times over.
        const Momentum<double> difference = 0.5 / h * (after.momentum - before.momentum);
        CHECK_NEAR(difference.x, rate.x, 1e-6);
        CHECK_NEAR(difference.y, rate.y, 1e-6);
        CHECK_NEAR(difference.z, rate.z, 1e-6);
        CHECK_NEAR((after.energy - before.energy) / (2 * h), power, 1e-5);
    }
}

/// Straight ahead at 2 m/s only the friction acts, 1/2 rho c_f S U^2 of each link.
static void towing() {
    const Fish<double, Lumped<double>> fish(2.0, 0.2);
    double power = 0;
    for (int i = 0; i < fish.links; ++i) power += 8 * fish.coefficients[i].friction;
    CHECK_NEAR(towing_power(fish.swimmer, 2.0), power, 1e-13 * power);
    CHECK_NEAR(towing_power(fish.swimmer, -2.0), power, 1e-13 * power);
}

/// Derivatives with respect to an added mass are the same whether the shape carries derivatives (all zero) or none.
static void plain_shape() {
    using D = Dual<double, 1>;
    Fish<D, Lumped<D>> fish(D(2.0), D(0.2));
    fish.coefficients[2].inertia_mass.d[0] = 1;
    Fish<double, Lumped<double>> plain(2.0, 0.2);
    const Instant<D> now = fish.at_phase(D(1.0));
    const Swimmer<D, Lumped<D>, double> swimmer{fish.links, plain.link, fish.swimmer.water};
    const Instant<double> shape = plain.at_phase(1.0);
    Symmetric<D> mobility;
    Momentum<D> momentum;
    const ShapeTable<D, double> table{fish.links, 1, plain.table.shape, plain.table.acceleration, &mobility, &momentum};
    weigh(swimmer, 0, table);
    const Twist<D> xi{D(-0.5), D(0.1), D(0.3)};
    const Wrench<D> whole = now.mobility * water_wrench(fish.swimmer, now.shape, xi);
    const Wrench<D> mixed = mobility * water_wrench(swimmer, shape.shape, xi);
    D of_whole[4], of_mixed[4];
    joint_torques(fish.swimmer, now, xi, of_whole);
    joint_torques(swimmer, table[0], xi, of_mixed);
    CHECK(whole.y.d[0] != 0);
    CHECK_NEAR(whole.y.v, mixed.y.v, 1e-14 * std::fabs(whole.y.v));
    CHECK_NEAR(whole.y.d[0], mixed.y.d[0], 1e-14 * std::fabs(whole.y.d[0]));
    for (int i = 1; i < fish.links; ++i) {
        CHECK(of_whole[i].d[0] != 0);
        CHECK_NEAR(of_whole[i].d[0], of_mixed[i].d[0], 1e-13 * std::fabs(of_whole[i].d[0]));
    }
}

int main() {
    towing();
    plain_shape();
    kirchhoff();
    parallel_axes();
    tail();
    WaterLaws::each<double>([](auto law) { moving_shape<typename decltype(law)::type>(0); });
    moving_shape<Strip<double>>(1);
    return failures();
}
