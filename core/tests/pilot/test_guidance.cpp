/// Tests of guidance: when a waypoint counts as reached, how it is held, what ends a mission early, and a current
/// faster than the fish.
#include "cruise.hpp"

using namespace hypertuna;

/// A leg that has ended: what the fish believed, and the truth.
struct Ended {
    bool reached;
    double believed, away, error, depth;  // m: believed and true distance, reported error, excess depth
};

struct Watched {
    Voyage<double> end{};
    Ended leg[8];
    int legs = 0;
    std::uint32_t reported = 0;
    double swept_at = 0;  // s

    bool was(Reason reason) const { return reported >> int(reason) & 1; }
    const GuidanceState<double>& guidance() const { return end.last.state.guidance; }
    double from_home() const { return std::hypot(end.fish.x, end.fish.y); }
};

template <class Look>
static Watched watch(const Mission<double>& mission, const Water& water, double most, const Look& look) {
    Watched out;
    int reached = 0;
    out.end =
        voyage<double>(mission, water, most, 7, [&](const Cruiser& fish, const PilotStep<double>& step, int tick) {
            const GuidanceState<double>& at = step.state.guidance;
            if (out.legs < at.leg && out.legs < 8) {
                const Waypoint<double>& to = mission.waypoint[at.leg - 1];
                out.leg[out.legs++] = {reached < at.reached, std::hypot(step.estimate.x - to.x, step.estimate.y - to.y),
                                       std::hypot(fish.x - to.x, fish.y - to.y), step.estimate.position_error,
                                       -fish.z - to.depth};
                reached = at.reached;
            }
            if (step.reasons.has(Reason::swept) && out.swept_at == 0) out.swept_at = fish.time;
            out.reported |= step.reasons.flags;
            look(fish, step, tick);
        });
    return out;
}

static Watched watch(const Mission<double>& mission, const Water& water, double most) {
    return watch(mission, water, most, [](const Cruiser&, const auto&, int) {});
}

static Water without_satellites() {
    Water water;
    water.gap[1] = 1e6;
    return water;
}

/// Waypoints closer than the fish swims in its minute at the surface are reached at their depth and within their
/// radius, by its estimate.
static void reached_at_its_depth() {
    for (const double depth : {0.0, 0.5, 2.0}) {
        const Waypoint<double> point[] = {{0, 6, depth, 0.3, 2, 0}, {6, 6, depth, 0.3, 2, 0}};
        const Watched run = watch(mission_of(point, 2), Water{}, 900);
        CHECK(run.end.last.mode == Mode::done && run.guidance().reached == 2 && run.legs == 2);
        for (int k = 0; k < run.legs; ++k) {
            const Ended& leg = run.leg[k];
            CHECK(leg.reached && leg.believed < 2 && leg.error <= 2 && leg.away < 2 + 3 * leg.error);
            CHECK(std::fabs(leg.depth) < 0.3);
        }
    }
}

/// Without satellites no waypoint counts as reached while its place is uncertain: waypoints are passed, and arrival at
/// home is not claimed.
static void unknown_is_not_reached() {
    const Waypoint<double> point[] = {{0, 30, 1, 0.3, 2, 0}, {30, 30, 1, 0.3, 2, 0}};
    Mission<double> mission = mission_of(point, 2);
    mission.duration = 600;
    Water water = without_satellites();
    water.current[0] = 0.1;
    const Watched run = watch(mission, water, 1500);
    CHECK(run.end.last.mode == Mode::ended && run.was(Reason::adrift) && run.was(Reason::passed));
    CHECK(run.guidance().reached == 0 && 0 < run.guidance().passed && !run.was(Reason::all_reached));
    // Back at the surface with satellites, but with a waypoint so small that no fix can confirm it as reached.
    const Waypoint<double> small[] = {{0, 30, 1, 0.3, 0.5, 0}};
    const Watched vague = watch(mission_of(small, 1), Water{}, 900);
    CHECK(vague.end.last.mode == Mode::ended && vague.guidance().passed == 1 && !vague.was(Reason::adrift));
    CHECK(vague.from_home() < 3 + 3 * vague.end.last.estimate.position_error);
}

/// At home without a fix the fish keeps circling where home should be; a late fix brings it home.
static void home_is_found_when_a_fix_comes() {
    const Waypoint<double> point[] = {{0, 20, 1, 0.3, 2, 0}};
    Water water;
    water.current[0] = 0.05, water.gap[0] = 70, water.gap[1] = 700;
    const Watched run = watch(mission_of(point, 1), water, 1500);
    CHECK(run.was(Reason::adrift) && !run.end.last.reasons.has(Reason::adrift));
    CHECK(has_ended(run.end.last.mode) && 700 < run.end.fish.time && run.from_home() < 3 + 5);
}

/// Hold on a circle at depth, and at rest at the surface: for the required time, and within the radius plus the error
/// of position.
static void holds_at_a_waypoint() {
    for (const double depth : {0.0, 1.5}) {
        const Waypoint<double> point[] = {{0, 15, depth, 0.3, 3, 60}};
        double away = 0, off = 0, held = 0, resting = 0;
        Water water;
        water.current[0] = 0.05;
        const Watched run =
            watch(mission_of(point, 1), water, 1500, [&](const Cruiser& fish, const PilotStep<double>& step, int) {
                const GuidanceState<double>& at = step.state.guidance;
                if (at.held == 0 || 0 < at.leg) return;
                held += 0.01, resting += step.command.amplitude[0] == 0 ? 0.01 : 0;
                away = std::fmax(away, std::hypot(fish.x, fish.y - 15));
                off = std::fmax(off, std::fabs(-fish.z - depth));
            });
        CHECK(run.end.last.mode == Mode::done && run.legs == 1 && run.leg[0].reached);
        CHECK(59 < held && held < 300 && away < 3 + 3 * 2);
        CHECK((15 < resting) == (depth == 0.0));
        if (depth == 0.0) CHECK(off < 0.2);
    }
}

/// Called back by the ground, after all waypoints too, a mission is never done.
static void called_back_is_not_done() {
    const Waypoint<double> point[] = {{0, 10, 0, 0.3, 2, 0}};
    const Mission<double> mission = mission_of(point, 1);
    const Pilot<double> pilot = test_pilot<double>();
    for (const int leg : {0, 1}) {
        GuidanceState<double> state = init(pilot.guidance, mission);
        state.leg = state.reached = leg, state.rising = false;
        state.reasons.set(Reason::all_reached, leg == 1), state.reasons.set(Reason::recalled);
        Estimate<double> at{};
        at.depths = at.attitude = at.compass = at.fix = true, at.position_error = 1.6, at.factor = 1, at.facing.x = 1;
        state = guide(pilot.guidance, state, at, {15.5, false, false}, mission).state;
        CHECK(state.mode == Mode::ended);
    }
}

/// At home a known position is enough. Before a dive the current must be known too, and the position so well that it is
/// still within the radius after the dive.
static void fixes_are_enough() {
    const Waypoint<double> point[] = {{0, 40, 1, 0.3, 2, 0}};
    const Mission<double> mission = mission_of(point, 1);
    const Pilot<double> pilot = test_pilot<double>();
    const auto after = [&](Mode mode, double error, double drift) {
        GuidanceState<double> state = init(pilot.guidance, mission);
        state.mode = mode, state.rising = true;
        state.reasons.set(Reason::recalled, mode == Mode::home);
        Estimate<double> at{};
        at.depths = at.attitude = at.compass = at.fix = true, at.factor = 1, at.facing.x = 1;
        at.y = mode == Mode::home ? 0 : 39;
        at.position_error = error, at.drift_error = drift;
        return guide(pilot.guidance, state, at, {15.5, false, false}, mission).state.mode;
    };
    CHECK(after(Mode::home, 1.6, 0.05) == Mode::ended && after(Mode::home, 3.5, 0.01) == Mode::home);
    CHECK(after(Mode::surface, 1.6, 0.05) == Mode::surface && after(Mode::surface, 1.6, 0.01) == Mode::transit);
    CHECK(after(Mode::surface, 1.9, 0.02) == Mode::surface);
}

/// A current faster than the fish: the fish reports it within a minute and a half, comes up, swims against the current
/// until its charge is at the reserve, and then drifts; it goes home if the current eases before that.
static void swept_and_back() {
    const Waypoint<double> point[] = {{0, 40, 2, 0.3, 2, 0}};
    Mission<double> mission = mission_of(point, 1);
    Water water;
    water.current[1] = 0.6;
    for (const double eases : {1e9, 150.0}) {
        water.eases = eases, water.volts = 12.6, water.drain = eases < 1e9 ? 0 : 4.8 / 8000;
        double deepest = 0;
        const Watched run = watch(mission, water, 1200, [&](const Cruiser& fish, const PilotStep<double>&, int tick) {
            if (10000 < tick) deepest = std::fmax(deepest, -fish.z);
        });
        CHECK(0 < run.swept_at && run.swept_at < 90 && deepest < 0.3);
        if (eases < 1e9)
            CHECK(run.end.last.mode == Mode::ended && run.from_home() < 8);
        else
            CHECK(run.end.last.mode == Mode::hold && run.end.last.reasons.has(Reason::swept));
    }
    // A current that the fish can just swim against ends nothing.
    water = {};
    water.current[1] = 0.25;
    const Watched slow = watch(mission, water, 1500);
    CHECK(!slow.was(Reason::swept) && slow.end.last.mode == Mode::done);
}

/// From rest at a slow gait the nose dips to 0.75 m before it rises: the depth responds, though not within 25 s of the
/// first dip. For a body that goes on sinking it does not.
static void a_dip_is_no_failure() {
    const Waypoint<double> point[] = {{0, 40, 2, 0.2, 2, 0}};
    const Mission<double> mission = mission_of(point, 1);
    const Pilot<double> pilot = test_pilot<double>();
    for (const bool sinks : {false, true}) {
        GuidanceState<double> state = init(pilot.guidance, mission);
        Estimate<double> at{};
        at.depths = at.attitude = at.compass = true, at.position_error = 3, at.factor = 1, at.facing.x = 1;
        for (int k = 0; k < 400; ++k) {
            const double time = 0.1 * k;
            at.depth = sinks || time < 12 ? 0.0625 * time : std::fmax(0.05, 0.75 - 0.03 * (time - 12));
            state = guide(pilot.guidance, state, at, {15.5, false, false}, mission).state;
        }
        CHECK(state.reasons.has(Reason::no_answer) == sinks);
    }
}

/// With a fin stuck down the fish rises by 1.1 cm/s, too slow to count as a response: it goes on, and is not stranded.
static void slowly_up_is_up() {
    const Waypoint<double> point[] = {{0, 40, 1.2, 0.2, 2, 0}};
    const Mission<double> mission = mission_of(point, 1);
    const Pilot<double> pilot = test_pilot<double>();
    for (const double climb : {0.0, 0.011}) {
        GuidanceState<double> state = init(pilot.guidance, mission);
        Estimate<double> at{};
        at.depths = at.attitude = at.compass = true, at.position_error = 3, at.factor = 1, at.facing.x = 1;
        for (int k = 0; k < 700; ++k) {
            at.depth = 1.2 - climb * 0.1 * k;
            state = guide(pilot.guidance, state, at, {15.5, false, false}, mission).state;
        }
        CHECK(state.reasons.has(Reason::no_answer) && state.reasons.has(Reason::stranded) == (climb == 0));
    }
}

/// At 0.2 m/s the fins do not lift a fish that waits for a fix 0.16 m deep: once the depth does not answer, it beats as
/// at its fastest, where the same fins lift more. A fish that its fins drive down beats on as before.
static void too_deep_is_swum_faster() {
    const Waypoint<double> point[] = {{0, 40, 1.2, 0.2, 2, 0}};
    const Mission<double> mission = mission_of(point, 1);
    const Pilot<double> pilot = test_pilot<double>();
    const GaitTable<double>& table = pilot.guidance.steering.table;
    for (const double sink : {0.0, 0.05}) {
        Guided<double> now{init(pilot.guidance, mission), {}};
        Estimate<double> at{};
        at.depths = at.attitude = at.compass = true, at.position_error = 3, at.factor = 1, at.facing.x = 1;
        at.depth = 0.16, at.sink = sink;
        for (int k = 0; k < 300; ++k) {
            const bool unanswered = now.state.reasons.has(Reason::no_answer);
            now = guide(pilot.guidance, now.state, at, {15.5, false, false}, mission);
            const bool fast = now.command.frequency == table.frequency[table.gaits - 1];
            CHECK(fast == (unanswered && sink == 0));
        }
        CHECK(now.state.reasons.has(Reason::no_answer));
    }
}

/// Held under water by a line or a net on a level leg, the fish beats until its position is too uncertain. Then the
/// depth does not respond: in calm water and in swell, the pilot reports this and stops the beat.
static void held_under_water() {
    const Waypoint<double> point[] = {{0, 400, 2, 0.3, 2, 0}};
    for (const double swell : {0.0, 0.1, 0.2, 0.3, 0.5}) {
        Water water;
        water.held = 100, water.swell = swell;
        double up = 0, reported = 0, stopped = 0;
        const Watched run =
            watch(mission_of(point, 1), water, 900, [&](const Cruiser& fish, const PilotStep<double>& step, int) {
                const auto first = [&](double& time, bool now) { time = time == 0 && now ? fish.time : time; };
                first(up, water.held < fish.time && step.mode == Mode::surface);
                first(reported, step.reasons.has(Reason::no_answer));
                first(stopped, step.reasons.has(Reason::stranded) && step.mode == Mode::hold);
            });
        CHECK(run.end.fish.z < -1 && water.held < up && up < 600);
        CHECK(24 < reported - up && reported - up < 40);
        CHECK(reported < stopped && stopped - up < 130);
    }
}

/// Without IMU the fish waits at the surface; it reports that a current carries it, and that it left its fence.
static void held_and_carried() {
    const Waypoint<double> point[] = {{0, 20, 1, 0.3, 2, 0}};
    const Corner<double> corner[4] = {{-30, -10}, {30, -10}, {30, 40}, {-30, 40}};
    Mission<double> mission = mission_of(point, 1);
    mission.corner = corner, mission.corners = 4;
    for (const double current : {0.0, 0.15}) {
        Water water;
        water.current[0] = current;
        double worst = 0;
        std::uint32_t reported = 0;
        const auto end = voyage<double>(
            mission, water, 500, 7,
            [&](const Cruiser& fish, const PilotStep<double>& step, int) {
                reported |= step.reasons.flags;
                const double beyond = -inside(mission, fish.x, fish.y).distance;
                worst = std::fmax(worst, beyond - 3 * step.estimate.position_error);
            },
            [](PilotReadings<double>& r, int tick) { r.robot.rate[1] = tick < 9000 ? r.robot.rate[1] : std::nan(""); });
        const auto was = [&](Reason reason) { return (reported >> int(reason) & 1) != 0; };
        CHECK(was(Reason::imu_lost) && end.last.mode == Mode::hold);
        CHECK(was(Reason::swept) == (0 < current) && was(Reason::outside) == (0 < current));
        CHECK((0 < worst) == (0 < current));
    }
}

/// Legs begin again from a place: skipped waypoints stay skipped, missed ones stay missed.
static void legs_begin_anywhere() {
    const Waypoint<double> point[4] = {};
    const Mission<double> mission = mission_of(point, 4);
    GuidanceState<double> state = init(test_pilot<double>().guidance, mission);
    begin_leg(state, mission, 2, {5, 6});
    CHECK(state.leg == 2 && state.reached == 0 && state.passed == 0 && state.from.x == 5 && state.from.y == 6);
    CHECK(state.reasons.has(Reason::skipped));
    state = init(test_pilot<double>().guidance, mission);
    state.leg = 4, state.reached = 3, state.passed = 1, state.mode = Mode::done;
    begin_leg(state, mission, 1, {0, 0});
    CHECK(state.leg == 1 && state.reached == 0 && state.passed == 1 && !has_ended(state.mode));
    begin_leg(state, mission, 9, {0, 0});
    CHECK(state.leg == 4 && state.reached == 0 && state.passed == 1);
    begin_leg(state, mission, -3, {0, 0});
    CHECK(state.leg == 0 && state.reached == 0 && state.passed == 0);
    state.leg = state.reached = 3;
    begin_leg(state, mission, 3, {1, 1});
    CHECK(state.leg == 3 && state.reached == 3 && !state.reasons.has(Reason::all_reached));
}

int main() {
    reached_at_its_depth();
    unknown_is_not_reached();
    home_is_found_when_a_fix_comes();
    holds_at_a_waypoint();
    called_back_is_not_done();
    fixes_are_enough();
    swept_and_back();
    a_dip_is_no_failure();
    slowly_up_is_up();
    too_deep_is_swum_faster();
    held_under_water();
    held_and_carried();
    legs_begin_anywhere();
    return failures();
}
