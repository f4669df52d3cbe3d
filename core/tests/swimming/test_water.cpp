/// The water laws: coefficients and forces by hand, the integrals along a link against fine quadrature, the wake of a
/// slender body against Lighthill's theory, and that water only ever takes energy.
#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/swimming/laws.hpp"
#include "plate.hpp"

using namespace hypertuna;

static void lumped_by_hand() {
    // One link: length, com, mass, inertia | density | added mass, friction, drag, area of friction, of drag.
    const double row[] = {1, 0.5, 3, 7, 10, 0.5, 2, 4, 0.3, 0.2};
    Columns<double> in{row};
    Link<double> link;
    Lumped<double>::Coefficients k;
    const double density = read_body(1, in, &link);
    const Lumped<double> water = Lumped<double>::read(1, in, &link, density, 0, &k);
    const LinkInertia<double> inertia = water.inertia(0);
    CHECK(inertia.tangential == 4.5 && inertia.normal == 4.5 && inertia.coupling == 0 && inertia.rotary == 7);
    const Along<double> f = water.drag(0, Along<double>{-2, 3, 5});  // 1/2 10 (2 0.3) 2^2 and 1/2 10 (4 0.2) 3^2
    CHECK_NEAR(f.t, 12, 1e-14);
    CHECK_NEAR(f.n, -36, 1e-14);
    CHECK(f.w == 0);
}

static void strip_by_hand() {
    const Plate plate({.linear_normal = 10, .linear_tangential = 20});
    const LinkInertia<double> inertia = plate.water.inertia(0);
    CHECK_NEAR(inertia.tangential, 3 + 0.25 * 8, 1e-14);
    CHECK_NEAR(inertia.normal, 3 + 8, 1e-14);
    CHECK_NEAR(inertia.coupling, 8 * 0.5, 1e-14);  // the middle is 0.5 m behind the center of mass
    CHECK_NEAR(inertia.rotary, 7 + 8 * (0.25 + 4.0 / 12), 1e-14);
    const Along<double> f = plate.towed(Along<double>{-2, 3, 0});
    CHECK_NEAR(f.t, 5 * 4 + 2 * 20 * 2, 1e-13);
    CHECK_NEAR(f.n, -(3 * 9 + 2 * 10 * 3), 1e-13);
    CHECK_NEAR(f.w, 0.5 * f.n, 1e-13);
    const LinkInertia<double> mixed = {2, 3, 5, 7};  // momentum is the derivative of energy with respect to velocity
    const Along<double> p = mixed * Along<double>{1, 10, 100};
    CHECK(p.t == 2 && p.n == 3 * 10 + 5 * 100 && p.w == 5 * 10 + 7 * 100);
}

/// Force across the link and moment by the midpoint rule.
static Along<double> fine_drag(const Plate& plate, const Along<double>& v) {
    const int parts = 20000;
    Along<double> f{0, 0, 0};
    for (int k = 0; k < parts; ++k) {
        const double arm = plate.link.length * (k + 0.5) / parts - plate.link.com, v_n = v.n + arm * v.w;
        const double magnitude = plate.water.cross_flow ? std::hypot(v.t, v_n) : std::fabs(v_n);
        const double force = -(Plate::drag * magnitude + plate.k.linear_drag) * v_n / parts;
        f.n += force, f.w += arm * force;
    }
    return f;
}

static void strip_against_quadrature() {
    const Plate plate({.linear_normal = 2}), cross({.cross_flow = true, .linear_normal = 2});
    Random random;
    for (int k = 0; k < 200; ++k) {
        const Along<double> v = {random(-2, 2), random(-2, 2), random(-1, 1)};
        const double front = v.n - plate.link.com * v.w, back = v.n + (plate.link.length - plate.link.com) * v.w;
        const double fastest = std::fmax(std::fabs(front), std::fabs(back));
        // Four Gauss points are exact for a cubic, which v_n |v_n| times an arm is unless it changes sign on the link.
        const double scale = Plate::drag * fastest * fastest, tolerance = (front * back > 0 ? 1e-7 : 0.02) * scale;
        const Along<double> got = plate.towed(v), wanted = fine_drag(plate, v);
        CHECK_NEAR(got.n, wanted.n, tolerance);
        CHECK_NEAR(got.w, wanted.w, tolerance);
        const Along<double> got_cross = cross.towed(v), wanted_cross = fine_drag(cross, v);
        const double speed = std::hypot(fastest, v.t);
        CHECK_NEAR(got_cross.n, wanted_cross.n, 0.02 * Plate::drag * speed * fastest);
        CHECK_NEAR(got_cross.w, wanted_cross.w, 0.02 * Plate::drag * speed * fastest);
    }
}

/// The drag of a plate that its joints heave in still water has the coefficient of oscillating flow, C_n + C_b. At the
/// same speed by a motion of the whole body, as in a tow or a glide, it has that of steady flow; with half of the speed
/// from each, the mean of both.
static void beating_plate() {
    const double beating = 12;  // kg/m, of the whole link: four times the steady 3
    const Plate plate({.beating = beating});
    const Along<double> none{0, 0, 0};
    for (double speed : {-2.0, 0.1, 3.0}) {
        const Along<double> v{0, speed, 0};
        CHECK_NEAR(plate.water.drag(0, v, v).n, -(3 + 12) * speed * std::fabs(speed), 1e-13);
        CHECK_NEAR(plate.water.drag(0, v, none).n, -3 * speed * std::fabs(speed), 1e-13);
        const Along<double> half{0, speed / 2, 0};
        CHECK_NEAR(plate.water.drag(0, v, half).n, -(3 + 12 / 2) * speed * std::fabs(speed), 1e-13);
    }
    // Turning of the link by its joint, too: at its middle, 0.5 m behind the center of mass.
    const Along<double> turning{0, 1, 2};
    const Along<double> all = plate.water.drag(0, turning, turning), steady = plate.towed(turning);
    CHECK_NEAR(all.n / steady.n, 5, 1e-13);
    CHECK_NEAR(all.w / steady.w, 5, 1e-13);
}

/// A towed body has the drag 1/2 rho C A U^2 of a blunt shape beside friction, in both directions.
static void blunt_body() {
    const Plate plain, blunt({.blunt_area = 0.7});
    for (double U : {-3.0, 0.5}) {
        const Along<double> v{U, 0.2, 0};
        const double more = blunt.towed(v).t - plain.towed(v).t;
        CHECK_NEAR(more, -0.5 * Plate::density * 0.7 * U * std::fabs(U), 1e-13);
        CHECK(blunt.towed(v).n == plain.towed(v).n);
    }
}

static void only_dissipates() {
    const Plate plate({.linear_normal = 1, .linear_tangential = 1, .edge_height = 3, .edge_lift = 0.5});
    const Plate cross({.cross_flow = true, .linear_normal = 1, .linear_tangential = 1, .beating = 4, .blunt_area = 2});
    Random random;
    for (int k = 0; k < 1000; ++k) {
        const Along<double> v = {random(-2, 2), random(-2, 2), random(-2, 2)};
        for (const Plate* p : {&plate, &cross}) {
            const Along<double> bend = {random(-2, 2), random(-2, 2), random(-2, 2)};
            const Along<double> drag = p->water.drag(0, v, bend);
            CHECK(drag.t * v.t + drag.n * v.n + drag.w * v.w < 0);
        }
    }
    const Along<double> still = plate.towed(Along<double>{0, 0, 0}), calm = plate.water.shed(Along<double>{0, 0, 0});
    CHECK(still.t == 0 && still.n == 0 && still.w == 0 && calm.t == 0 && calm.n == 0);
}

/// The same plate by elongated-body theory: half the added mass across the link; its edge has 1.5 times that of a
/// plate.
struct Slender {
    Link<double> link;
    Elongated<double>::Coefficients k;
    Elongated<double> water;

    Slender() {
        const double density = 4 / pi;
        const double row[] = {2, 0.5, 3, 7, density, 4, 8, 0.5, 1.5, 2 * 3 / (4 * density), 2 * 5 / (8 * density)};
        Columns<double> in{row};
        const double rho = read_body(1, in, &link);
        water = Elongated<double>::read(1, in, &link, rho, 0, &k);
    }
    Slender(const Slender&) = delete;
};

static void elongated_by_hand() {
    const Slender plate;
    const LinkInertia<double> inertia = plate.water.inertia(0);
    CHECK(inertia.tangential == 3);  // no added mass along the body
    CHECK_NEAR(inertia.normal, 3 + 4, 1e-14);
    CHECK_NEAR(inertia.coupling, 4 * 0.5, 1e-14);
    CHECK_NEAR(inertia.rotary, 7 + 4 * (0.25 + 4.0 / 12), 1e-14);
    CHECK_NEAR(plate.water.shedding, 1.5 * 4, 1e-14);
    const Along<double> f = plate.water.drag(0, Along<double>{-2, 3, 0});
    CHECK_NEAR(f.t, 5 * 4, 1e-13);
    CHECK_NEAR(f.n, -3 * 9, 1e-13);
    CHECK_NEAR(f.w, 0.5 * f.n, 1e-13);
    // Drag across the link is that of the strips without cross flow and linear terms, turning or not.
    const Plate strips;
    const Along<double> v = {-0.5, 1, 0.8}, turning = plate.water.drag(0, v), wanted = strips.towed(v);
    CHECK_NEAR(turning.n, wanted.n, 1e-14);
    CHECK_NEAR(turning.w, wanted.w, 1e-14);
}

/// Lighthill's complete force at all incidences; at rest and backward only the part along the body, which leaves no
/// momentum across it in the wake.
static void elongated_wake() {
    const Slender plate;
    const double mu = plate.water.shedding, U = 2, arm = 2 - 0.5;
    for (double incidence : {1e-3, 0.1, 1.0, 10.0}) {
        const double w = incidence * U;
        const Along<double> f = plate.water.shed(Along<double>{-U, w, 0});
        CHECK_NEAR(f.n / (-mu * U * w), 1, 1e-14);
        CHECK_NEAR(f.t / (-0.5 * mu * w * w), 1, 1e-14);
        CHECK_NEAR(f.w / f.n, arm, 1e-14);
        CHECK_NEAR(wake_power(plate.water, Along<double>{-U, w, 0}) / (0.5 * mu * w * w * U), 1, 1e-14);
    }
    for (double backward : {0.0, U}) {
        const Along<double> f = plate.water.shed(Along<double>{backward, 1, 0.2});
        CHECK_NEAR(f.t, -0.5 * mu * (1 + arm * 0.2) * (1 + arm * 0.2), 1e-14);
        CHECK(f.n == 0 && f.w == 0);
    }
    Random random;
    for (int k = 0; k < 1000000; ++k) {
        const Along<double> v = {random(-2, 2), random(-2, 2), random(-4, 4)};
        if (wake_power(plate.water, v) < -1e-12) CHECK(false);
    }
    for (int k = 0; k < 1000; ++k) {
        const Along<double> v = {random(-2, 2), random(-2, 2), random(-2, 2)}, drag = plate.water.drag(0, v);
        CHECK(drag.t * v.t + drag.n * v.n + drag.w * v.w < 0);
    }
    const Along<double> calm = plate.water.shed(Along<double>{0, 0, 0});
    CHECK(calm.t == 0 && calm.n == 0);
}

int main() {
    elongated_by_hand();
    elongated_wake();
    lumped_by_hand();
    strip_by_hand();
    strip_against_quadrature();
    beating_plate();
    blunt_body();
    only_dissipates();
    return failures();
}
