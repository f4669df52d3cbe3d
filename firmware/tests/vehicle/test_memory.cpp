/// Non-volatile memory: parameters and missions survive a restart, if they are valid.
#include "vehicle_test.hpp"

static void parameters_are_stored() {
    begin();
    CHECK(v.defaults);
    const int soft = index_of("pressure_soft"), hard = index_of("pressure_hard"), system = index_of("system_id");
    CHECK(soft >= 0 && hard >= 0 && system >= 0);
    CHECK(set_parameter(v, soft, 260e3f) == Refusal::out_of_range);  // a limit is never loosened
    CHECK(set_parameter(v, soft, std::bit_cast<float>(0x7fc00000u)) == Refusal::out_of_range);
    CHECK(set_parameter(v, system, 2.5f) == Refusal::out_of_range);
    CHECK(set_parameter(v, -1, 1) == Refusal::unknown && set_parameter(v, parameter_count(v), 1) == Refusal::unknown);
    CHECK(set_parameter(v, hard, 200e3f) == Refusal::inconsistent && value(v, hard) == 300e3f);
    CHECK(v.model.pilot.controller.pressure_hard == 300e3f);
    CHECK(set_parameter(v, soft, 200e3f) == Refusal::none && v.model.pilot.controller.pressure_soft == 200e3f);
    CHECK(arm(v, true) == Refusal::busy);  // until it is stored
    float_on(v, board, 200);
    CHECK(arm(v, true) == Refusal::none && set_parameter(v, soft, 210e3f) == Refusal::armed);
    boot(v, robot::description, board);
    CHECK(!v.defaults && value(v, soft) == 200e3f && v.model.pilot.controller.pressure_soft == 200e3f);
    const std::uint8_t secret[key_size] = {1, 2, 3};
    CHECK(key(v) == nullptr && set_key(v, secret) == Refusal::none);
    float_on(v, board, 200);
    boot(v, robot::description, board);
    CHECK(key(v) != nullptr && std::memcmp(key(v), secret, key_size) == 0);
    CHECK(value(v, soft) == 200e3f);
}

/// A parameter that is set changes its own field alone, and all others are what they were.
static void one_field_is_configured() {
    begin();
    static Model filled;
    for (int k = 0; k < parameter_count(v); ++k) {
        const ParameterInfo& info = parameter(v, k);
        const float to = info.low + (info.whole ? 0.0f : 0.4f) * (info.high - info.low);
        set_parameter(v, k, to);
    }
    std::memcpy(&filled, &v.model, sizeof filled);
    configure(filled, robot::description, v.value);
    CHECK(std::memcmp(&filled, &v.model, sizeof filled) == 0);
}

/// What is stored counts only if every value is within its range now: a description may have become stricter.
static void stored_parameters_out_of_range() {
    const float nan = std::bit_cast<float>(0x7fc00000u);
    for (float stored : {nan, 1e9f, 249e3f}) {
        begin();
        const int soft = index_of("pressure_soft");
        std::memcpy(v.stored + 4 * soft, &stored, 4);
        begin_write(v.store), float_on(v, board, 200);
        boot(v, robot::description, board);
        const bool good = stored == 249e3f;
        CHECK(value(v, soft) == (good ? stored : 250e3f) && v.defaults != good);
        CHECK(v.model.pilot.controller.pressure_soft == value(v, soft));
    }
    begin();  // each in its range, but not together
    const float soft = 250e3f, hard = 200e3f;
    std::memcpy(v.stored + 4 * index_of("pressure_soft"), &soft, 4);
    std::memcpy(v.stored + 4 * index_of("pressure_hard"), &hard, 4);
    begin_write(v.store), float_on(v, board, 200);
    boot(v, robot::description, board);
    CHECK(v.defaults && v.model.pilot.controller.pressure_hard == 300e3f);
}

/// A mission from before the restart may be of another water, and a tank has no fixes that tell: it is no way home
/// until the ground begins it or sends it again.
static void a_stored_mission_is_no_way_home() {
    for (bool begun : {false, true}) {
        begin();
        set_mission(v, numbered(1)), float_on(v, board, 300);
        boot(v, robot::description, board);
        float_on(v, board, 100);
        CHECK(arm(v, true) == Refusal::none);
        if (begun) CHECK(set_control(v, Control::mission) == Refusal::none && set_gait(v, beat()) == Refusal::none);
        float_on(v, board, 6200);
        CHECK(snapshot(v).answer == Answer::home && beats() == begun);
        CHECK((snapshot(v).control == Control::mission) == begun);
        board.depth = 3, float_on(v, board, 300);  // but up it comes
        CHECK(beats() && same(mission(v), numbered(1)));
    }
}

/// A mission survives a restart, as a whole, and so does that there is none.
static void missions_are_stored() {
    begin();
    float_on(v, board, 100);
    CHECK(set_mission(v, numbered(1)) == Refusal::none);
    float_on(v, board, 10);
    CHECK(arm(v, true) == Refusal::busy);  // until it is stored
    float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(v.has_mission && same(mission(v), numbered(1)));
    float_on(v, board, 100);
    CHECK(arm(v, true) == Refusal::none && set_control(v, Control::mission) == Refusal::none);
    CHECK(set_control(v, Control::gait) == Refusal::none && set_mission(v, numbered(0)) == Refusal::none);
    static MemoryBoard before;
    before = board;
    float_on(v, board, 300);  // not written while armed
    CHECK(std::memcmp(before.memory, board.memory, sizeof(board.memory)) == 0 && !settled(v.missions));
    arm(v, false), float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(same(mission(v), numbered(0)));
    CHECK(clear_mission(v) == Refusal::none);
    float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(!v.has_mission && mission(v).waypoints == 0);
}

/// What is stored must be sound today.
static void stored_missions_out_of_range() {
    const auto stored = [](auto spoil) {
        begin();
        CHECK(set_mission(v, numbered(1)) == Refusal::none);
        spoil(v.plan), float_on(v, board, 300);
        boot(v, robot::description, board);
        return v.has_mission;
    };
    CHECK(stored([](StoredMission&) {}));
    CHECK(!stored([](StoredMission& m) { m.waypoint[2].speed = std::bit_cast<float>(0x7fc00000u); }));
    CHECK(!stored([](StoredMission& m) { m.waypoints = max_waypoints + 1; }));
    CHECK(!stored([](StoredMission& m) { m.corners = -1; }));
    CHECK(!stored([](StoredMission& m) { m.has_origin = 1, m.latitude = INT32_MIN; }));
}

/// Cut the power at every byte of a mission's write: it boots with the old one or the new one.
static void power_cuts_of_a_mission() {
    begin();
    set_mission(v, numbered(0)), float_on(v, board, 300);
    static MemoryBoard first;
    first = board;
    int old_ones = 0, new_ones = 0;
    for (int cut = 0; cut <= 4 + slot_head + int(sizeof(StoredMission)); ++cut) {
        board = first;
        boot(v, robot::description, board);
        CHECK(set_mission(v, numbered(1)) == Refusal::none);
        board.power = cut, board.torn = 0x5a;
        for (int k = 0; k < 300; ++k) write_stores(v, board);
        board.power = -1;
        boot(v, robot::description, board);
        const bool is_old = v.has_mission && same(mission(v), numbered(0));
        const bool is_new = v.has_mission && same(mission(v), numbered(1));
        CHECK(is_old != is_new);
        old_ones += is_old, new_ones += is_new;
    }
    CHECK(old_ones > 1500 && new_ones > 0);
    std::printf("power cuts of a mission: %d, old %d, new %d\n", old_ones + new_ones, old_ones, new_ones);
}

/// Places of a kept mission count from the origin that it had, wherever the robot boots.
static void a_stored_mission_has_its_origin() {
    const auto fix = [](std::int32_t latitude, std::int32_t longitude) {
        float_upright(board, v, int(snapshot(v).tick));
        board.raw.fixed = true, board.raw.fix[0] = latitude, board.raw.fix[1] = longitude;
        tick(v, board);
        board.raw.fixed = false;
    };
    begin();
    float_on(v, board, 50);
    CHECK(set_mission(v, numbered(1)) == Refusal::none);  // before there is a fix
    fix(500000000, 80000000);
    float_on(v, board, 300);
    CHECK(set_origin(v, 500000000, 80000001) == Refusal::elsewhere);
    CHECK(set_origin(v, 500000000, 80000000) == Refusal::none);

    boot(v, robot::description, board);  // 111.2 m to the north
    CHECK(v.has_mission && origin(v).known && origin(v).latitude == 500000000);
    float_on(v, board, 50);
    fix(500010000, 80000000);
    float_on(v, board, 2);
    CHECK(origin(v).latitude == 500000000);
    CHECK_NEAR(snapshot(v).estimate.y, 111.2, 0.2);

    boot(v, robot::description, board);  // a hundred kilometers away: another lake
    float_on(v, board, 100);
    CHECK(arm(v, true) == Refusal::none && set_control(v, Control::mission) == Refusal::none);
    float_on(v, board, 100);
    fix(510000000, 80000000);
    CHECK(!v.has_mission && origin(v).latitude == 510000000 && snapshot(v).control == Control::gait);
    float_on(v, board, 100);
    CHECK(!beats() && snapshot(v).armed);
    CHECK(set_control(v, Control::mission) != Refusal::none);
    boot(v, robot::description, board);  // and back again
    CHECK(v.has_mission);
}

/// An unchanged value is not written again, and memory that does not hold a value is reported.
static void the_memory_wears() {
    begin();
    const int soft = index_of("pressure_soft");
    CHECK(set_parameter(v, soft, 200e3f) == Refusal::none && !settled(v.store));
    float_on(v, board, 200);
    CHECK(set_parameter(v, soft, 200e3f) == Refusal::none && settled(v.store));
    board.worn = int(~v.store.turn & 1) * (slot_head + v.store.size);  // a byte of the next mark
    CHECK(set_parameter(v, soft, 201e3f) == Refusal::none);
    float_on(v, board, 200);
    CHECK(snapshot(v).faults.has(Fault::memory));
    board.worn = -1;
    CHECK(set_parameter(v, soft, 201e3f) == Refusal::none && !settled(v.store));  // once more
    float_on(v, board, 200);
    CHECK(!snapshot(v).faults.has(Fault::memory));
}

int main() {
    parameters_are_stored();
    a_stored_mission_is_no_way_home();
    one_field_is_configured();
    stored_parameters_out_of_range();
    missions_are_stored();
    stored_missions_out_of_range();
    power_cuts_of_a_mission();
    a_stored_mission_has_its_origin();
    the_memory_wears();
    CHECK(allocations == 0);
    return failures();
}
