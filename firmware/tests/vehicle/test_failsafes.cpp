/// Failsafes: what the robot does by itself in the water.
#include <algorithm>

#include "vehicle_test.hpp"

/// Float without a depth sensor.
static void blind(int ticks) {
    for (int k = 0; k < ticks; ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        board.raw.channel[hypertuna::first_channel("depth")] = {};
        tick(v, board);
    }
}

static void contact(int ticks) {
    for (int k = 0; k < ticks; ++k) on_ground_contact(v, ground), float_on(v, board, 1);
}

/// Reset as the watchdog does, or as a loss of power.
static void reset(bool power) {
    board.reset = power;
    if (!power) board.word = 0xa5a5a5a5;
    boot(v, robot::description, board);
}

/// A watchdog's restart at 3 m, and a loss of power there: the robot comes up by itself, and rests at the surface.
static void restart_under_water() {
    for (bool power : {true, false}) {
        begin_armed();
        CHECK(give(v, Order::gait, ground) == Refusal::none);
        board.depth = 3, contact(300);
        reset(power);
        CHECK(v.now.state == State::disarmed);
        float_on(v, board, 250);
        CHECK(v.now.state == State::surface && beats() && v.now.command.fin[0] > 0.1f);
        CHECK(v.now.faults.has(Fault::watchdog) == power);
        board.depth = 0.05f, float_on(v, board, 200);
        CHECK(v.now.state == State::rest && !beats());
        CHECK(give(v, Order::rest, ground) == Refusal::none && v.pilot == ground);
    }
    // At the surface it stays disarmed, and so does one that was disarmed and is thrown into the water later.
    for (bool armed : {true, false}) {
        if (armed)
            begin_armed();
        else
            begin(), float_on(v, board, 100);
        reset(true), float_on(v, board, 1100);
        board.depth = armed ? 0.05f : 3.0f, float_on(v, board, 500);
        CHECK(v.now.state == State::disarmed);
    }
    // Half a meter deep no air pressure tells it from the surface, but the kept word does.
    for (bool power : {true, false}) {
        begin_armed();
        board.depth = 0.5f, contact(300);
        reset(power), float_on(v, board, 250);
        CHECK(v.now.state == (power ? State::surface : State::disarmed));
    }
    // Nor does it after a loss of power, but the surface that was stored before arming does. With the ground in contact
    // the robot waits for orders: it may have been carried down from a mountain lake.
    for (bool heard : {false, true}) {
        begin(), contact(200);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        board.depth = 0.6f, contact(300);
        reset(false);
        const auto go = [&](int ticks) { heard ? contact(ticks) : float_on(v, board, ticks); };
        go(300);
        CHECK(v.now.state == State::disarmed && !v.now.estimate.zeroed);
        go(400);
        CHECK(v.now.state == (heard ? State::disarmed : State::surface));
        if (heard) {
            CHECK(give(v, Order::arm, ground) == Refusal::none && v.now.state == State::rest);
            contact(10);
            CHECK(v.now.estimate.zeroed && abs(v.now.estimate.depth) < 0.1f);
        } else {
            CHECK(beats() && v.now.command.fin[0] > 0.1f);
            board.depth = 0.05f, float_on(v, board, 200);
            CHECK(v.now.state == State::rest && !beats());
        }
    }
    // Less air than before is no water, nor is weather.
    for (float rise : {-1.5f, 0.3f}) {
        begin(), contact(200);
        board.depth += rise, reset(false), float_on(v, board, 1000);
        CHECK(v.now.state == State::disarmed && v.now.estimate.zeroed);
        const float before = v.surface;
        contact(100);
        CHECK(abs(v.surface - before - rise) < 0.02f);
    }
    // Without a depth sensor a robot that was armed ascends for as long as that takes at most.
    begin_armed(), board.depth = 3, contact(300);
    reset(true), blind(250);
    CHECK(v.now.state == State::surface && beats());
}

/// An empty battery: up first, then disarmed.
static void an_empty_battery() {
    begin_armed();
    board.depth = 3, contact(300);
    drain(11, 1500);
    CHECK(v.now.faults.has(Fault::empty_battery) && v.now.state == State::surface && beats());
    CHECK(give(v, Order::gait, ground) == Refusal::faulty && give(v, Order::home, ground) == Refusal::faulty);
    board.depth = 0.05f, drain(11, 200);
    CHECK(v.now.state == State::disarmed && give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(std::strcmp(sentence(v, Refusal::faulty), fault_texts[int(Fault::empty_battery)].sentence) == 0 ||
          std::strcmp(sentence(v, Refusal::faulty), fault_texts[int(Fault::low_battery)].sentence) == 0);
}

/// A dead depth sensor forbids arming, and says so.
static void a_dead_depth_sensor() {
    begin();
    blind(200);
    CHECK(v.now.faults.has(Fault::depth_sensor) && give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(std::strcmp(sentence(v, Refusal::faulty), "the depth sensor failed") == 0);
    float_on(v, board, 400);
    CHECK(!v.now.faults.has(Fault::depth_sensor) && give(v, Order::arm, ground) == Refusal::none);
}

/// Below the depth limit fins only lift, and after a second the robot comes up.
static void the_depth_limit() {
    for (Order order : {Order::manual, Order::gait}) {
        begin();
        CHECK(set_parameter(v, ground, index_of("depth_max"), 4) == Refusal::none);
        float_on(v, board, 300);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        Command<float> dive = beat();
        dive.fin[0] = dive.fin[1] = -0.4f;
        const auto repeat = [&] {
            if (order == Order::gait) return;
            sticks(v, ground, 0, 0, 0), sticks(v, ground, 0.5f, 0, -1);
        };
        if (order == Order::gait)
            CHECK(set_gait(v, ground, dive) == Refusal::none);
        else
            CHECK(give(v, order, ground) == Refusal::none);
        const auto go = [&](int ticks) {
            for (int k = 0; k < ticks; ++k) repeat(), contact(1);
        };
        board.depth = 3, go(300);
        CHECK(v.now.command.fin[0] < -0.3f && beats());
        board.depth = 3.8f, go(150);
        CHECK(v.now.command.fin[0] == 0 && beats() && v.now.answer == Answer::warn);
        board.depth = 4.4f, go(400);
        CHECK(v.now.faults.has(Fault::too_deep) && v.now.state == State::surface && v.now.command.fin[0] > 0.1f);
        CHECK(give(v, Order::gait, ground) == Refusal::faulty);
        board.depth = 0.05f, contact(300);
        CHECK(v.now.state == State::rest && !v.now.faults.has(Fault::too_deep));
        CHECK(give(v, Order::gait, ground) == Refusal::none);
    }
    begin();
    Mission<float> m = plan();
    m.depth_max = 11;
    CHECK(set_mission(v, ground, m) == Refusal::too_deep);  // than the hull's 10 m
}

/// The surface: zeroed at boot, on arming near the surface and on command; kept over a reset; implausible depths do not
/// arm.
static void the_surface() {
    begin();
    board.depth = -0.25f;  // an air pressure of 989 hPa
    float_on(v, board, 300);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.02);
    board.depth = -0.10f, float_on(v, board, 300);  // it rises by 15 hPa
    CHECK_NEAR(v.now.estimate.depth, 0.15, 0.03);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 5);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.03);
    CHECK(take_surface(v, ground) == Refusal::armed);
    board.depth = 2.9f, contact(800);
    CHECK_NEAR(v.now.estimate.depth, 3, 0.03);
    reset(true), float_on(v, board, 50);
    CHECK_NEAR(v.now.estimate.depth, 3, 0.03);
    float_on(v, board, 200);
    CHECK(v.now.state == State::surface);
    // In a tank at 1 m the zero stays.
    begin(), float_on(v, board, 300);
    board.depth = 1.05f, float_on(v, board, 2100);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    float_on(v, board, 100);
    CHECK_NEAR(v.now.estimate.depth, 1, 0.03);
    // A sensor that shows no air pressure: neither armed nor zeroed there.
    begin(), board.depth = -8, float_on(v, board, 300);
    CHECK(!v.now.estimate.zeroed && give(v, Order::arm, ground) != Refusal::none);
    CHECK(take_surface(v, ground) == Refusal::no_depth);
    // On command it is zeroed by what the weather changes, not under water, whether its surface was seen or not.
    begin(), float_on(v, board, 300);
    board.depth = 0.35f, float_on(v, board, 300);
    CHECK(take_surface(v, ground) == Refusal::none);
    float_on(v, board, 100);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.03);
    for (float depth : {0.6f, 0.8f, 3.0f}) {
        begin(), float_on(v, board, 300);
        board.depth = depth + 0.05f, float_on(v, board, 800);
        CHECK(v.now.estimate.zeroed && take_surface(v, ground) == Refusal::submerged);
        CHECK_NEAR(v.now.estimate.depth, depth, 0.03);
    }
    begin(), board.depth = 0.9f, float_on(v, board, 90);
    CHECK(!v.now.estimate.zeroed && take_surface(v, ground) == Refusal::submerged);
    // One that was carried down from a mountain, where it was zeroed, is zeroed after a restart.
    begin(), board.depth = -1.5f, contact(300);
    board.depth = 0, float_on(v, board, 800);
    CHECK(take_surface(v, ground) == Refusal::submerged);
    boot(v, robot::description, board);
    float_on(v, board, 300);
    CHECK(take_surface(v, ground) == Refusal::none);
    float_on(v, board, 10);
    CHECK_NEAR(v.now.estimate.depth, 0, 0.03);
}

/// Silence of the ground in a mission counts where it could be heard, or where the mission wants it.
static void silence_under_water() {
    const auto dive = [](int ticks) {  // the fins move it up and down
        for (int k = 0; k < ticks; ++k) {
            board.depth = std::max(0.05f, board.depth - 0.01f * v.now.command.fin[0]);
            float_on(v, board, 1);
        }
    };
    for (bool below : {false, true}) {
        begin_armed();
        Mission<float> m = plan();
        Waypoint<float> deep[1] = {{0, -400, 2, 0.3f, 2, 0}};
        m.waypoint = deep, m.waypoints = 1, m.silence_below = below;
        CHECK(set_mission(v, ground, m) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
        for (int k = 0; k < 9000; ++k) on_ground_contact(v, ground), dive(1);
        CHECK(board.depth > 1.5f && v.now.state == State::mission);
        dive(7000);
        CHECK(v.now.faults.has(Fault::link_gone) == below && v.now.reasons.has(Reason::recalled) == below);
        CHECK(v.now.state == (below ? State::home : State::mission));
        if (below) continue;
        CHECK(!v.now.faults.has(Fault::link_lost));
        board.depth = 0.05f, float_on(v, board, 3000);  // half a minute up is not long enough
        board.depth = 2, float_on(v, board, 3000);
        CHECK(!v.now.faults.has(Fault::link_gone));
        board.depth = 0.05f, float_on(v, board, 3300);
        CHECK(v.now.faults.has(Fault::link_gone) && v.now.state == State::home);
    }
    // What the ground steers does not swim on without it, under water neither.
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.depth = 2, float_on(v, board, 600);
    CHECK(!beats() && v.now.state == State::rest);
}

/// A recalled mission is not done: not at home, and not later.
static void recalled_is_not_done() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
    float_on(v, board, 100);
    CHECK(give(v, Order::home, ground) == Refusal::none);
    for (int k = 0; k < 2000; ++k) {
        float_on(v, board, 1);
        CHECK(v.now.mode != Mode::done);
    }
    CHECK(v.now.reasons.has(Reason::recalled));
}

/// The first fix tells where the origin is. It moves neither the robot nor its mission.
static void the_first_fix() {
    begin_armed();
    CHECK(set_mission(v, ground, plan()) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
    contact(6000);
    const float x = v.now.estimate.x, y = v.now.estimate.y;
    CHECK(std::hypot(x, y) > 10);
    on_ground_contact(v, ground), fix(500000000, 80000000), contact(1);
    CHECK_NEAR(v.now.estimate.x, x, 0.1);
    CHECK_NEAR(v.now.estimate.y, y, 0.1);
    const auto at = local(origin(v), 500000000, 80000000);
    CHECK_NEAR(at.x, x, 0.1);
    CHECK_NEAR(at.y, y, 0.1);
    CHECK(v.mission.waypoint[0].y == -40);
    // In an origin that was given, the fix places the robot, and the place of arming with it.
    begin_armed();
    give(v, Order::disarm, ground);
    CHECK(set_origin(v, ground, 500000000, 80000000) == Refusal::none);
    float_on(v, board, 10);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    fix(500010000, 80000000), float_on(v, board, 1);
    CHECK_NEAR(v.now.estimate.y, 111.2, 0.3);
    CHECK_NEAR(v.home.y, 111.2, 0.3);
}

/// A bus that hangs delays ticks: the fault tells, and beat and clock keep their time.
static void late_ticks() {
    const auto swims = [](std::uint32_t counts, int ticks) {
        begin_armed();
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        contact(300);
        board.took = 0;
        const std::uint32_t before = v.now.tick;
        int beats = 0;
        float last = 0;
        for (int k = 0; k < ticks; ++k) {
            board.took += counts;
            contact(1);
            const float set = v.now.output.set[0];
            beats += last < 0 && 0 <= set, last = set;
        }
        CHECK(v.now.faults.has(Fault::overrun) == (counts > 1500));
        CHECK_NEAR(float(v.now.tick - before), float(counts) * float(ticks) / 1000.0f, 2);
        return beats;
    };
    const int beats = swims(1000, 2000);
    CHECK(38 <= beats && beats <= 41);                // 20 s at 2 Hz
    CHECK(std::abs(swims(1724, 1160) - beats) <= 1);  // 20 s at 58 Hz
    // A second is lost where the clock went on for a second: no more than five steps are made up for.
    begin_armed();
    contact(10);
    const std::uint32_t before = v.now.tick;
    board.took += 100'000;
    contact(1);
    CHECK(v.now.tick == before + 5);
    contact(1);
    CHECK(v.now.tick == before + 6);
}

/// An erasure, while disarmed, delays the next tick and is no fault; what is late besides is one. The clock keeps its
/// time.
static void erasures_are_not_late() {
    const auto stores = [](std::uint32_t erasing, std::uint32_t besides) {
        begin(), float_on(v, board, 100);
        board.took = v.started, board.erasing = erasing;
        const std::uint32_t before = v.now.tick;
        CHECK(set_parameter(v, ground, index_of("learning"), 0.5f) == Refusal::none);
        bool late = false;
        for (int k = 0; k < 100; ++k) {
            board.took += k == 1 ? besides : 1000;
            float_on(v, board, 1), late = late || v.now.faults.has(Fault::overrun);
        }
        CHECK(board.flash.erasures == 1 && settled(v.store));
        CHECK_NEAR(float(v.now.tick - before), 100 + std::min(float(erasing) / 1000, 4.0f), 2);
        return late;
    };
    for (std::uint32_t erasing : {4'500u, 40'000u}) CHECK(!stores(erasing, 1000) && stores(erasing, 2000));
}

/// Choose the response to a fault.
static void choose(const char* parameter, Answer answer) {
    begin();
    set_parameter(v, ground, index_of(parameter), float(answer));
    float_on(v, board, 300);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
}

/// A leak brings the robot up where it is, not home; a parameter may choose otherwise, within the choices.
static void a_leak() {
    const struct {
        Answer answer;
        State state;
    } choices[] = {{Answer::warn, State::gait},
                   {Answer::home, State::home},
                   {Answer::stop, State::rest},
                   {Answer::surface, State::surface}};
    for (const auto& [answer, state] : choices) {
        choose("leak_answer", answer);
        fix(500000000, 80000000);
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        board.depth = 3, contact(300);
        board.raw.leak = true, contact(130);
        CHECK(v.now.faults.has(Fault::leak) && v.now.answer == answer && v.now.state == state);
        CHECK((set_gait(v, ground, beat()) == Refusal::none) == (answer == Answer::warn));
        CHECK((give(v, Order::home, ground) == Refusal::none) == (answer <= Answer::home));
        CHECK(give(v, Order::surface, ground) == Refusal::none && v.now.state == State::surface);
    }
    begin();
    CHECK(v.value[index_of("leak_answer")] == float(Answer::surface));  // of the description, as in the table
    for (float wrong : {4.0f, 1.5f, -1.0f})
        CHECK(set_parameter(v, ground, index_of("leak_answer"), wrong) == Refusal::out_of_range);
}

/// Without IMU or battery voltage nothing guards what the ground steers: neither armed nor steered.
static void unguarded() {
    const auto fail = [](int channel, int ticks) {
        for (int k = 0; k < ticks; ++k) {
            on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
            board.raw.channel[channel] = {};
            tick(v, board);
        }
    };
    for (const char* sensor : {"rate", "acceleration", "voltage"})
        for (Order order : {Order::manual, Order::gait, Order::mission}) {
            const int channel = std::strcmp(sensor, "rate") == 0           ? hypertuna::first_channel("rate")
                                : std::strcmp(sensor, "acceleration") == 0 ? hypertuna::first_channel("acceleration")
                                                                           : hypertuna::first_channel("voltage");
            begin_armed(), fix(500000000, 80000000);
            CHECK(set_mission(v, ground, plan()) == Refusal::none && give(v, order, ground) == Refusal::none);
            fail(channel, 50);
            CHECK(!v.now.faults.has(Fault::unguarded));
            fail(channel, 150);
            const bool steered = order != Order::mission;  // a mission has the pilot's own rules
            CHECK(v.now.faults.has(Fault::unguarded) == steered);
            if (!steered) continue;
            CHECK(v.now.state == State::home && v.now.answer == Answer::home);
            float_on(v, board, 600);  // latched, where the sensor recovers
            CHECK(v.now.faults.has(Fault::unguarded) && set_gait(v, ground, beat()) == Refusal::faulty);
            give(v, Order::disarm, ground), contact(200);
            CHECK(give(v, Order::arm, ground) == Refusal::none && !v.now.faults.has(Fault::unguarded));
            give(v, Order::disarm, ground), fail(channel, 150);
            CHECK(give(v, Order::arm, ground) == Refusal::faulty);
        }
}

/// A robot that sinks at rest comes up each time, and is not armed while it sinks; waves and hands are no sinking.
static void it_sinks_at_rest() {
    const auto sink = [](float rate, int ticks) {
        for (int k = 0; k < ticks; ++k) board.depth += 0.01f * rate, contact(1);
    };
    for (float rate : {0.005f, 0.1f}) {
        begin_armed(), contact(100);
        sink(rate, int(35 / rate));
        CHECK(!v.now.faults.has(Fault::sinks) && v.now.state == State::rest);
        sink(rate, int(10 / rate) + 100);
        CHECK(v.now.state == State::surface && beats() && !v.now.faults.has(Fault::sinks));
        board.depth = 0.05f, contact(1500);
        CHECK(v.now.state == State::rest);
        sink(rate, int(45 / rate) + 100);
        CHECK(v.now.state == State::surface);
    }
    begin(), contact(300);
    sink(0.06f, 1500);
    CHECK(v.now.faults.has(Fault::sinks) && give(v, Order::arm, ground) == Refusal::faulty);
    CHECK(std::strcmp(sentence(v, Refusal::faulty), fault_texts[int(Fault::sinks)].sentence) == 0);
    contact(2100);
    CHECK(!v.now.faults.has(Fault::sinks) && give(v, Order::arm, ground) == Refusal::none);
    for (int k = 0; k < 6000; ++k) board.depth = 0.15f + 0.15f * std::sin(0.03f * float(k)), contact(1);
    CHECK(v.now.state == State::rest);
    board.depth = 0.05f, contact(200);
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.depth = 3, contact(300);
    CHECK(v.now.state == State::gait);  // a dive is no sinking
}

/// Beat under way with fixes of a robot that makes this part of its way, its course turning at a rate [rad/s], for
/// some seconds; whether it is told that it makes none.
static bool swims(float part, float drift, int seconds) {
    float north = 0, east = 0;
    for (int k = 0; k < 100 * seconds && !v.now.faults.has(Fault::no_progress); ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        const auto& at = v.now.estimate;
        const float step = 0.01f * part * at.speed / at.factor;
        north += step * at.facing.y + 0.01f * drift, east += step * at.facing.x;
        if (k % 100 == 0) {
            board.raw.fixed = true, board.raw.accuracy = 1500;
            board.raw.fix[0] = 500000000 + std::int32_t(north / 0.0111f);
            board.raw.fix[1] = 80000000 + std::int32_t(east / (0.0111f * 0.643f));
        }
        tick(v, board), board.raw.fixed = false;
    }
    return v.now.faults.has(Fault::no_progress);
}

/// A robot that is entangled or aground does not beat until its battery is empty.
static void no_progress() {
    for (Answer answer : {Answer::warn, Answer::stop, Answer::surface}) {
        choose("snag_answer", answer);
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        CHECK(swims(0, 0, 200));
        CHECK(v.now.tick < 20'000);
        contact(10);
        CHECK(v.now.state == (answer == Answer::warn ? State::gait : State::rest));
        CHECK(beats() == (answer == Answer::warn));
    }
    for (float part : {0.3f, 1.0f}) {
        choose("snag_answer", Answer::surface);
        CHECK(set_gait(v, ground, beat()) == Refusal::none && !swims(part, 0, 300));
    }
    choose("snag_answer", Answer::surface);  // a current alone is no way made, nor lost
    CHECK(!swims(0, 0.2f, 300) && v.now.state == State::rest);
    begin();
    CHECK(set_parameter(v, ground, index_of("snag_distance"), 0) == Refusal::none);
    float_on(v, board, 300), give(v, Order::arm, ground);
    CHECK(set_gait(v, ground, beat()) == Refusal::none && !swims(0, 0, 300));
}

/// A joint that does not follow is released, and told within some beats, by response also brought up; what its pressure
/// or a sensor limits is not. Arming gives it another chance.
static void no_stroke() {
    for (Answer answer : {Answer::warn, Answer::surface})
        for (int joint : {0, 1}) {
            choose("stroke_answer", answer);
            CHECK(set_gait(v, ground, beat()) == Refusal::none);
            contact(600);
            CHECK(!v.now.faults.has(Fault::no_stroke));
            board.limp[joint] = true, contact(250);
            CHECK(v.now.faults.has(Fault::no_stroke) && !v.now.faults.has(Fault::over_pressure));
            CHECK(v.state.controller.circuit[2 * joint].stopped && !v.state.controller.circuit[2 - 2 * joint].stopped);
            CHECK(v.now.state == (answer == Answer::warn ? State::gait : State::rest));
            contact(300), give(v, Order::disarm, ground), contact(300);
            board.limp[joint] = false;
            CHECK(give(v, Order::arm, ground) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
            contact(600);
            CHECK(!v.now.faults.has(Fault::no_stroke) && !v.state.controller.circuit[2 * joint].stopped);
        }
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.limp[0] = true;
    for (int k = 0; k < 600; ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        board.raw.channel[hypertuna::first_channel("pressure")] = {};
        tick(v, board);
    }
    CHECK(v.now.faults.has(Fault::pressure_sensor) && !v.now.faults.has(Fault::no_stroke));
}

int main() {
    restart_under_water();
    an_empty_battery();
    a_dead_depth_sensor();
    the_depth_limit();
    a_leak();
    unguarded();
    it_sinks_at_rest();
    no_progress();
    no_stroke();
    the_surface();
    silence_under_water();
    recalled_is_not_done();
    the_first_fix();
    late_ticks();
    erasures_are_not_late();
    CHECK(allocations == 0);
    return failures();
}
