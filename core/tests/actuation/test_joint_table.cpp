/// Joint tables: cubics by hand, the segments' bends from one angle, virtual work, order of the interpolation, the
/// stops.
#include "check.hpp"
#include "hypertuna/actuation/joint_table.hpp"

using namespace hypertuna;

static const Segment<double> segments[3] = {{0.02, 0.28}, {0.02, 0.17}, {0.02, 0.09}};

static SoftJoint<double> joint() {
    const double t = std::tan(37 * pi / 180);
    return {{8e-3, 5.6e-3, t * t, 0, {40e3, 0}, {24e3, 0}, 0.1}, 5, {0.0139, 0.0137}, 3, segments, {false, {}, true}};
}

template <int Points>
struct Filled {
    JointPoint<double> point[Points];
    JointTable<double> table;
    explicit Filled(double reach) : table{point, Points, -reach, 2 * reach / (Points - 1), 0.01, 50.0} {
        tabulate(joint(), reach, Points, point);
    }
};

static void cubic_by_hand() {
    // t^3 - 2 t + 1
    for (double t : {0.0, 0.3, 1.0}) {
        const Cubic<double> c = cubic(1.0, 0.0, -2.0, 1.0, t);
        CHECK_NEAR(c.value, t * t * t - 2 * t + 1, 1e-15);
        CHECK_NEAR(c.slope, 3 * t * t - 2, 1e-15);
    }
}

/// Under pressure on one side the table balances where the sum of the segments does.
static void bends_as_the_segments() {
    const Filled<129> filled(0.5);
    for (int side : {0, 1})
        for (double pressure : {2e4, 1e5, 2.5e5}) {
            double both[2] = {0, 0}, angle = 0;
            both[side] = pressure;
            for (int i = 0; i < 3; ++i) angle += balance(joint(), i, both, 0.0);
            const JointLoad<double> load = joint_load(filled.table, angle);
            CHECK_NEAR(joint_moment(load, both), 0, 1e-6);
            CHECK(std::fabs(load.elastic) > 0.01);
        }
    const double none[2] = {0, 0};
    CHECK_NEAR(joint_moment(joint_load(filled.table, 0.0), none), 0, 1e-12);
}

/// The moment is minus the slope of what the table says is stored, between its points and beyond its ends.
static void virtual_work() {
    const Filled<65> filled(0.5);
    const double h = 1e-6;
    for (double angle = -0.63; angle < 0.63; angle += 0.0317) {
        const JointLoad<double> now = joint_load(filled.table, angle), before = joint_load(filled.table, angle - h),
                                after = joint_load(filled.table, angle + h);
        CHECK_NEAR((after.energy - before.energy) / (2 * h), -now.elastic, 1e-7);
        for (int s : {0, 1}) CHECK_NEAR((after.volume[s] - before.volume[s]) / (2 * h), now.slope[s], 1e-13);
    }
}

/// How far a table is off the segments themselves, at the same place between all points of its inner half.
struct Error {
    double energy, moment;
};
template <int Points>
static Error error() {
    const Filled<Points> filled(0.5);
    Error sum{0, 0};
    for (int k = Points / 4; k < 3 * Points / 4; ++k) {
        const double angle = filled.table.first + (k + 0.31) * filled.table.step;
        const int side = angle < 0;
        const JointPoint<double> exact = tabulated(joint(), side, holding_pressure(joint(), side, angle, 0.0));
        const JointLoad<double> load = joint_load(filled.table, angle);
        sum.energy += std::fabs(load.energy - exact.energy) / Points;
        sum.moment += std::fabs(load.elastic + exact.energy_slope) / Points;
    }
    return sum;
}

/// Fourth order in the step for the energy, third for the moment.
static void order() {
    const Error coarse = error<17>(), fine = error<33>();
    CHECK(13 < coarse.energy / fine.energy && coarse.energy / fine.energy < 20);
    CHECK(7 < coarse.moment / fine.moment && coarse.moment / fine.moment < 10);
    CHECK(fine.moment < 1e-4);  // N m, of some
}

/// Beyond the ends: no jump, and the stop's stiffness.
static void stops() {
    const Filled<65> filled(0.5);
    for (int sign : {-1, 1}) {
        const JointLoad<double> end = joint_load(filled.table, 0.5 * sign), past = joint_load(filled.table, 0.6 * sign);
        CHECK_NEAR(end.elastic - past.elastic, 50 * 0.1 * sign, 1e-9);
        CHECK_NEAR(past.volume[0] - end.volume[0], 0.1 * sign * end.slope[0], 1e-15);
    }
    const double nan = std::nan("");
    CHECK(!(joint_load(filled.table, nan).elastic == 0));  // told, not hidden
}

/// Single precision looks up the same joint.
static void in_single_precision() {
    const Filled<65> filled(0.5);
    JointPoint<float> point[65];
    const auto* from = reinterpret_cast<const double*>(filled.point);
    auto* to = reinterpret_cast<float*>(point);
    for (std::size_t k = 0; k < 65 * sizeof(JointPoint<float>) / sizeof(float); ++k) to[k] = float(from[k]);
    const JointTable<float> table{point, 65, -0.5f, 1.0f / 64, 0.01f, 50.0f};
    for (double angle = -0.6; angle < 0.6; angle += 0.037) {
        const JointLoad<double> exact = joint_load(filled.table, angle);
        const JointLoad<float> single = joint_load(table, float(angle));
        CHECK_NEAR(single.elastic, exact.elastic, 1e-4);
        CHECK_NEAR(single.slope[1] / exact.slope[1], 1, 1e-3);
    }
}

static void friction_and_stiffness() {
    const Filled<65> filled(0.5);
    const JointLoad<double> load = joint_load(filled.table, 0.1);
    const double both[2] = {1e5, 0};
    double limit = 0;  // contact area hardly changes over such an angle
    for (int i = 0; i < 3; ++i) limit += friction_limit(joint(), i, 0, 1e5, 0.033) / 3;
    CHECK_NEAR(load.friction[0] * (1e5 - load.carried[0]) / limit, 1, 0.02);
    CHECK(joint_friction(load, both) >= load.friction[0] * (1e5 - load.carried[0]));
    const double loose[2] = {-1e6, -1e6};
    CHECK(joint_friction(load, loose) == 0);

    const JointStiffness<double> k = stiffness_at_rest(joint());
    CHECK_NEAR((k.matrix + k.walls) * 1e-4, -joint_load(filled.table, 1e-4).elastic, 1e-7);
    CHECK(k.matrix > 0 && k.walls > 0);
    CHECK_NEAR(joint_reach(joint(), 0, 0.5, 2e7) / joint_reach(joint(), 1, 0.5, 2e7), 1, 0.05);
    CHECK(joint_reach(joint(), 0, 0.5, 2e7) < joint_reach(joint(), 0, 0.05, 2e7));
}

int main() {
    cubic_by_hand();
    bends_as_the_segments();
    virtual_work();
    order();
    stops();
    in_single_precision();
    friction_and_stiffness();
    return failures();
}
