/// Tests of the estimates of attitude and depth: by hand where possible, else against a truth with noise, offsets and
/// the shaking of the beat.
#include "cruise.hpp"

using namespace hypertuna;

static Quaternion<double> euler(double yaw, double pitch, double roll) {
    const double cy = std::cos(yaw / 2), sy = std::sin(yaw / 2), cp = std::cos(pitch / 2), sp = std::sin(pitch / 2),
                 cr = std::cos(roll / 2), sr = std::sin(roll / 2);
    return {cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr};
}

/// Gravity and magnetic field alone determine any attitude.
static void two_vectors_make_an_attitude() {
    for (double yaw = -3; yaw < 3.2; yaw += 0.5)
        for (double pitch : {-1.4, -0.3, 0.0, 0.8})
            for (double roll : {-3.0, -1.0, 0.0, 0.4, 2.0}) {
                const Quaternion<double> q = euler(yaw, pitch, roll);
                const Rotation<double> at = rotation(q);
                const Vector<double> field = to_body(at, {0.0, 0.4, -0.9});
                Quaternion<double> got{};
                CHECK(attitude_from(9.81 * at.up, field, got));
                const double same = got.w * q.w + got.x * q.x + got.y * q.y + got.z * q.z;
                CHECK_NEAR(std::fabs(same), 1, 1e-12);
            }
    Quaternion<double> none{};
    CHECK(!attitude_from(Vector<double>{0, 0, 9.81}, Vector<double>{0, 0, -1}, none));
    CHECK(!attitude_from(Vector<double>{0, 0, 0}, Vector<double>{0, 1, 0}, none));
}

/// A robot that faces north with an offset of its gyroscope: the attitude converges, and the offset is learned.
static void the_offset_of_the_gyroscope_is_learned() {
    const AttitudeModel<double> model = test_pilot<double>().estimator.attitude;
    AttitudeState<double> state{};
    state.q.w = 1;
    AttitudeInput<double> in{};
    in.gyro = in.gravity = in.magnet = true;
    in.acceleration = {0, 0, 9.81};
    in.field = {0, -0.45, -0.9};  // the robot faces -x, the field +y is then to port: it faces east
    in.rate = {0.004, -0.003, 0.005};
    for (int k = 0; k < 12000; ++k) state = attitude_step(model, state, in);
    CHECK_NEAR(state.drift.x, 0.004, 1e-5);
    CHECK_NEAR(state.drift.y, -0.003, 1e-5);
    CHECK_NEAR(state.drift.z, 0.005, 1e-5);
    const Rotation<double> at = rotation(state.q);
    CHECK_NEAR(-at.east.x, 1, 1e-6);
    CHECK_NEAR(at.up.z, 1, 1e-6);
    // An offset larger than the plausible one is not learned.
    in.rate = {0.4, 0, 0};
    for (int k = 0; k < 1000; ++k) state = attitude_step(model, state, in);
    CHECK(std::fabs(state.drift.x) <= model.drift_max);
}

/// The magnetic field corrects the attitude about the vertical only, for any reading.
static void a_false_field_does_not_tilt() {
    const AttitudeModel<double> model = test_pilot<double>().estimator.attitude;
    AttitudeState<double> state{};
    state.q = euler(0.3, 0.2, -0.1);
    state.known = true;
    const Vector<double> up = rotation(state.q).up;
    AttitudeInput<double> in{};
    in.gyro = in.magnet = true;
    in.field = {0.3, 0.9, 0.2};
    for (int k = 0; k < 3000; ++k) state = attitude_step(model, state, in);
    const Vector<double> now = rotation(state.q).up;
    CHECK_NEAR(norm(now - up), 0, 0.003);  // change by the learned offset of the gyroscope
}

/// A steady turn at 0.4 m/s and 0.3 rad/s adds 0.12 m/s^2 sideways: 0.7 degrees, if it were taken for gravity.
static void a_turn_is_no_roll() {
    const AttitudeModel<double> model = test_pilot<double>().estimator.attitude;
    for (const bool known : {true, false}) {
        AttitudeState<double> state{};
        state.q.w = 1, state.known = true;
        AttitudeInput<double> in{};
        in.gyro = in.gravity = true;
        in.rate = {0, 0, 0.3};
        in.acceleration = {0, -0.12, 9.81};
        in.speed = known ? 0.4 : 0;
        for (int k = 0; k < 4000; ++k) state = attitude_step(model, state, in);
        const double roll = std::asin(rotation(state.q).up.y) * 180 / pi;
        CHECK(known ? std::fabs(roll) < 0.01 : std::fabs(roll) > 0.1);
    }
}

/// Iron on board, half as strong as the level field: the compass is up to 30 deg off, and turns by 2/3 to twice the
/// angle that the robot turns by. The gyroscope tells, without any fix; a sound compass leaves nothing.
static void iron_turns_against_the_gyroscope() {
    const Estimator<double> model = test_pilot<double>().estimator;
    for (const double iron : {0.0, 0.25}) {
        const double start[2] = {0, 0}, rate = 0.3;
        EstimatorState<double> state = init(model, start);
        bool off = false;
        double before = 0;
        for (int k = 0; k < 4000; ++k) {
            const double yaw = k < 1500 ? 0 : rate * 0.01 * (k - 1500);
            const Vector<double> field = to_body(rotation(euler(yaw, 0, 0)), {0.0, 0.5, -0.866});
            PilotReadings<double> r{};
            r.robot = calm_readings<double>();
            for (int i = 0; i < 3; ++i) r.robot.rate[i] = i == 2 && 1500 <= k ? rate : 0;
            for (int i = 0; i < 3; ++i) r.robot.acceleration[i] = i == 2 ? 9.81 : 0;
            r.field[0] = field.x + iron, r.field[1] = field.y, r.field[2] = field.z + 1e-9 * (k % 2);
            r.depth = 1 + 0.001 * (k % 7);
            off = estimate(model, state, r, 0.0, true, 0.0).compass_off;
            if (k == 1500) before = state.way.filter.factor_square;
        }
        CHECK(off == (0 < iron) && (0 < state.way.apart) == (0 < iron));
        CHECK((0.3 * 0.3 < state.way.filter.factor_square - before) == (0 < iron));
    }
}

/// The estimate follows a step of depth within 4 / rate; a sink rate of 0.1 m/s leaves no error; noise of 1 cm leaves 2
/// mm.
static void depth_follows() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0};
    EstimatorState<double> state = init(model, start);
    keep_zero(state, 0.0);  // the robot was switched on at the surface
    double noise = 0;
    for (int k = 0; k < 4000; ++k) {
        const double depth = 1 + 0.001 * k, error = 0.01 * normal<double>(random_bits(1, 2, std::uint64_t(k)));
        watch_depth(model, state, depth + error, 0.1, 0.3);
        if (k > 1000) noise += (state.depth - depth) * (state.depth - depth) / 3000;
    }
    CHECK_NEAR(state.sink, 0.1, 0.01);
    CHECK(std::sqrt(noise) < 0.002);
    // NaN readings are left out; meanwhile the depth continues at its last rate, for a while.
    for (int k = 0; k < 100; ++k) CHECK(!watch_depth(model, state, std::nan(""), 0.1, 0.3));
    CHECK_NEAR(state.depth, 5.05, 0.01);
    CHECK(std::fabs(state.sink) < 0.03);
}

/// A stuck sensor is detected at once during a descent, within 5 s of a level swim, and never at rest.
static void a_stuck_depth_shows() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0};
    const auto ticks_until_lost = [&](double climb, double speed) {
        EstimatorState<double> state = init(model, start);
        for (int k = 0; k < 1000; ++k)
            if (!watch_depth(model, state, 1.5, climb, speed)) return k;
        return 1000;
    };
    CHECK(ticks_until_lost(0.1, 0.3) <= 30);
    CHECK(450 < ticks_until_lost(0, 0.3) && ticks_until_lost(0, 0.3) < 550);
    CHECK(ticks_until_lost(0, 0) == 1000);
}

/// A working sensor of coarse steps without noise repeats its reading: in a level swim for good, and within a step on
/// the way down. A stuck one shows on the way down alone.
static void a_coarse_depth_is_no_stuck_one() {
    Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0}, step = 0.05;
    model.depth_repeat = 2 * step;
    const auto ticks_until_lost = [&](double climb, double sinking) {
        EstimatorState<double> state = init(model, start);
        for (int k = 0; k < 3000; ++k)
            if (!watch_depth(model, state, quantized(step, 1 + 0.01 * sinking * k), climb, 0.3)) return k;
        return 3000;
    };
    CHECK(ticks_until_lost(0, 0) == 3000);
    for (double climb : {0.06, 0.1, 0.3}) {
        CHECK(ticks_until_lost(climb, climb) == 3000);
        CHECK(ticks_until_lost(climb, 0.6 * climb) == 3000);  // it sinks more slowly than it seems
        CHECK_NEAR(ticks_until_lost(climb, 0), 2 * step / (0.01 * climb) + 25, 3);
    }
}

/// Reading of the sensor of a robot that stays at a depth [m] for some ticks, in weather equivalent to `air` [m].
static void stay(const Estimator<double>& model, EstimatorState<double>& state, double air, double depth, int ticks) {
    for (int k = 0; k < ticks; ++k) {
        const double noise = 0.005 * normal<double>(random_bits(3, 4, std::uint64_t(k)));
        watch_depth(model, state, air + depth + noise, 0.0, 0.0);
    }
}

/// Depth counts from what the sensor shows in the first second, from a mountain lake to high weather at the sea.
static void the_surface_is_seen_at_boot() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0};
    for (double air : {-4.0, -1.53, -0.1, 0.0, 0.1, 0.4}) {
        EstimatorState<double> state = init(model, start);
        stay(model, state, air, 0.0, 100);
        CHECK(state.zeroed);
        CHECK_NEAR(state.zero, air, 0.01);
        stay(model, state, air, 2.0, 1000);
        CHECK_NEAR(state.depth, 2, 0.01);
    }
}

/// A sensor that starts under water, out of range, or after the first second sets no surface; on command the surface is
/// set where the robot is, unless no air has that pressure.
static void no_surface_under_water() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0};
    EstimatorState<double> state = init(model, start);
    stay(model, state, 0, 3.0, 300);
    CHECK(!state.zeroed && state.zero == 0);
    CHECK_NEAR(state.depth, 3, 0.01);
    CHECK(!zero_depth(model, state) && !state.zeroed);
    stay(model, state, 0, 0.05, 1000);
    CHECK(zero_depth(model, state) && state.zeroed);
    CHECK_NEAR(state.zero, 0.05, 0.01);

    state = init(model, start);
    for (int k = 0; k < 200; ++k) watch_depth(model, state, k % 2 ? std::nan("") : -11.0, 0.0, 0.0);
    CHECK(!state.zeroed && !zero_depth(model, state));
    stay(model, state, 0.3, 0, 200);  // it answers late
    CHECK(!state.zeroed && state.zero == 0);

    keep_zero(state, -1.5);  // after a restart at depth
    stay(model, state, -1.5, 2.0, 1000);
    CHECK(state.zeroed && state.zero == -1.5);
    CHECK_NEAR(state.depth, 2, 0.01);
}

/// A robot that lost its power under water takes its depth for the surface, until it has risen.
static void a_zero_under_water_heals() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0};
    EstimatorState<double> state = init(model, start);
    stay(model, state, 0, 0.5, 100);
    CHECK_NEAR(state.zero, 0.5, 0.01);
    for (int k = 0; k < 1000; ++k) stay(model, state, 0, 0.5 - 0.0005 * k, 1);
    stay(model, state, 0, 0.0, 400);
    CHECK_NEAR(state.zero, 0, 0.01);
}

/// A fix proves that the antenna, 8.6 cm above the sensor, is out of the water: weather that rose by 20 cm of water is
/// detected in half a minute, a descent by 1.1 m in some seconds. At depths at which the antenna can be dry nothing is
/// corrected.
static void fixes_tell_the_surface() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double start[2] = {0, 0};
    const auto after = [&](double rise, double pitch, int seconds) {
        EstimatorState<double> state = init(model, start);
        keep_zero(state, -1.5);
        state.attitude.known = true, state.attitude.q = euler(0, pitch, 0);
        const Vector<double> up = rotation(state.attitude.q).up;
        for (int k = 0; k < 100 * seconds; ++k) {
            PilotReadings<double> r{};
            r.robot = calm_readings<double>();
            const double still[3] = {9.81 * up.x, 9.81 * up.y, 9.81 * up.z};
            for (int i = 0; i < 3; ++i) r.robot.acceleration[i] = still[i];
            r.field[1] = 0.5, r.field[2] = -0.866;
            r.depth = -1.45 + rise + 0.005 * normal<double>(random_bits(6, 7, std::uint64_t(k)));
            r.fixed = k % 100 == 0;
            estimate(model, state, r, 0.0, true, 0.0);
        }
        return state;
    };
    CHECK(after(0, 0, 60).zero == -1.5);
    const EstimatorState<double> risen = after(0.15, 0, 40);
    CHECK_NEAR(risen.depth, 0.086, 0.01);
    CHECK(after(0.15, 0, 4).depth > 0.15);  // slowly
    CHECK_NEAR(after(1.1, 0, 10).depth, 0.086, 0.02);
    // A nose that points up holds the antenna, 17 cm behind it, lower; one that points down, higher.
    CHECK_NEAR(after(0.03, 0.17, 60).depth, 0.086 * std::cos(0.17) - 0.17 * std::sin(0.17), 0.01);
    CHECK(after(0.05, -0.17, 60).zero == -1.5);
}

/// A compass that shows 10 deg west of north: with the declination set, a robot that faces true east knows this, and
/// where it swims.
static void declination_turns_the_heading() {
    const Estimator<double> model = test_pilot<double>().estimator;
    for (const double declination : {-10 * pi / 180, 0.0, 25 * pi / 180}) {
        const double start[2] = {0, 0};
        EstimatorState<double> state = init(model, start);
        PilotReadings<double> r{};
        r.robot = calm_readings<double>();
        for (int k = 0; k < 3; ++k) r.robot.acceleration[k] = k == 2 ? 9.81 : 0;
        const Rotation<double> at = rotation(euler(pi, 0, 0));
        const Vector<double> field = to_body(at, {0.5 * std::sin(declination), 0.5 * std::cos(declination), -0.8});
        r.field[0] = field.x, r.field[1] = field.y, r.field[2] = field.z;
        Estimate<double> out{};
        for (int k = 0; k < 2000; ++k) {
            r.depth = 1 + 0.001 * (k % 7);
            for (int i = 0; i < 3; ++i) r.field[i] += 1e-9 * (k % 2 ? 1 : -1);
            out = estimate(model, state, r, 0.3, true, declination);
        }
        CHECK_NEAR(out.facing.x, 1, 1e-6);
        CHECK_NEAR(out.facing.y, 0, 1e-6);
        CHECK(out.x > 2);
        CHECK_NEAR(out.y, 0, 1e-5);
        CHECK_NEAR(-rotation(out.q).east.x, 1, 1e-6);
    }
}

/// A head that swings by 7 deg at 2 Hz, and half a second without IMU, which the controller then distrusts for another:
/// the gap is reported, and three seconds later the heading is right again, for gaps that begin at any phase of the
/// swing.
static void a_gap_of_the_imu_is_no_turn() {
    const Estimator<double> model = test_pilot<double>().estimator;
    const double beat = 2 * pi * 2, swing = 7 * pi / 180;
    for (int phase = 0; phase < 50; phase += 5) {
        const double start[2] = {0, 0};
        EstimatorState<double> state = init(model, start);
        double worst = 0;
        for (int k = 0; k < 4000; ++k) {
            const double t = 0.01 * k, yaw = swing * std::sin(beat * t);
            const Vector<double> field = to_body(rotation(euler(yaw, 0, 0)), {0.0, 0.5, -0.866});
            PilotReadings<double> r{};
            r.robot = calm_readings<double>();
            for (int i = 0; i < 3; ++i) r.robot.rate[i] = i == 2 ? swing * beat * std::cos(beat * t) : 0;
            for (int i = 0; i < 3; ++i) r.robot.acceleration[i] = i == 2 ? 9.81 : 0;
            r.field[0] = field.x, r.field[1] = field.y, r.field[2] = field.z;
            r.depth = 1 + 0.001 * (k % 7);
            const int since = k - 2000 - phase;
            const bool gap = 0 <= since && since < 50, trusted = since < 5 || 150 <= since;
            if (gap) r.robot.rate[0] = r.robot.rate[1] = r.robot.rate[2] = r.robot.acceleration[0] = std::nan("");
            const Estimate<double> out = estimate(model, state, r, 0.3, trusted, 0.0);
            CHECK(out.attitude == (trusted && k > 0) || k == 0);
            const double off = std::atan2(out.facing.y, out.facing.x) - (yaw + pi);
            if (450 <= since) worst = std::fmax(worst, std::fabs(std::remainder(off, 2 * pi)));
        }
        CHECK(worst < 3 * pi / 180);  // 131 deg, when the last rate went on
    }
}

int main() {
    two_vectors_make_an_attitude();
    the_offset_of_the_gyroscope_is_learned();
    a_false_field_does_not_tilt();
    a_turn_is_no_roll();
    iron_turns_against_the_gyroscope();
    depth_follows();
    a_stuck_depth_shows();
    a_coarse_depth_is_no_stuck_one();
    the_surface_is_seen_at_boot();
    no_surface_under_water();
    a_zero_under_water_heals();
    fixes_tell_the_surface();
    declination_turns_the_heading();
    a_gap_of_the_imu_is_no_turn();
    return failures();
}
