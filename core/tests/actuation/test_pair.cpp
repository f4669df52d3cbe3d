/// The pair of a joint: a soft joint between two circuits, whose bend follows from volumes.
#include "check.hpp"
#include "hypertuna/actuation/pair.hpp"
#include "hypertuna/swimming/stepping.hpp"
#include "soft.hpp"

using namespace hypertuna;

static constexpr double fill = 60e3;  // Pa

/// A circuit filled to 60 kPa; without compliance and almost without air it is a source of displacement.
static Circuit<double> circuit(double air, double compliance) {
    const Servo<double> servo{6.86, 7.5, 10.0, 0.3, 7.4, 7.0, 0.05, 0.0045};
    Circuit<double> c{{3.1416e-4, 0.025, 0.060, pi / 2, 0.0, 9e-6, 0.0},
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
    const double swollen = oil_volume(c, 1.0, fill);
    c.oil_pump = c.pump.chamber / swollen, c.oil_unit = (c.unit_rest + compliance * fill) / swollen;
    return c;
}

static Pair<double> pair(double air, double compliance) {
    return make_pair(circuit(air, compliance), circuit(air, compliance), soft_joint(fill));
}

/// Command the servos to +-0.1 rad from rest, and simulate a second until the joint rests.
static PairState<double> settled(const Pair<double>& p, double turn) {
    PairState<double> y{};
    const double target[2] = {turn, -turn};
    Bent<double> bent{0, 0};
    for (int k = 0; k < 4000; ++k)
        y = runge_kutta_4(2.5e-4, y, [&](int, const PairState<double>& at) {
            bent = pair_balance(p, at, bent);
            return pair_rate(p, at, target, 7.4, bent).rate;
        });
    return y;
}

static Bent<double> bend(const Pair<double>& p, const PairState<double>& y) { return pair_balance(p, y, {0, 0}); }

/// Nothing moves at rest; mirrored commands bend to the mirrored angle and shorten alike.
static void rest_and_mirror() {
    const Pair<double> p = pair(0.01, 2e-12);
    const Bent<double> rest = pair_balance(p, PairState<double>{}, {0.1, 0.01});
    CHECK_NEAR(rest.angle, 0.0, 1e-10);
    CHECK_NEAR(rest.strain, 0.0, 1e-10);
    const Bent<double> left = bend(p, settled(p, 0.1)), right = bend(p, settled(p, -0.1));
    CHECK(left.angle > 0.05);
    CHECK_NEAR(left.angle, -right.angle, 1e-9);
    CHECK_NEAR(left.strain, right.strain, 1e-9);
}

/// The muscles hold the oil that the cylinders push out, minus what swelling takes: volume = rest + pushed - C (P -
/// fill), within 0.2 % for oil without air. The moments balance.
static void oil_is_conserved() {
    for (double compliance : {0.0, 2e-12}) {
        const Pair<double> p = pair(1e-6, compliance);
        const PairState<double> y = settled(p, 0.1);
        const Bent<double> bent = bend(p, y);
        const JointLoad<double> load = joint_load(p.joint, bent.angle, bent.strain, oil_of(p, y));
        for (int s : {0, 1}) {
            CHECK_NEAR(unit_pressure(p.circuit[s], y.side[s], load.volume[s] - p.rest[s]).pressure, load.pressure[s],
                       1e-3);
            const double pushed = displaced(p.circuit[s].pump, y.side[s].angle);
            CHECK(std::fabs(pushed) > 1e-7);
            CHECK_NEAR(load.volume[s] - p.rest[s], pushed - compliance * (load.pressure[s] - fill),
                       5e-3 * std::fabs(pushed));
        }
        CHECK(load.pressure[0] > fill && load.pressure[1] < fill);
        CHECK_NEAR(joint_moment(load), 0, 1e-9);
        CHECK_NEAR(joint_thrust(load), 0, 1e-9);
    }
}

/// Compliance of the lines reduces the bend.
static void compliance_costs_bend() {
    const double stiff = bend(pair(1e-6, 0.0), settled(pair(1e-6, 0.0), 0.05)).angle;
    const double giving = bend(pair(1e-6, 1e-11), settled(pair(1e-6, 1e-11), 0.05)).angle;
    CHECK(giving < 0.9 * stiff);
}

int main() {
    rest_and_mirror();
    oil_is_conserved();
    compliance_costs_bend();
    return failures();
}
