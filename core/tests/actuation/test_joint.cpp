/// Tests of soft joints: small strains by hand, virtual work, mirror symmetry, friction, limits of the muscles, and one
/// section that stands for all.
#include <iterator>

#include "check.hpp"
#include "soft.hpp"

using namespace hypertuna;

/// At small pressure the muscles pull as if blocked. A force N F on one side, at the lever w, bends the section by N F
/// w / (E I) and shortens it by N F / (E A), each per length, to first order. With its length held it bends as far.
static void small_strains_by_hand() {
    SoftJoint<double> j = soft(0, 0);
    const Section<double> bare{0.03, 2e-3, 6e-7, 0};
    const double pressure = 1, one_side[2] = {pressure, 0};
    const double force = 5 * pull(j.unit, pressure, 1.0);
    const Bent<double> bent = balance(j, bare, one_side, 0.0);
    CHECK_NEAR(bent.angle / (force * 0.012 * 0.03 / (E_MATRIX * 6e-7)), 1, 1e-4);
    CHECK_NEAR(bent.strain / (-force / (E_MATRIX * 2e-3)), 1, 1e-4);
    j.law.shortens = false;
    CHECK_NEAR(balance(j, bare, one_side, 0.0).angle / bent.angle, 1, 1e-4);
    // Equal pressure on both sides shortens it twice as much and does not bend it.
    const double both[2] = {pressure, pressure};
    j.law.shortens = true;
    CHECK_NEAR(balance(j, bare, both, 0.0).strain / bent.strain, 2, 1e-4);
    CHECK_NEAR(balance(j, bare, both, 0.0).angle, 0, 1e-15);
}

/// The element on the axis carries a part of the axial force, at the strain -N F / (E A + k), until it buckles; after
/// that it carries only its buckling force. If it never buckles and is stiff, the joint bends like one whose length is
/// held.
static void what_lies_on_the_axis() {
    SoftJoint<double> j = soft(0, 0);
    const Section<double> bare{0.03, 2e-3, 6e-7, 0};
    const double one_side[2] = {1, 0}, force = 5 * pull(j.unit, 1.0, 1.0), matrix = E_MATRIX * 2e-3;
    j.axis = {1000, 1};
    CHECK_NEAR(balance(j, bare, one_side, 0.0).strain / (-force / (matrix + 1000)), 1, 1e-4);
    j.axis = {1000, 0.25 * force / 1000};
    CHECK_NEAR(balance(j, bare, one_side, 0.0).strain / (-0.75 * force / matrix), 1, 1e-4);
    j = soft(40e3, 0);
    const double hard[2] = {2e5, 0};
    j.axis = {1e9, 1};
    const double stiff = balance(j, soft_sections[0], hard, 0.0).angle;
    j.law.shortens = false;
    CHECK_NEAR(stiff / balance(j, soft_sections[0], hard, 0.0).angle, 1, 1e-2);
}

/// At larger pressures a body that shortens bends less than one that keeps its length: its muscles have already
/// contracted.
static void shortening_costs_bend() {
    SoftJoint<double> j = soft(40e3, 0);
    const double one_side[2] = {2e5, 0};
    const Bent<double> free = balance(j, soft_sections[0], one_side, 0.0);
    j.law.shortens = false;
    const Bent<double> held = balance(j, soft_sections[0], one_side, 0.0);
    CHECK(held.strain == 0 && free.strain < -0.02);
    CHECK(1.2 * free.angle < held.angle);
}

/// Moment and axial force are the slopes of the stored energy minus the work of the oil. The oil's volume follows
/// `slope` and `gain` while the braid is taut. This also holds beyond the muscles' limits and with slack braids.
static void virtual_work(const Axis<double>& axis) {
    SoftJoint<double> j = soft(40e3, 0, 0.013, 0.011);
    j.axis = axis;
    const StretchLimits<double> limits = stretch_limits(j.unit);
    const double h = 1e-6;
    int slack = 0, taut = 0;
    for (double left : {2e5, 0.0, -1e4})
        for (double angle : {-2.5, -0.4, 0.01, 0.2, 1.9})
            for (double strain : {-0.45, -0.1, 0.0, 0.2}) {
                const auto at = [&](double a, double e) {
                    return section_load(j, soft_sections[0], limits, a, e, given_pressures(left, 1e5));
                };
                const auto potential = [&](double a, double e) {
                    const JointLoad<double> load = at(a, e);
                    return load.energy - left * load.volume[0] - 1e5 * load.volume[1];
                };
                const JointLoad<double> now = at(angle, strain);
                const double scale = 1e-6 * (1 + std::fabs(now.elastic) + std::fabs(now.axial));
                const double by_angle = potential(angle + h, strain) - potential(angle - h, strain);
                const double by_strain = potential(angle, strain + h) - potential(angle, strain - h);
                CHECK_NEAR(by_angle / (2 * h), -joint_moment(now), scale);
                CHECK_NEAR(by_strain / (2 * h), -joint_thrust(now), scale);
                for (int s : {0, 1}) {
                    const bool pulls = now.carried[s] < now.pressure[s];
                    ++(pulls ? taut : slack);
                    if (!pulls) continue;
                    const JointLoad<double> right = at(angle + h, strain), longer = at(angle, strain + h);
                    CHECK_NEAR((right.volume[s] - now.volume[s]) / h, now.slope[s], 1e-8);
                    CHECK_NEAR((longer.volume[s] - now.volume[s]) / h, now.gain[s], 1e-8);
                }
            }
    CHECK(20 < slack && 20 < taut);
}

/// Under external pressure a braid goes slack: the hose in its matrix narrows until both carry the pressure, to first
/// order by their shear, 2 C1 (1 / x1 - 1 / x2) dB of each ring between squared radii. Nothing jumps at its onset.
static void slack_braid() {
    const Joint<double> joint = soft_joint(0);
    const DriveUnit<double>& u = joint.soft.unit;
    const auto straight = [&](double pressure, double strain = 0) {
        return joint_load(joint, 0.0, strain, given_pressures(pressure, pressure));
    };
    const double inner = u.inner * u.inner / 4, outer = u.outer * u.outer / 4, rim = 8e-3 * 8e-3;
    const double carries = 2 * u.hose.c1 * (1 / inner - 1 / outer) + 2 * u.matrix.c1 * (1 / outer - 1 / rim);
    const double length = 5 * 0.03, rest = length * pi * inner;
    CHECK_NEAR(straight(1e3).volume[0], rest, 1e-15);  // the braid is taut
    CHECK_NEAR((straight(-10).volume[0] - rest) / (length * pi * -10 / carries), 1, 1e-3);
    // A muscle that shortens without pressure keeps its lumen; one under pressure widens with its braid.
    CHECK_NEAR(straight(0, -0.1).volume[0], rest, 1e-15);
    CHECK(1.2 * rest < straight(2e5, -0.1).volume[0]);
    const double onset = straight(2e5, -0.1).carried[0], h = 1e-3;
    CHECK(1e3 < onset);
    const JointLoad<double> above = straight(onset + h, -0.1), below = straight(onset - h, -0.1);
    CHECK_NEAR(below.volume[0] / above.volume[0], 1, 1e-6);
    CHECK_NEAR(joint_thrust(below) / joint_thrust(above), 1, 1e-6);
    CHECK(below.carried[0] == below.pressure[0] && std::fabs(below.pressure[0] - (onset - h)) < 1e-6);
    // However strong the suction, the lumen does not close.
    CHECK(0 < straight(-9e4).volume[0] && straight(-9e4).volume[0] < 0.5 * rest);
}

/// The walls of the passive side resist; the right side mirrors the left; a longer lever on one side makes the joint
/// asymmetric.
static void sides() {
    const SoftJoint<double> even = soft(40e3, 0), lopsided = soft(40e3, 0, 0.013, 0.012);
    const double left[2] = {2e5, 0}, right[2] = {0, 2e5};
    for (const Section<double>& at : soft_sections) {
        const Bent<double> bent = balance(even, at, left, 0.0), mirror = balance(even, at, right, 0.0);
        CHECK_NEAR(mirror.angle, -bent.angle, 1e-12);
        CHECK_NEAR(mirror.strain, bent.strain, 1e-12);
        CHECK(std::fabs(balance(lopsided, at, left, 0.0).angle + balance(lopsided, at, right, 0.0).angle) > 1e-3);
        double strain = 0;
        CHECK_NEAR(section_moment(even, at, left, bent.angle, 0.0, strain), 0, 1e-12);
    }
    const double none[2] = {0, 0};
    CHECK_NEAR(balance(even, soft_sections[0], none, 0.0).angle, 0, 1e-15);
}

/// Hysteresis: loading and unloading lag, and in between the angle stays where it was.
static void friction_holds() {
    const SoftJoint<double> j = soft(40e3, 0.1);
    const Section<double>& at = soft_sections[0];
    const double top[2] = {2.5e5, 0}, little_less[2] = {2.45e5, 0}, less[2] = {1e5, 0}, none[2] = {0, 0};
    const double loaded = bend_from(j, at, top, 0.0).angle, free = balance(j, at, top, 0.0).angle;
    CHECK(loaded < free && free < balance(j, at, top, 1.0).angle);
    CHECK(bend_from(j, at, little_less, loaded).angle == loaded);
    const double back = bend_from(j, at, less, loaded).angle, between = balance(j, at, less, 0.0).angle;
    CHECK(bend_from(j, at, less, 0.0).angle < between && between < back && back < loaded);
    CHECK(bend_from(j, at, none, 0.0).angle == 0);
    // By hand: N w C_f times the section in the braid times what the walls do not carry of the pressure.
    const auto under = [&](double left, double right) {
        return section_load(j, at, stretch_limits(j.unit), 0.0, 0.0, given_pressures(left, right));
    };
    CHECK_NEAR(joint_friction(under(1e5, 0)), 5 * 0.012 * 0.1 * pi / 4 * 64e-6 * 1e5, 1e-12);
    CHECK(joint_friction(under(-1e4, -1e4)) == 0);
}

/// However high the pressure is, a muscle gets hardly longer than the length at which its lumen closes.
static void locks() {
    const SoftJoint<double> j = soft(40e3, 0);
    const StretchLimits<double> limits = stretch_limits(j.unit);
    CHECK_NEAR(lumen(j.unit, limits.high) / lumen(j.unit, 1.0), 0.05, 1e-9);
    const Joint<double> joint = soft_joint(0);
    const double bend = 4;  // rad: far beyond
    const JointLoad<double> locked = taut_load(joint, bend, 0.0), more = taut_load(joint, bend + 1e-3, 0.0);
    const double stiffness = 5 * limits.stop * 0.012 * 0.012 / (0.03 * (1 + joint.rest));
    CHECK((locked.elastic - more.elastic) / 1e-3 > stiffness);
    CHECK(!(taut_load(joint, std::nan(""), 0.0).elastic == 0));  // NaN stays visible
}

/// With the printed equations the joint bends too far, without hysteresis, and to the right with the opposite sign.
static void as_printed() {
    SoftJoint<double> j = soft(40e3, 0.1);
    const Section<double>& at = soft_sections[0];
    const double left[2] = {2e5, 0}, right[2] = {0, 2e5};
    const double corrected = balance(j, at, left, 0.0).angle;
    j.law = {true, {true, true}, false, false};
    const double printed = balance(j, at, left, 0.0).angle;
    CHECK(1.2 * corrected < printed);
    CHECK_NEAR(balance(j, at, right, 0.0).angle, -printed, 1e-15);
    CHECK(bend_from(j, at, left, 1.0).angle == printed && bend_from(j, at, left, 0.0).angle == printed);
}

/// One section equivalent to all: exact at the pressures for which it was chosen, close elsewhere.
static void one_for_all() {
    const SoftJoint<double> j = soft(40e3, 0);
    const double top[2] = {2.5e5, 0};
    const Section<double> one = one_section(j, top);
    CHECK(one.second < soft_sections[0].second && soft_sections[1].second < one.second);
    CHECK(one.area < soft_sections[0].area && soft_sections[1].area < one.area);
    const auto error = [&](double left, double right) {
        const double pressure[2] = {left, right};
        double angle = 0;
        for (const Section<double>& at : soft_sections) angle += balance(j, at, pressure, 0.0).angle;
        return balance(j, one, pressure, 0.0).angle / angle - 1;
    };
    CHECK_NEAR(error(2.5e5, 0), 0, 1e-9);
    for (double left : {5e4, 1e5, 1.5e5, 2e5}) CHECK_NEAR(error(left, 0), 0, 0.03);
    CHECK_NEAR(error(2e5, 6e4), 0, 0.03);
}

/// The pressures that hold a bend make the joint bend by that angle; their mean is the fill pressure, until the lower
/// one just keeps its braid taut or reaches a limit.
static void holds_and_balances() {
    const Joint<double> joint = soft_joint(6e4);
    for (double angle : {-0.15, 0.0, 0.05, 0.12}) {
        const Holding<double> held = hold(joint, angle, 6e4, -1e9, {});
        const double lower = std::fmin(held.pressure[0], held.pressure[1]);
        const JointLoad<double> load =
            joint_load(joint, angle, held.strain, given_pressures(held.pressure[0], held.pressure[1]));
        const double contact = std::fmin(held.pressure[0] - load.carried[0], held.pressure[1] - load.carried[1]);
        if (std::fabs(held.pressure[0] + held.pressure[1] - 1.2e5) < 1e-6)
            CHECK(0 < contact);
        else
            CHECK(std::fabs(contact) < 1e-6 && 0.1 < std::fabs(angle) && 0 < lower);
        const Bent<double> bent = joint_balance(joint, {0, 0}, given_pressures(held.pressure[0], held.pressure[1]));
        CHECK_NEAR(bent.angle, angle, 1e-8);
        CHECK_NEAR(bent.strain, held.strain, 1e-8);
    }
    CHECK_NEAR(hold(joint, 0.0, 6e4, -1e9, {}).strain, 0, 1e-12);  // no strain: straight and filled
    const Holding<double> limited = hold(joint, 0.05, 6e4, 5e4, {});
    CHECK(limited.pressure[1] == 5e4 && limited.pressure[0] > 1.2e5);
    CHECK(std::isnan(hold(joint, 0.4, 6e4, 5e4, {}).strain));  // a braid at 54.7 degrees pulls no more
}

/// A row of numbers is read into the joint that wrote it.
static void from_a_row() {
    Joint<double> j = soft_joint(6e4, 0.1);
    j.soft.axis = {700, 0.1};
    const DriveUnit<double>& u = j.soft.unit;
    const double row[] = {u.outer, u.inner, u.tan2, u.hose.c1, 0,    u.matrix.c1, 0,    u.friction, 5,   0.012,
                          0.012,   0.03,    2e-3,   6e-7,      4e-3, j.rest,      0.01, 0.2,        700, 0.1};
    static_assert(std::size(row) == joint_column_count);
    const JointLoad<double> a = taut_load(j, 0.1, 0.01), b = taut_load(read_joint(row), 0.1, 0.01);
    CHECK(a.elastic == b.elastic && a.axial == b.axial && a.volume[1] == b.volume[1] && a.friction[0] == b.friction[0]);
}

int main() {
    small_strains_by_hand();
    what_lies_on_the_axis();
    shortening_costs_bend();
    virtual_work({0, 1});
    virtual_work({500, 0.05});
    slack_braid();
    sides();
    friction_holds();
    locks();
    as_printed();
    one_for_all();
    holds_and_balances();
    from_a_row();
    return failures();
}
