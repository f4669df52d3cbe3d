/// Tests of the force on a tail fin: values by hand, the theory of thin plates, and a wake that never gives energy.
#include "check.hpp"
#include "fish.hpp"
#include "plate.hpp"

using namespace hypertuna;

/// A link of one height, 4 kg/m: at small incidence its edge is pushed across with 4 U w, half of it here. Without
/// suction nothing acts along it, with all of it 1/2 mu w^2 of what the wake takes comes back as thrust.
static void edge_of_a_strip() {
    const Plate whole({.tail_shedding = 1}), half, round({.tail_shedding = 1, .edge_suction = 1});
    const double mu = 4, U = 2, w = 1e-4 * U;
    const Along<double> v{-U, w, 0};
    CHECK_NEAR(whole.water.shed(v).n / (-mu * U * w), 1, 1e-8);
    CHECK_NEAR(half.water.shed(v).n / (-0.5 * mu * U * w), 1, 1e-8);
    CHECK(whole.water.shed(v).t == 0 && half.water.shed(v).t == 0);
    CHECK_NEAR(round.water.shed(v).t / (-0.5 * mu * w * w), 1, 1e-12);
    CHECK_NEAR(whole.water.shed(v).w / whole.water.shed(v).n, 1.5, 1e-12);  // the edge is 1.5 m behind
    // When the link moves backward, its front edge sheds the wake, 0.5 m ahead of the center of mass.
    const Along<double> back = whole.water.shed(Along<double>{U, w, 0});
    CHECK_NEAR(back.n / (-mu * U * w), 1, 1e-8);
    CHECK_NEAR(back.w / back.n, -0.5, 1e-12);
    // At rest and turning: the force along the plate of Kirchhoff's equations, omega mu l v_mid, is canceled.
    const Along<double> turning = whole.water.shed(Along<double>{0, 0.3, 2});
    CHECK_NEAR(turning.t, -2 * (mu * 2) * (0.3 + 0.5 * 2), 1e-13);
    CHECK(turning.n == 0);
}

/// Behind a body as deep as the fin there is no leading edge: the force along the link is Lighthill's force of the
/// trailing edge, for every fraction of the suction.
static void edge_behind_a_deep_body() {
    const double height = 2, row[] = {1, 2, 0.5, 1, 1, 1, 1, 1, 4 / pi, height, 2 * height, 8, 8, 1, 1, 0, 0, 1, 1,
                                      0, 0, 0,   0, 0, 0, 0, 0, 1,      0,      0,          0, 0, 0, 0, 1, 1, 0};
    Columns<double> in{row};
    Link<double> link[2];
    Strip<double>::Coefficients k[2];
    const double rho = read_body(2, in, link);
    const Strip<double> water = Strip<double>::read(2, in, link, rho, 0, k);
    const Along<double> v{-1, 0.4, 0.7};
    const double edge = v.n + (2 - 1) * v.w, carried = 4 * 2 * v.w * v.n;  // the middle is the center of mass
    CHECK_NEAR(water.shed(v).t, -0.5 * 4 * edge * edge, 1e-13);
    CHECK_NEAR(water.fin.carried * v.w * v.n, carried, 1e-13);
}

/// A fin of span 3 m, chord 1 m and lift slope 2.4 at the end of the link: its lift, what it carries, where both act.
static void fin_of_its_own() {
    const double rho = Plate::density, b = 3, c = 1, slope = 2.4, kappa = 0.8;
    const Plate::Given given{.tail_shedding = 1,
                             .edge_height = b,
                             .edge_aspect = b / c,
                             .edge_added_mass = kappa,
                             .edge_lift = slope / (pi * (b / c) / 2)};
    const Plate fin(given), plain;
    const double mass = kappa * rho * pi / 4 * c * c * b, U = 2, w = 0.3;
    const Along<double> f = fin.water.shed(Along<double>{-U, w, 0});
    const double kept = U / std::hypot(U, w), lift = 0.5 * rho * b * c * slope;
    CHECK_NEAR(f.n, -lift * U * w * kept, 1e-13);
    CHECK(f.t == 0);
    // The fin's middle is 1 m behind the center of mass. Munk's moment fades in the same proportion as the lift.
    const double share = mass / (c * lift), offset = (share - 0.25) * c, munk = mass * U * w;
    CHECK_NEAR(f.w, (1 + offset) * f.n - (1 - kept) * munk, 1e-13);
    CHECK_NEAR(((f.w - f.n) + munk) / f.n, -0.25 * c, 1e-12);  // steady lift has its center at a quarter of the chord
    CHECK_NEAR(fin.water.shed(Along<double>{0, w, 1}).t, -mass * (w + 1), 1e-13);
    // The total added mass is unchanged: the fin's part acts at its middle, the rest ahead of it.
    const LinkInertia<double> a = fin.water.inertia(0), p = plain.water.inertia(0);
    CHECK(a.normal == p.normal && a.tangential == p.tangential);
    const double rest = 8 - mass;
    CHECK_NEAR(a.coupling, rest * 0 + mass * 1.0, 1e-13);  // 0.5 m behind the front as the center of mass
    CHECK_NEAR(a.rotary, 7 + rest / 12 + mass * (1 + 1.0 / 32), 1e-13);
    CHECK(fin.towed(Along<double>{-U, w, 1}).n == plain.towed(Along<double>{-U, w, 1}).n);
    // Two dimensions: lift slope 2 pi, added mass of a flat plate. Lift acts in the middle, and the wake takes its
    // square.
    const Plate flat(
        {.tail_shedding = 1, .edge_height = 3, .edge_aspect = 3, .edge_added_mass = 1, .edge_lift = 4.0 / 3});
    const double round = pi * rho * c * b, middle = 0.2 + 1.0 * 0.9;
    const double quarter = U / std::hypot(U, middle + 0.25 * 0.9);
    CHECK(flat.water.fin.act == 0);
    CHECK_NEAR(wake_power(flat.water, Along<double>{-U, 0.2, 0.9}), round * U * middle * middle * quarter, 1e-12);
}

/// The water never gives energy: 1e6 velocities, forward and backward, of fins and edges of all kinds.
static void wake_never_gives_energy() {
    Random random;
    for (int kind = 0; kind < 1000; ++kind) {
        const double lift = random(0.05, 1), added = random(0.05, 1.5), aspect = kind % 3 ? random(0.3, 12) : 0;
        const Plate plate({.tail_shedding = random(0, 1),
                           .edge_height = kind % 2 ? random(0.5, 4) : 0,
                           .edge_aspect = aspect,
                           .edge_added_mass = added,
                           .edge_lift = lift,
                           .edge_suction = kind % 5 ? 0 : random(0, 1)});
        double worst = 0;
        for (int k = 0; k < 1000; ++k) {
            const Along<double> v = {random(-2, 2), random(-2, 2), random(-4, 4)};
            worst = std::fmin(worst, wake_power(plate.water, v));
        }
        CHECK(worst >= -1e-11);  // rounding of forces up to 1e3 N
    }
}

/// A plate without mass and friction moves in any way without a force along itself: pressure on its faces acts across.
static void no_force_along_a_plate() {
    const Plate strip({.tail_shedding = 1}), half({.tail_shedding = 0.5, .edge_height = 3});
    const Plate fin({.tail_shedding = 1, .edge_height = 4, .edge_aspect = 2, .edge_lift = 0.6});
    Random random;
    for (const Plate* plate : {&strip, &half, &fin}) {
        for (int k = 0; k < 100; ++k) {
            const Along<double> v = {random(-2, 2), random(-2, 2), random(-4, 4)};
            const LinkInertia<double> own{3, 3, 0, 7}, all = plate->water.inertia(0);
            const double water = (all * v).n - (own * v).n;  // momentum across the plate, which turns with it
            CHECK_NEAR(v.w * water + plate->water.shed(v).t, 0, 1e-12);
        }
    }
}

/// Mean thrust, and mean power that moves the plate, per square of a small amplitude: the plate advances at U, heaves
/// at its middle by y and turns by theta, both harmonic.
struct Flapping {
    double thrust, power;
};
template <class Water>
static Flapping flap(const Water& water, double length, double com, double U, double omega, double heave, double pitch,
                     double lag) {
    const int parts = 64;
    const double size = 1e-6;
    Flapping mean{0, 0};
    for (int k = 0; k < parts; ++k) {
        const double phase = 2 * pi * k / parts, theta = size * pitch * std::sin(phase - lag);
        const double rate = size * pitch * omega * std::cos(phase - lag),
                     y_rate = size * heave * omega * std::cos(phase);
        const double c = std::cos(theta), s = std::sin(theta);
        const Along<double> v{-U * c + y_rate * s, U * s + y_rate * c - (0.5 * length - com) * rate, rate};
        const Along<double> f = water.shed(v);  // the rate of momentum has zero mean over a period
        mean.thrust -= (f.t * c - f.n * s) / (size * size * parts);
        mean.power -= (f.t * v.t + f.n * v.n + f.w * v.w) / (size * size * parts);
    }
    return {mean.thrust, mean.power + mean.thrust * U};
}

/// Theodorsen (1935) and Garrick (1936), quasi-steady (C = 1) and without suction, for a chord 2b and a span: h down,
/// alpha nose up, the axis in the middle. The force is normal to the plate.
static Flapping thin_plate(double rho, double b, double span, double U, double omega, double heave, double pitch,
                           double lag) {
    const int parts = 64;
    Flapping mean{0, 0};
    for (int k = 0; k < parts; ++k) {
        const double phase = 2 * pi * k / parts, o2 = omega * omega;
        const double h1 = -heave * omega * std::cos(phase), h2 = heave * o2 * std::sin(phase);
        const double a0 = -pitch * std::sin(phase - lag), a1 = -pitch * omega * std::cos(phase - lag), a2 = -o2 * a0;
        const double w = h1 + U * a0 + b / 2 * a1;
        const double lift = pi * rho * b * b * (h2 + U * a1) + 2 * pi * rho * U * b * w;
        const double moment = pi * rho * b * b * (-U * b / 2 * a1 - b * b / 8 * a2) + pi * rho * U * b * b * w;
        mean.thrust -= span * lift * a0 / parts;
        mean.power += span * (lift * h1 - moment * a1) / parts;
    }
    return mean;
}

/// A separate fin agrees with the quasi-steady theory of thin plates: thrust and power, for random motions.
static void thin_plate_theory() {
    const double rho = Plate::density, span = 8, chord = 2;  // lift slope 2 pi: pi rho chord span
    const Plate plate(
        {.tail_shedding = 1, .added_mass = 4, .edge_height = span, .edge_aspect = span / chord, .edge_lift = 1});
    CHECK_NEAR(plate.water.fin.fading, pi * rho * chord * span, 1e-12);
    Random random;
    for (int k = 0; k < 200; ++k) {
        const double U = random(0.2, 2), omega = random(0, 4), heave = random(0, 1), pitch = random(0, 1);
        const double lag = random(0, 2 * pi);
        const Flapping got = flap(plate.water, 2, 0.5, U, omega, heave, pitch, lag);
        const Flapping wanted = thin_plate(rho, chord / 2, span, U, omega, heave, pitch, lag);
        const double scale = rho * span * (heave * omega + pitch * (U + omega)) * (heave * omega + pitch * (U + omega));
        CHECK_NEAR(got.thrust, wanted.thrust, 1e-9 * scale);
        CHECK_NEAR(got.power, wanted.power, 1e-9 * scale * (U + 1));
    }
}

/// The edge of a strip has Lighthill's thrust 1/2 mu (y_t^2 - U^2 y_x^2) at the trailing edge, minus the suction 1/2 mu
/// v^2 at the leading edge, where v is the speed across.
static void thrust_of_a_strip() {
    const Plate sharp({.tail_shedding = 1}), round({.tail_shedding = 1, .edge_suction = 1});
    const double mu = 4, length = 2;
    Random random;
    for (int k = 0; k < 200; ++k) {
        const double U = random(0, 2), omega = random(0, 4), heave = random(0, 1), pitch = random(0, 1);
        const double lag = random(0, 2 * pi), along = heave * pitch * omega * omega * length / 2 * std::cos(lag);
        const double turn = pitch * omega * length / 2, middle = heave * omega;
        const double rear =
            (middle * middle + turn * turn) / 2 + along - U * U * pitch * pitch / 2;  // y_t^2 - U^2 y_x^2
        const double front = (middle * middle + turn * turn) / 2 - along + U * U * pitch * pitch / 2 +
                             U * heave * pitch * omega * std::sin(-lag);
        const double full = flap(round.water, length, 0.5, U, omega, heave, pitch, lag).thrust;
        const double none = flap(sharp.water, length, 0.5, U, omega, heave, pitch, lag).thrust;
        const double scale = mu * (middle + turn + U * pitch) * (middle + turn + U * pitch);
        CHECK_NEAR(full, mu / 2 * rear, 1e-8 * scale);
        CHECK_NEAR(none, mu / 2 * (rear - front), 1e-8 * scale);
    }
}

int main() {
    edge_of_a_strip();
    edge_behind_a_deep_body();
    fin_of_its_own();
    wake_never_gives_energy();
    no_force_along_a_plate();
    thin_plate_theory();
    thrust_of_a_strip();
    return failures();
}
