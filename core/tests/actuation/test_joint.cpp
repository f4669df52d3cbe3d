/// Soft joints: small bends by hand, mirror symmetry, friction that holds, and lumens that close.
#include "check.hpp"
#include "hypertuna/actuation/joint.hpp"

using namespace hypertuna;

static const Segment<double> segments[2] = {{0.02, 0.16}, {0.03, 0.08}};

static SoftJoint<double> joint(double c1, double friction, double left = 0.014, double right = 0.014) {
    const double t = std::tan(37 * pi / 180);
    return {{8e-3, 5.6e-3, t * t, 0, {c1, 0}, {1, 0}, friction}, 5, {left, right}, 2, segments, {false, {}, true}};
}

/// Without walls and at small pressure the muscles pull as if blocked: alpha = N w F S / (E I), to first order.
static void small_bend() {
    const SoftJoint<double> j = joint(0, 0);
    const auto bend = [&](double pressure) {
        const double both[2] = {pressure, 0};
        return balance(j, 0, both, 0.0) / (5 * 0.014 * pull(j.unit, pressure, 1.0) * 0.02 / 0.16);
    };
    CHECK_NEAR(bend(1.0), 1, 1e-5);
    CHECK_NEAR((1 - bend(100.0)) / (1 - bend(50.0)), 2, 1e-2);  // first order in what is left out
}

/// The passive side's walls resist; the right side mirrors the left; a longer lever on one side is an asymmetry.
static void sides() {
    const SoftJoint<double> soft = joint(40e3, 0), lopsided = joint(40e3, 0, 0.013, 0.012);
    SoftJoint<double> alone = soft;
    alone.law.passive = false;
    const double left[2] = {2e5, 0}, right[2] = {0, 2e5}, both[2] = {2e5, 2e5};
    for (int i : {0, 1}) {
        const double bend = balance(soft, i, left, 0.0);
        CHECK(0.01 < bend && bend < balance(alone, i, left, 0.0));
        CHECK_NEAR(balance(soft, i, right, 0.0), -bend, 1e-15);
        CHECK_NEAR(balance(soft, i, both, 0.0), 0, 1e-15);
        CHECK(balance(lopsided, i, left, 0.0) != -balance(lopsided, i, right, 0.0));
        CHECK_NEAR(segment_moment(soft, i, left, bend, 0.0), 0, 1e-14);
    }
}

/// Loading drags behind, unloading too, and in between the angle stays where it was.
static void friction_holds() {
    const SoftJoint<double> j = joint(40e3, 0.1);
    const double top[2] = {2.5e5, 0}, little_less[2] = {2.45e5, 0}, less[2] = {1e5, 0}, none[2] = {0, 0};
    const double loaded = bend_from(j, 0, top, 0.0), free = balance(j, 0, top, 0.0);
    CHECK(loaded < free && free < balance(j, 0, top, 1.0));
    CHECK(bend_from(j, 0, little_less, loaded) == loaded);
    const double back = bend_from(j, 0, less, loaded);
    CHECK(bend_from(j, 0, less, 0.0) < balance(j, 0, less, 0.0) && balance(j, 0, less, 0.0) < back && back < loaded);
    CHECK(bend_from(j, 0, none, 0.0) == 0);
    const double right[2] = {0, 2.5e5};
    CHECK_NEAR(bend_from(j, 0, right, 0.0), -loaded, 1e-15);
    const SoftJoint<double> smooth = joint(40e3, 0);
    CHECK(bend_from(smooth, 0, top, 0.0) == bend_from(smooth, 0, top, 9.0));
}

/// However high the pressure, the stretched side keeps its lumen: there the wall's energy has no end.
static void locks() {
    const SoftJoint<double> j = joint(40e3, 0);
    const double reach = segment_reach(j, 0, 0.0), ten[2] = {1e7, 0}, more[2] = {1e9, 0};
    const double near = balance(j, 0, ten, 0.0), nearer = balance(j, 0, more, 0.0);
    CHECK(near < nearer && nearer <= reach);
    CHECK_NEAR(lumen(j.unit, side_stretch(j, 0, 1, reach)), 0, 1e-12);
    // A shortened hose carries some of the pressure, and below that the braid is loose; a stretched one presses on it.
    const double swollen = carried(j.unit, side_stretch(j, 0, 0, 0.2)), rubbed = joint(40e3, 0.1).unit.friction;
    const SoftJoint<double> rough = joint(40e3, 0.1);
    CHECK(0 < swollen && friction_limit(rough, 0, 0, 0.99 * swollen, 0.2) == 0);
    const double area = contact(j.unit, side_stretch(j, 0, 0, 0.2));
    CHECK_NEAR(friction_limit(rough, 0, 0, swollen + 1e5, 0.2), 5 * 0.014 * rubbed * area * 1e5, 1e-12);
    CHECK(0 < friction_limit(rough, 0, 1, 0.0, 0.2));
}

/// By the printed equations the joint bends too far, without hysteresis, and the other way round to the right.
static void as_printed() {
    SoftJoint<double> j = joint(40e3, 0.1);
    const double left[2] = {2e5, 0}, right[2] = {0, 2e5};
    const double corrected = balance(j, 0, left, 0.0);
    j.law = {true, {true, true}, false};
    const double printed = balance(j, 0, left, 0.0);
    CHECK(1.2 * corrected < printed);
    CHECK_NEAR(balance(j, 0, right, 0.0), -printed, 1e-15);
    CHECK(bend_from(j, 0, left, 1.0) == printed && bend_from(j, 0, left, 0.0) == printed);
}

int main() {
    small_bend();
    sides();
    friction_holds();
    locks();
    as_printed();
    return failures();
}
