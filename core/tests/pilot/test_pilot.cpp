/// Tests of the pilot: whole missions of a purely kinematic fish. It arrives, keeps its depth and fence, and each
/// failure ends by its rule; pulses stay within their bounds for any readings.
#define HYPERTUNA_BOARD  // its memory is what bounds the state
#include <bit>
#include <limits>
#include <type_traits>

#include "allocations.hpp"
#include "cruise.hpp"

using namespace hypertuna;

static_assert(std::is_trivially_copyable_v<Pilot<float>> && std::is_trivially_copyable_v<PilotState<float>>);
static_assert(sizeof(PilotState<float>) + sizeof(PilotStep<float>) < 8192);

template <class T>
struct Box {
    Waypoint<T> waypoint[4] = {{T(0), T(40), T(2), T(0.3), T(2), T(0)},
                               {T(40), T(40), T(2), T(0.3), T(2), T(0)},
                               {T(40), T(0), T(2), T(0.3), T(2), T(0)},
                               {T(0), T(0), T(2), T(0.3), T(2), T(0)}};
    Corner<T> fence[4] = {{T(-20), T(-20)}, {T(60), T(-20)}, {T(60), T(60)}, {T(-20), T(60)}};
    Mission<T> mission = mission_of(waypoint, 4);

    Box() { mission.corner = fence, mission.corners = 4; }
    Box(const Box&) = delete;
};

/// Facts of a run that the pilot does not know.
struct Shown {
    Voyage<double> end{};
    double room = 1e9, deepest = 0, heading = 0, pitch = 0, astray = 0, off_depth = 0, off_track = 0;
    std::uint32_t reported = 0;
    bool finite = true;

    bool was(Reason reason) const { return reported >> int(reason) & 1; }
    double from_home() const { return std::hypot(end.fish.x, end.fish.y); }
};

template <class Spoil = Sound>
static Shown watch(const Mission<double>& mission, const Water& water, double most, std::uint64_t seed = 7,
                   const Spoil& spoil = {}) {
    Shown out;
    double dived = 0;
    const auto look = [&](const Cruiser& fish, const PilotStep<double>& step, int tick) {
        const Estimate<double>& at = step.estimate;
        out.room = std::fmin(out.room, inside(mission, fish.x, fish.y).distance);
        out.deepest = std::fmax(out.deepest, -fish.z);
        out.reported |= step.reasons.flags;
        out.finite = out.finite && is_finite(at.x + at.y + at.depth + at.speed + at.position_error + at.q.w);
        if (tick < 2000) return;
        const double yaw = std::remainder(std::atan2(at.facing.y, at.facing.x) - fish.swung(), 2 * pi);
        out.heading = std::fmax(out.heading, std::fabs(yaw));
        out.pitch = std::fmax(out.pitch, std::fabs(std::asin(at.facing.z) - fish.pitch));
        out.astray = std::fmax(out.astray, std::hypot(at.x - fish.x, at.y - fish.y) / at.position_error);
        dived = step.mode == Mode::transit ? dived + 0.01 : 0;
        if (dived < 40) return;
        const int leg = step.state.guidance.leg;
        const Waypoint<double>& to = mission.waypoint[leg < mission.waypoints ? leg : mission.waypoints - 1];
        out.off_depth = std::fmax(out.off_depth, std::fabs(-fish.z - to.depth));
        const Corner<double>& from = step.state.guidance.from;
        const double length = std::hypot(to.x - from.x, to.y - from.y);
        const double along = ((to.x - from.x) * (at.x - from.x) + (to.y - from.y) * (at.y - from.y)) / length;
        const double across = ((to.x - from.x) * (at.y - from.y) - (to.y - from.y) * (at.x - from.x)) / length;
        if (10 < along && along < length) out.off_track = std::fmax(out.off_track, std::fabs(across));
    };
    out.end = voyage(mission, water, most, seed, look, spoil);
    return out;
}

/// Still water and a trimmed fish; then a current that it does not know of, a beat that is slower than the table says,
/// a crooked tail and a body that sinks.
static void a_box_at_depth() {
    const Box<double> box;
    for (const bool rough : {false, true}) {
        Water water;
        if (rough) water.current[0] = 0.15, water.factor = 0.9, water.lean = 0.1, water.sinking = 0.01;
        const Shown run = watch(box.mission, water, 2000);
        CHECK(run.end.last.mode == Mode::done && run.was(Reason::all_reached));
        CHECK((run.reported & ((1u << ending_reasons) - 1)) == 0);  // no failure was reported
        CHECK(run.from_home() < 3 + 3 * run.end.last.estimate.position_error);
        CHECK(0 < run.room && run.deepest < 2.4);
        CHECK(run.off_depth < 0.15 && run.off_track < 1.5);
        CHECK(run.astray < 3.5);  // true error over reported error
        CHECK(run.heading < (rough ? 15 : 5) * pi / 180 && run.pitch < 1.5 * pi / 180);
        const double factor_error = std::sqrt(run.end.last.state.estimator.way.filter.factor_square);
        CHECK_NEAR(run.end.last.estimate.factor, water.factor, 3 * factor_error);
        CHECK(factor_error < 0.13);
        double mean = 0;  // one voyage's factor is off by its own error, which rounding can turn
        for (std::uint64_t seed = 1; seed <= 6; ++seed)
            mean += watch(box.mission, water, 2000, seed).end.last.estimate.factor / 6;
        CHECK_NEAR(mean, water.factor, 0.12);
        CHECK_NEAR(run.end.last.estimate.current[0], water.current[0], 0.05);
        CHECK_NEAR(run.end.last.estimate.current[1], water.current[1], 0.05);
    }
}

/// Currents to 0.2 m/s any way, offsets of all sensors, and half the time no satellites: always within the fence.
static void inside_the_fence() {
    const Box<double> box;
    for (int seed = 0; seed < 8; ++seed) {
        const auto draw = [&](int what) {
            return uniform<double>(random_bits(99, std::uint64_t(what), std::uint64_t(seed)));
        };
        Water water;
        const double angle = 2 * pi * draw(0), strength = 0.2 * draw(1);
        water.current[0] = strength * std::cos(angle), water.current[1] = strength * std::sin(angle);
        water.factor = 0.9 + 0.2 * draw(2), water.lean = 0.3 * (draw(3) - 0.5), water.sinking = 0.02 * (draw(4) - 0.5);
        water.gap[0] = 100 + 200 * draw(5), water.gap[1] = water.gap[0] + 300;
        Mission<double> mission = box.mission;
        mission.duration = 1500;
        const Shown run = watch(mission, water, 2500, std::uint64_t(seed));
        CHECK(has_ended(run.end.last.mode) && !run.end.last.reasons.has(Reason::adrift) && run.end.fish.time < 1500);
        CHECK(0 < run.room && run.finite);
    }
}

/// A waypoint beyond the fence is left out; with a following current the robot turns in time.
static void what_is_out_of_bounds() {
    const Box<double> box;
    const Waypoint<double> beyond[] = {{0, 40, 2, 0.3, 2, 0}, {100, 40, 2, 0.3, 2, 0}, {0, 0, 2, 0.3, 2, 0}};
    Mission<double> mission = box.mission;
    mission.waypoint = beyond, mission.waypoints = 3;
    Water water;
    water.current[0] = 0.2;
    const Shown run = watch(mission, water, 1500);
    CHECK(run.end.last.mode == Mode::ended && run.was(Reason::skipped) && 0 < run.room);
    CHECK(run.end.last.state.guidance.reached == 2 && run.end.last.state.guidance.passed == 0);
    // A waypoint within the fence, but so near to it that the uncertainty after a dive reaches beyond.
    const Waypoint<double> near[] = {{50, 0, 2, 0.3, 2, 0}, {54, 0, 2, 0.3, 2, 0}};
    mission.waypoint = near, mission.waypoints = 2;
    const Shown close = watch(mission, water, 1500);
    CHECK(close.end.last.mode == Mode::done && 0 < close.room && close.was(Reason::all_reached));
    // The robot does not dive deeper than allowed: the waypoint is passed, not reached.
    const Waypoint<double> deep[] = {{0, 40, 12, 0.3, 2, 0}};
    mission.waypoint = deep, mission.waypoints = 1;
    const Shown dive = watch(mission, Water{}, 1500);
    CHECK(dive.end.last.mode == Mode::ended && dive.was(Reason::passed) && dive.was(Reason::depth_limit) &&
          dive.deepest < 6 && 5 < dive.deepest);
}

/// A fence around neither the robot nor its home: when it is called home, it goes there all the same.
static void a_fence_elsewhere() {
    for (const bool turn : {false, true}) {
        const Box<double> box;
        const Corner<double> corner[4] = {{100, 100}, {160, 100}, {160, 160}, {100, 160}};
        const Waypoint<double> point[] = {{turn ? 30.0 : -30.0, 20, 1, 0.3, 2, 0}};
        Mission<double> mission = box.mission;
        mission.corner = corner, mission.waypoint = point, mission.waypoints = 1;
        mission.home = {10, -10}, mission.duration = 200;
        const Shown run = watch(mission, Water{}, 600);
        CHECK(run.was(Reason::outside) && run.end.last.mode == Mode::ended);
        CHECK(std::hypot(run.end.fish.x - 10, run.end.fish.y + 10) < mission.home_radius + 3);
    }
}

/// On a low battery the robot comes home with its reserve left, and in time.
static void home_while_it_can() {
    const Box<double> box;
    Water water;
    water.volts = 12.6, water.drain = 4.8 / 8000;  // as fast as the pilot assumes
    const Shown flat = watch(box.mission, water, 2000);
    CHECK(flat.end.last.mode == Mode::ended && flat.was(Reason::low_battery) && !flat.was(Reason::all_reached));
    CHECK(flat.from_home() < 8);
    CHECK((flat.end.fish.voltage + 0.2 - 12) / 4.8 > 0.1 - 0.12 / 4.8);  // the reserve, minus the error of the reading
    Mission<double> brief = box.mission;
    brief.duration = 400;
    water = {};
    water.current[0] = 0.15;
    const Shown late = watch(brief, water, 2000);
    CHECK(late.end.last.mode == Mode::ended && late.was(Reason::time_up) && late.end.fish.time < 400);
    CHECK(late.from_home() < 8);
}

/// From 80 s on, at depth and under way, one thing fails.
static void each_failure_has_its_rule() {
    const Box<double> box;
    const double nan = std::nan("");
    const auto late = [](int tick) { return 8000 < tick; };
    const auto run = [&](const auto& spoil) { return watch(box.mission, Water{}, 1200, 7, spoil); };
    const auto home = [&](const Shown& shown, Reason reason) {
        CHECK(shown.was(reason) && shown.end.last.mode == Mode::ended && shown.finite);
        CHECK(shown.from_home() < 8 && shown.end.fish.z > -0.3 && 0 < shown.room);
        CHECK(!shown.was(Reason::all_reached));
    };
    home(run([&](auto& r, int k) { late(k) ? void(r.depth = nan) : void(); }), Reason::depth_lost);
    home(run([&](auto& r, int k) { late(k) ? void(r.depth = 2) : void(); }), Reason::depth_lost);  // stuck
    home(run([&](auto& r, int k) { late(k) ? void(r.robot.voltage = nan) : void(); }), Reason::battery_lost);
    home(run([&](auto& r, int k) { late(k) ? void(r.field[1] = nan) : void(); }), Reason::compass_lost);
    home(run([&](auto& r, int k) { late(k) ? void(r.field[0] = r.field[1] = r.field[2] = 1.9) : void(); }),
         Reason::compass_lost);
    // Without IMU the robot comes up and waits there.
    const Shown blind = run([&](auto& r, int k) { late(k) ? void(r.robot.rate[1] = nan) : void(); });
    CHECK(blind.was(Reason::imu_lost) && blind.end.last.mode == Mode::hold && blind.end.fish.z > -0.15);
    CHECK(blind.finite && std::fabs(blind.end.fish.speed) < 0.05);
    // Where the depth is gone as well, nothing shows the surface: the robot stops a minute after the loss at 80 s.
    const auto blinded = [&](auto& r, int k) { late(k) ? void(r.depth = r.robot.rate[1] = nan) : void(); };
    const auto deep = [&](auto& r, int k) { blinded(r, k), r.fixed = r.fixed && !late(k); };
    const Shown lost = watch(box.mission, Water{}, 145, 7, deep);
    CHECK(lost.was(Reason::imu_lost) && lost.was(Reason::depth_lost) && lost.end.last.mode == Mode::hold);
    // Two minutes without a compass do not suffice for the way home from the far corner.
    const Shown turned = run([&](auto& r, int k) { 30000 < k ? void(r.field[1] = nan) : void(); });
    CHECK(turned.was(Reason::compass_lost) && turned.end.last.mode == Mode::hold && turned.end.fish.z > -0.15);
    // Without satellites the robot keeps trying for a fix, stays near the middle, and comes home by dead reckoning when
    // the time is up.
    Mission<double> brief = box.mission;
    brief.duration = 900;
    const Shown deaf =
        watch(brief, Water{}, 1200, 7, [&](auto& r, int k) { late(k) ? void(r.fixed = false) : void(); });
    CHECK(deaf.was(Reason::no_fix) && deaf.was(Reason::adrift) && deaf.end.last.mode == Mode::ended && 0 < deaf.room);
    CHECK(deaf.from_home() < 3 + 3 * deaf.end.last.estimate.position_error);
}

/// From the start the compass is turned by an angle, or has a constant error: the robot reports this, comes home, and
/// its position is within the reported error.
static void a_compass_that_is_off() {
    const Box<double> box;
    const auto reported = [&](const Shown& shown) {
        CHECK(shown.was(Reason::compass_off) && shown.end.last.mode == Mode::ended && shown.finite);
        CHECK(shown.from_home() < 8 && shown.astray < 3.5 && 0 < shown.room);
        CHECK(!shown.was(Reason::all_reached));
    };
    for (const double degrees : {-40, 45, 90, -135, 180}) {
        const double sine = std::sin(degrees * pi / 180), cosine = std::cos(degrees * pi / 180);
        reported(watch(box.mission, Water{}, 1200, 7, [&](auto& r, int) {
            const double ahead = r.field[0], beside = r.field[1];
            r.field[0] = cosine * ahead - sine * beside, r.field[1] = sine * ahead + cosine * beside;
        }));
    }
    for (const double iron : {0.25, 0.35})
        reported(watch(box.mission, Water{}, 1200, 7, [&](auto& r, int) { r.field[0] += iron; }));
}

/// At the surface, while it waits to dive, every fix is 200 m off for a time. For half a minute the pilot
/// reports it and goes on with the mission. After that it is believed, as if somebody had carried the robot.
static void fixes_of_a_false_place() {
    const Box<double> box;
    for (const double seconds : {3.0, 25.0, 40.0}) {
        double first = 0, worst = 0;
        const auto look = [&](const Cruiser& fish, const PilotStep<double>& step, int) {
            if (first == 0 && step.reasons.has(Reason::fixes_refused)) first = fish.time;
            if (fish.time < 70)
                worst = std::fmax(worst, std::hypot(step.estimate.x - fish.x, step.estimate.y - fish.y));
        };
        const auto spoil = [&](auto& r, int k) {
            if (2500 <= k && k < 2500 + int(100 * seconds)) r.fix[0] += 200;
        };
        const Voyage<double> end = voyage<double>(box.mission, Water{}, 1200, 7, look, spoil);
        CHECK(25 < first && first < 27.5);
        CHECK((worst < 6) == (seconds < 30) && (150 < worst) == (30 < seconds));
        CHECK(end.last.mode == Mode::done && !end.last.reasons.has(Reason::fixes_refused));
        CHECK(std::hypot(end.fish.x, end.fish.y) < 3 + 3 * end.last.estimate.position_error);
    }
    Mission<double> brief = box.mission;  // a robot far outside needs no time to come home
    brief.duration = 1200;
    const Shown far =
        watch(brief, Water{}, 1200, 7, [](auto& r, int k) { r.fix[0] += 2500 <= k && k < 5000 ? 2000 : 0; });
    CHECK(far.was(Reason::fixes_refused) && !far.was(Reason::time_up) && far.end.last.mode == Mode::done);
}

static void fins_that_do_not_follow() {
    const Box<double> box;
    const auto run = [&](double port, double starboard) {
        Water water;
        water.stuck[0] = port, water.stuck[1] = starboard;
        return watch(box.mission, water, 1200);
    };
    for (const double angle : {-0.2, 0.0, 0.3, 0.7}) {
        const Shown port = run(angle, 9), starboard = run(9, angle);
        CHECK(port.was(Reason::port_fin_lost) && !port.was(Reason::starboard_fin_lost));
        CHECK(starboard.was(Reason::starboard_fin_lost) && !starboard.was(Reason::port_fin_lost));
        for (const Shown& shown : {port, starboard}) {
            CHECK(shown.end.last.mode == Mode::ended && shown.from_home() < 8 && shown.end.fish.z > -0.3);
            CHECK(shown.deepest < 3);
        }
    }
    // With one fin stuck hard down the other cannot lift the robot: it stops before its depth limit, and holds.
    const Shown down = run(-0.7, 9);
    CHECK(down.was(Reason::port_fin_lost) && down.was(Reason::stranded) && down.end.last.mode == Mode::hold);
    CHECK(down.deepest < 6 && 0 < down.room);
    // Both fins stuck: if level, it stays at the surface and goes home; if down, it stops.
    const Shown none = run(0, 0);
    CHECK(none.was(Reason::no_answer) && none.end.last.mode == Mode::ended && none.deepest < 0.3);
    const Shown sunk = run(-0.5, -0.5);
    CHECK(sunk.was(Reason::stranded) && sunk.end.last.mode == Mode::hold && sunk.deepest < 6.5);
}

/// A robot that begins 0.6 m under water takes that for the surface: on its way to the surface it presses on upward
/// until it is there, has fixes and flies its mission.
static void a_surface_under_water_is_found_out() {
    const Box<double> box;
    Cruiser deep;
    deep.z = -0.6;
    double top = -1, zero = 1;
    const auto look = [&](const Cruiser& fish, const PilotStep<double>& step, int) {
        top = std::fmax(top, fish.z), zero = std::fmin(zero, step.state.estimator.zero);
    };
    const Voyage<double> end = voyage(box.mission, Water{}, 150, 7, look, Sound{}, deep);
    CHECK(-0.05 < top && zero < 0.1);
    CHECK(end.last.estimate.position_error < 5 && (end.last.reasons.flags & ((1u << ending_reasons) - 1)) == 0);
}

/// Single precision, as on the robot, goes the same way to within a decimeter.
static void float_against_double() {
    const Box<double> fine;
    const Box<float> coarse;
    Water water;
    water.current[1] = 0.1;
    const auto none = [](const Cruiser&, const auto&, int) {};
    for (const double time : {60.0, 120.0}) {
        const Voyage<double> a = voyage(fine.mission, water, time, 3, none);
        const Voyage<float> b = voyage(coarse.mission, water, time, 3, none);
        CHECK(a.last.mode == b.last.mode && a.last.reasons.flags == b.last.reasons.flags);
        CHECK_NEAR(b.fish.x, a.fish.x, 0.1);
        CHECK_NEAR(b.fish.y, a.fish.y, 0.1);
        CHECK_NEAR(b.fish.z, a.fish.z, 0.02);
        CHECK_NEAR(double(b.last.estimate.position_error), a.last.estimate.position_error, 0.02);
    }
}

/// Any bits at all for a reading.
template <class T>
static T any_number(std::uint64_t bits) {
    const T sane = T(double(std::int64_t(bits)) / 9.3e18);
    switch (bits % 8) {
        case 0:
            return std::numeric_limits<T>::quiet_NaN();
        case 1:
            return bits & 64 ? std::numeric_limits<T>::infinity() : -std::numeric_limits<T>::max();
        case 2:
            return std::bit_cast<T>(typename IntegerOf<T>::type(bits >> 8));
        case 3:
            return sane * T(1e4);
        case 4:
            return T(0);
        default:
            return sane * T(10);
    }
}

template <class T>
static void arbitrary_bits(int ticks) {
    const Box<T> box;
    const Pilot<T> pilot = test_pilot<T>();
    PilotStep<T> now{};
    now.state = init(pilot, box.mission);
    bool good = true;
    for (int i = 0; i < ticks && good; ++i) {
        PilotReadings<T> r{};
        std::uint64_t channel = 0;
        // Half of the time all readings are sound, so that everything gets going.
        const bool wild = i / 500 % 2 == 1;
        const auto draw = [&](T calm) {
            const std::uint64_t bits = random_bits(11, channel++, std::uint64_t(i));
            return wild ? any_number<T>(bits) : calm + T(1e-3) * normal<T>(bits);
        };
        r.robot = calm_readings<T>();
        for (T& x : r.robot.bend) x = draw(x);
        for (T& x : r.robot.pressure) x = draw(x);
        for (T& x : r.robot.rate) x = draw(x);
        for (T& x : r.robot.acceleration) x = draw(x);
        r.robot.voltage = draw(T(15)), r.depth = draw(T(0.5));
        r.field[0] = draw(T(0)), r.field[1] = draw(T(0.5)), r.field[2] = draw(T(-0.8));
        r.fix[0] = draw(T(0)), r.fix[1] = draw(T(0)), r.fixed = i % 7 == 0;
        now = fly(pilot, now.state, r, box.mission);
        for (int s = 0; s < 6; ++s)
            good = good && pilot.controller.pulse_min <= now.output.pulse[s] &&
                   now.output.pulse[s] <= pilot.controller.pulse_max;
        const Estimate<T>& at = now.estimate;
        T sum = at.x + at.y + at.depth + at.sink + at.speed + at.position_error + at.drift_error + at.q.w + at.rate.x +
                at.facing.z + now.state.guidance.steering.turn_sum + now.state.guidance.steering.climb_sum;
        const WayFilter<T>& way = now.state.estimator.way.filter;
        sum += way.position_square + way.current_square + way.factor_square + square(way.position_current) +
               square(way.position_factor) + square(way.current_factor);
        good = good && is_finite(sum);
        if (!good) std::fprintf(stderr, "at tick %d\n", i);
    }
    CHECK(good);
}

int main() {
    const int before = allocations;
    a_box_at_depth();
    inside_the_fence();
    a_fence_elsewhere();
    what_is_out_of_bounds();
    home_while_it_can();
    each_failure_has_its_rule();
    a_compass_that_is_off();
    fixes_of_a_false_place();
    fins_that_do_not_follow();
    a_surface_under_water_is_found_out();
    float_against_double();
    arbitrary_bits<float>(100000);
    arbitrary_bits<double>(100000);
    CHECK(allocations == before);
    return failures();
}
