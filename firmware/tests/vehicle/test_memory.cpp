/// Non-volatile memory: parameters and missions survive a restart, if they are valid.
#include "vehicle_test.hpp"

static void parameters_are_stored() {
    begin();
    CHECK(v.defaults);
    const int soft = index_of("pressure_soft"), hard = index_of("pressure_hard"), system = index_of("system_id");
    CHECK(soft >= 0 && hard >= 0 && system >= 0);
    CHECK(set_parameter(v, ground, soft, 560e3f) ==
          Refusal::out_of_range);  // the limit is never set higher than described
    CHECK(set_parameter(v, ground, soft, std::bit_cast<float>(0x7fc00000u)) == Refusal::out_of_range);
    CHECK(set_parameter(v, ground, system, 2.5f) == Refusal::out_of_range);
    CHECK(set_parameter(v, ground, -1, 1) == Refusal::unknown &&
          set_parameter(v, ground, parameter_count(v), 1) == Refusal::unknown);
    CHECK(set_parameter(v, ground, hard, 500e3f) == Refusal::inconsistent && value(v, hard) == 660e3f);
    CHECK(v.model.pilot.controller.pressure_hard == 660e3f);
    CHECK(set_parameter(v, ground, soft, 500e3f) == Refusal::none && v.model.pilot.controller.pressure_soft == 500e3f);
    CHECK(give(v, Order::arm, ground) == Refusal::busy);  // until it is stored
    float_on(v, board, 200);
    CHECK(give(v, Order::arm, ground) == Refusal::none && set_parameter(v, ground, soft, 510e3f) == Refusal::armed);
    boot(v, robot::description, board);
    CHECK(!v.defaults && value(v, soft) == 500e3f && v.model.pilot.controller.pressure_soft == 500e3f);
    const std::uint8_t secret[key_size] = {1, 2, 3};
    CHECK(key(v) == nullptr && set_key(v, ground, secret) == Refusal::none);
    float_on(v, board, 200);
    boot(v, robot::description, board);
    CHECK(key(v) != nullptr && std::memcmp(key(v), secret, key_size) == 0);
    CHECK(value(v, soft) == 500e3f);
}

/// Setting a parameter changes its own field only; all others keep their values.
static void one_field_is_configured() {
    begin();
    static Model filled;
    for (int k = 0; k < parameter_count(v); ++k) {
        const ParameterInfo& info = parameter(v, k);
        const float to = info.low + (info.whole ? 0.0f : 0.4f) * (info.high - info.low);
        set_parameter(v, ground, k, to);
    }
    std::memcpy(&filled, &v.model, sizeof filled);
    configure(filled, robot::description, v.value);
    CHECK(std::memcmp(&filled, &v.model, sizeof filled) == 0);
}

/// Stored parameters count only if every value is within its present range: the description may have become stricter.
static void stored_parameters_out_of_range() {
    const float nan = std::bit_cast<float>(0x7fc00000u);
    for (float stored : {nan, 1e9f, 549e3f}) {
        begin();
        const int soft = index_of("pressure_soft");
        std::memcpy(v.stored + 4 * soft, &stored, 4);
        begin_write(v.store), float_on(v, board, 200);
        boot(v, robot::description, board);
        const bool good = stored == 549e3f;
        CHECK(value(v, soft) == (good ? stored : 550e3f) && v.defaults != good);
        CHECK(v.model.pilot.controller.pressure_soft == value(v, soft));
    }
    begin();  // each is in its range, but they contradict each other
    const float soft = 550e3f, hard = 500e3f;
    std::memcpy(v.stored + 4 * index_of("pressure_soft"), &soft, 4);
    std::memcpy(v.stored + 4 * index_of("pressure_hard"), &hard, 4);
    begin_write(v.store), float_on(v, board, 200);
    boot(v, robot::description, board);
    CHECK(v.defaults && v.model.pilot.controller.pressure_hard == 660e3f);
}

/// A mission from before the restart may belong to other water, and a tank has no fixes that show this: it is not a way
/// home until the ground begins it or sends it again.
static void a_stored_mission_is_no_way_home() {
    for (bool begun : {false, true}) {
        begin();
        set_mission(v, ground, numbered(1)), float_on(v, board, 300);
        boot(v, robot::description, board);
        float_on(v, board, 100);
        CHECK(give(v, Order::arm, ground) == Refusal::none);
        if (begun)
            CHECK(give(v, Order::mission, ground) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
        float_on(v, board, 6200);
        CHECK(snapshot(v).answer == Answer::home && beats() == begun);
        CHECK((snapshot(v).state == State::home) == begun);
        board.depth = 3, float_on(v, board, 300);  // but the robot does come up
        CHECK(beats() && same(mission(v), numbered(1)));
    }
}

/// A mission survives a restart as a whole, and so does the absence of a mission.
static void missions_are_stored() {
    begin();
    float_on(v, board, 100);
    CHECK(set_mission(v, ground, numbered(1)) == Refusal::none);
    float_on(v, board, 10);
    CHECK(give(v, Order::arm, ground) == Refusal::busy);  // until it is stored
    float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(v.has_mission && same(mission(v), numbered(1)));
    float_on(v, board, 100);
    CHECK(give(v, Order::arm, ground) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
    CHECK(give(v, Order::gait, ground) == Refusal::none && set_mission(v, ground, numbered(0)) == Refusal::none);
    static MemoryBoard before;
    before = board;
    float_on(v, board, 300);  // not written while armed
    CHECK(!settled(v.missions) && board.flash.operations == before.flash.operations);
    CHECK(std::memcmp(before.flash.bytes, board.flash.bytes, sizeof(board.flash.bytes)) == 0);
    give(v, Order::disarm, ground), float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(same(mission(v), numbered(0)));
    CHECK(clear_mission(v, ground) == Refusal::none);
    float_on(v, board, 300);
    boot(v, robot::description, board);
    CHECK(!v.has_mission && mission(v).waypoints == 0);
}

/// Stored data must be valid by today's checks.
static void stored_missions_out_of_range() {
    const auto stored = [](auto spoil) {
        begin();
        CHECK(set_mission(v, ground, numbered(1)) == Refusal::none);
        spoil(v.plan), float_on(v, board, 300);
        boot(v, robot::description, board);
        return v.has_mission;
    };
    CHECK(stored([](StoredMission&) {}));
    CHECK(!stored([](StoredMission& m) { m.waypoint[2].speed = std::bit_cast<float>(0x7fc00000u); }));
    CHECK(!stored([](StoredMission& m) { m.waypoints = max_waypoints + 1; }));
    CHECK(!stored([](StoredMission& m) { m.corners = -1; }));
    CHECK(!stored([](StoredMission& m) { m.has_origin = 1, m.latitude = INT32_MIN; }));
    CHECK(!stored([](StoredMission& m) { m.form.items = max_items + 1; }) && v.plan.form.items == 0);
    CHECK(!stored([](StoredMission& m) { m.form.item[0].kind = ItemKind(200); }) && v.plan.form.items == 0);
    CHECK(!stored([](StoredMission& m) { m.form.item[0].kind = ItemKind::waypoint; }) && v.plan.form.items == 0);
}

/// Boot as from power on.
static void reboot() {
    board.flash.boot();
    boot(v, robot::description, board);
}

/// Cut the power at every operation of writing a mission: the robot boots with the old mission or the new one.
static void power_cuts_of_a_mission() {
    begin();
    set_mission(v, ground, numbered(0)), float_on(v, board, 300);
    static MemoryBoard first;
    first = board;
    int old_ones = 0, new_ones = 0;
    for (int cut = 0; cut < 480; ++cut) {
        board = first, board.flash.dice.state = std::uint64_t(cut) + 1;
        reboot();
        CHECK(set_mission(v, ground, numbered(1)) == Refusal::none);
        board.flash.power = cut % (5 + (int(sizeof(StoredMission)) + piece - 1) /
                                           piece);  // sometimes after the last operation, without effect
        for (int k = 0; k < 300; ++k) write_stores(v, board);
        reboot();
        const bool is_old = v.has_mission && same(mission(v), numbered(0));
        const bool is_new = v.has_mission && same(mission(v), numbered(1));
        CHECK(is_old != is_new);
        old_ones += is_old, new_ones += is_new;
    }
    CHECK(old_ones > 200 && new_ones > 0);
    std::printf("power cuts of a mission: %d, old %d, new %d\n", old_ones + new_ones, old_ones, new_ones);
}

static const std::uint8_t secret[key_size] = {1, 2, 3};

/// A board that has a key and requires signatures.
static void begin_signed() {
    begin();
    CHECK(set_key(v, ground, secret) == Refusal::none &&
          set_parameter(v, ground, index_of("sign"), 1) == Refusal::none);
    float_on(v, board, 100);
}

/// A fault of its memory never makes a robot with a key accept unsigned commands: without valid parameters it still
/// requires signatures, and without a valid key it is locked until the key is deleted with the board in hand.
static void a_key_cannot_fall_open() {
    begin_signed();
    for (int sector : {parameter_sector + 0, parameter_sector + 1}) board.flash.erase(sector);
    reboot();
    CHECK(v.defaults && !v.locked && key(v) != nullptr && limits(v).sign == 1.0f);
    CHECK(value(v, index_of("sign")) == 1.0f);
    for (int spoil = 0; spoil < 2; ++spoil) {
        begin_signed();
        const int at = address(v.keys, v.keys.kept, v.keys.slot) + piece + 9;  // a bit of the only copy
        if (spoil == 0) board.flash.bytes[at] = std::uint8_t(board.flash.bytes[at] ^ 4);
        for (int sector : {key_sector + 0, key_sector + 1})
            if (spoil == 1) board.flash.erase(sector);
        reboot();
        float_on(v, board, 100);
        CHECK(v.locked && key(v) == nullptr && snapshot(v).faults.has(Fault::key_lost));
        CHECK(give(v, Order::arm, ground) == Refusal::faulty);
        board.jumper = true, reboot(), float_on(v, board, 100);
        CHECK(!v.locked && key(v) == nullptr && !snapshot(v).faults.has(Fault::key_lost));
        board.jumper = false, reboot();
        CHECK(!v.locked);
        CHECK(set_key(v, ground, secret) == Refusal::none);
        float_on(v, board, 100), reboot();
        CHECK(!v.locked && key(v) != nullptr);
    }
}

/// Cut the power at every operation of writing a first key, a change, a deletion and a recovery: the robot boots with
/// the old key or the new one, and is locked at most by an interrupted recovery, which can be repeated.
static void power_cuts_of_a_key() {
    const std::uint8_t other[key_size] = {9, 8}, none[key_size] = {};
    int states[4] = {};  // none, the first key, the other, locked
    for (int which = 0; which < 4; ++which)
        for (int cut = 0; cut < 600; ++cut) {
            begin();
            board.flash.dice.state = std::uint64_t(cut) + 1;
            if (which != 0) set_key(v, ground, secret), float_on(v, board, 30);
            if (which != 3) set_key(v, ground, which == 0 ? secret : which == 1 ? other : none);
            board.jumper = which == 3, board.flash.power = cut % 20;
            if (which == 3) boot(v, robot::description, board);
            for (int k = 0; k < 40; ++k) write_stores(v, board);
            board.jumper = false, reboot();
            const auto is = [&](const std::uint8_t (&k)[key_size]) {
                return key(v) && std::memcmp(key(v), k, key_size) == 0;
            };
            const int state = v.locked ? 3 : key(v) == nullptr ? 0 : is(secret) ? 1 : is(other) ? 2 : 4;
            CHECK(which == 0   ? state == 0 || state == 1
                  : which == 1 ? state == 1 || state == 2
                  : which == 2 ? state == 0 || state == 1
                               : state == 0 || state == 1 || state == 3);
            ++states[state & 3];
            for (int k = 0; k < 3; ++k) write_stores(v, board);
            CHECK(key(v) == nullptr || count_witnesses(board, witness_sector) == witnesses);
        }
    std::printf("power cuts of a key: none %d, first %d, other %d, locked %d\n", states[0], states[1], states[2],
                states[3]);
    CHECK(states[0] > 100 && states[1] > 100 && states[2] > 100 && states[3] > 10);
}

/// Places of a stored mission count from the origin that it was stored with, wherever the robot boots.
static void a_stored_mission_has_its_origin() {
    begin();
    float_on(v, board, 50);
    CHECK(set_mission(v, ground, numbered(1)) == Refusal::none);  // before there is a fix
    fix(500000000, 80000000);
    float_on(v, board, 300);
    CHECK(set_origin(v, ground, 500000000, 80000001) == Refusal::elsewhere);
    CHECK(set_origin(v, ground, 500000000, 80000000) == Refusal::none);

    boot(v, robot::description, board);  // 111.2 m to the north
    CHECK(v.has_mission && origin(v).known && origin(v).latitude == 500000000);
    float_on(v, board, 50);
    fix(500010000, 80000000);
    float_on(v, board, 2);
    CHECK(origin(v).latitude == 500000000);
    CHECK_NEAR(snapshot(v).estimate.y, 111.2, 0.2);

    boot(v, robot::description, board);  // a hundred kilometers away: another lake
    float_on(v, board, 100);
    CHECK(give(v, Order::arm, ground) == Refusal::none && give(v, Order::mission, ground) == Refusal::none);
    float_on(v, board, 100);
    fix(510000000, 80000000);
    CHECK(!v.has_mission && origin(v).latitude == 510000000 && snapshot(v).state == State::rest);
    float_on(v, board, 100);
    CHECK(!beats() && snapshot(v).armed());
    CHECK(give(v, Order::mission, ground) != Refusal::none);
    boot(v, robot::description, board);  // and back again
    CHECK(v.has_mission);
}

/// An unchanged value is not written again, and memory that does not hold a value is reported.
static void the_memory_wears() {
    begin();
    const int soft = index_of("pressure_soft");
    CHECK(set_parameter(v, ground, soft, 500e3f) == Refusal::none && !settled(v.store));
    float_on(v, board, 200);
    CHECK(set_parameter(v, ground, soft, 500e3f) == Refusal::none && settled(v.store));
    board.flash.worn = address(v.store, v.store.sector, v.store.slot + 1);  // the next record's first byte
    CHECK(set_parameter(v, ground, soft, 501e3f) == Refusal::none);
    float_on(v, board, 200);
    CHECK(snapshot(v).faults.has(Fault::memory));
    board.flash.worn = -1;
    CHECK(set_parameter(v, ground, soft, 501e3f) == Refusal::none && !settled(v.store));  // once more
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
    a_key_cannot_fall_open();
    power_cuts_of_a_key();
    a_stored_mission_has_its_origin();
    the_memory_wears();
    CHECK(allocations == 0);
    return failures();
}
