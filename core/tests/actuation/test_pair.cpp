/// The pair of a joint: a linear joint between two circuits, whose bend is known by hand.
#include "check.hpp"
#include "hypertuna/actuation/pair.hpp"
#include "hypertuna/swimming/stepping.hpp"

using namespace hypertuna;

static constexpr double stiffness = 3.0, slope = 7e-6;  // N m/rad, m^3/rad

/// A joint of constant stiffness whose sides take up +-slope x angle: three points, exact by cubics.
static JointTable<double> joint() {
    static JointPoint<double> point[3] = {};
    for (int k = 0; k < 3; ++k) {
        const double angle = 0.5 * (k - 1);
        point[k].energy = 0.5 * stiffness * angle * angle, point[k].energy_slope = stiffness * angle;
        for (int s = 0; s < 2; ++s) {
            const double sign = s == 0 ? 1 : -1;
            point[k].volume[s] = 8e-6 + sign * slope * angle, point[k].volume_slope[s] = sign * slope;
        }
    }
    return {point, 3, -0.5, 0.5, 0.0, 100.0};
}

/// A circuit filled to 60 kPa; without compliance and almost without air it is a source of displacement.
static Circuit<double> circuit(double air, double compliance) {
    const Servo<double> servo{6.86, 7.5, 10.0, 0.3, 7.4, 7.0, 0.05, 0.0045};
    Circuit<double> c{{3.1416e-4, 0.025, 0.060, pi / 2, 0.0, 9e-6},
                      servo,
                      4.69e9,
                      0.0,
                      1.31e7,
                      0.0,
                      0.0,
                      8e-6,
                      compliance,
                      1.4e9,
                      air,
                      -95e3};
    c.pump.start = travel(c.pump, 0.0).travel;
    const double fill = 60e3, swollen = oil_volume(c, 1.0, fill);
    c.oil_pump = c.pump.chamber / swollen, c.oil_unit = (c.unit_rest + compliance * fill) / swollen;
    return c;
}

static Pair<double> pair(double air, double compliance) {
    return make_pair(circuit(air, compliance), circuit(air, compliance), joint());
}

/// Servos told +-0.1 rad from rest, and a second to come to rest.
static PairState<double> settled(const Pair<double>& p, double turn) {
    PairState<double> y{};
    const double target[2] = {turn, -turn};
    double angle = 0;
    for (int k = 0; k < 4000; ++k)
        y = runge_kutta_4(2.5e-4, y, [&](int, const PairState<double>& at) {
            angle = pair_angle(p, at, angle);
            return pair_rate(p, at, target, 7.4, angle).rate;
        });
    return y;
}

/// Nothing moves at rest; mirrored commands bend to the mirrored angle.
static void rest_and_mirror() {
    const Pair<double> p = pair(0.01, 2e-12);
    CHECK_NEAR(pair_angle(p, PairState<double>{}, 0.1), 0.0, 1e-12);
    const double left = pair_angle(p, settled(p, 0.1), 0.0), right = pair_angle(p, settled(p, -0.1), 0.0);
    CHECK(left > 0.05);
    CHECK_NEAR(left, -right, 1e-10);
}

/// Stiff circuits push the joint to displaced volume / slope, to what oil alone gives (0.1 %).
static void displacement_source() {
    const Pair<double> p = pair(1e-6, 0.0);
    const PairState<double> y = settled(p, 0.1);
    const double bend = pair_angle(p, y, 0.0);
    const double pushed = displaced(p.circuit[0].pump, y.side[0].angle);
    const double drawn = displaced(p.circuit[1].pump, y.side[1].angle);
    CHECK_NEAR(bend, (pushed - drawn) / (2 * slope), 2e-3 * bend);
    // Both pressures share the load: k angle = slope (P_left - P_right).
    const auto left = unit_pressure(p.circuit[0], y.side[0], slope * bend).pressure;
    const auto right = unit_pressure(p.circuit[1], y.side[1], -slope * bend).pressure;
    CHECK_NEAR(slope * (left - right), stiffness * bend, 1e-8);
}

/// What gives costs bend: k angle = slope (P_left - P_right), slope angle = pushed - C (P - fill) on each side, so
/// angle = pushed slope / (slope^2 + C k / 2) where the cylinders are stiff and both push alike.
static void compliance_costs_bend() {
    const double compliance = 2e-12;
    const Pair<double> p = pair(1e-6, compliance);
    const PairState<double> y = settled(p, 0.02);
    const double mean =
        0.5 * (displaced(p.circuit[0].pump, y.side[0].angle) - displaced(p.circuit[1].pump, y.side[1].angle));
    const double by_hand = mean * slope / (slope * slope + compliance * stiffness / 2);
    CHECK_NEAR(pair_angle(p, y, 0.0), by_hand, 3e-3 * by_hand);
}

int main() {
    rest_and_mirror();
    displacement_source();
    compliance_costs_bend();
    return failures();
}
