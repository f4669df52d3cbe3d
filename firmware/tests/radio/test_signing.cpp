/// Signing: unsigned, wrongly signed and recorded frames are rejected.
#include "radio_test.hpp"

static void test_signing() {
    Bench bench;
    std::uint8_t key[key_length];
    for (int k = 0; k < key_length; ++k) key[k] = std::uint8_t(k + 1);
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.initial_timestamp = 1'000'000'000;
    std::memcpy(setup.secret_key, key, key_length);
    bench.say(setup);
    CHECK(bench.app.radio.signing.on);

    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));  // without a signature
    CHECK(!snapshot(bench.vehicle()).armed() && bench.app.radio.not_signed == 1);
    begin_signing(bench.key, key, 2'000'000'000);
    bench.key.key[5] ^= 1;  // a key that is not the robot's
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(!snapshot(bench.vehicle()).armed());
    bench.key.key[5] ^= 1;

    bench.say(mavlink_ping_t{});  // a later time is stored before the robot arms
    const Bytes arm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.hear(arm), bench.run(40);
    CHECK(snapshot(bench.vehicle()).armed());
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    bench.run(2000);  // a recording is rejected, however late
    bench.hear(arm), bench.run(40);
    CHECK(!snapshot(bench.vehicle()).armed());

    // Signing survives a boot, and the robot's own frames are signed, too.
    boot(bench.app, robot::description, bench.board);
    bench.board.said.clear();
    bench.run(200);
    CHECK(bench.app.radio.signing.on && bench.board.said[2] == signed_flag);
    bench.key.on = false;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(!snapshot(bench.vehicle()).armed());
}

/// After a restart no recording is accepted, not even the last one; the owner is accepted, whose stamps follow those
/// that the robot sends.
static void test_a_recording_after_a_restart() {
    Bench bench;
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.secret_key[3] = 5, setup.initial_timestamp = 1'000'000'000;
    bench.say(setup);
    begin_signing(bench.key, setup.secret_key, setup.initial_timestamp);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(snapshot(bench.vehicle()).armed());
    bench.key.stamp += 100 * stamp_minute;  // a clock that is far ahead
    const Bytes recorded = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.hear(recorded), bench.run(40);
    const std::uint64_t kept = bench.vehicle().stamp;
    CHECK(kept > bench.key.stamp && kept <= bench.key.stamp + stamp_reserve + 100'000);
    int writes = 0;
    for (int k = 0; k < 6500; ++k) {
        const std::uint32_t turn = bench.vehicle().stamps.turn;
        bench.run(1);
        writes += bench.vehicle().stamps.turn != turn;
    }
    CHECK(writes == 0);  // no writes while armed: the stamp that was stored before is far enough ahead

    for (int restart = 0; restart < 2; ++restart) {
        boot(bench.app, robot::description, bench.board);
        bench.run(60);
        bench.hear(recorded), bench.run(40);
        CHECK(!snapshot(bench.vehicle()).armed() && bench.app.radio.not_signed == 1);
        bench.key.stamp = bench.app.radio.signing.stamp;  // the stamp in the robot's own frames
        bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
        CHECK(snapshot(bench.vehicle()).armed());
    }
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    setup.secret_key[3] = 6, setup.initial_timestamp = 1000;  // with another key another time may begin
    bench.say(setup);
    CHECK(bench.vehicle().stamp < 2 * stamp_reserve);
}

/// The parameter that requires signatures needs a key, and takes effect at once.
static void test_signing_by_parameter() {
    Bench bench;
    mavlink_param_set_t sign{};
    sign.target_system = 1, sign.param_type = MAV_PARAM_TYPE_REAL32, sign.param_value = 1;
    put_text(sign.param_id, "SIGN");
    bench.say(sign);
    CHECK(!bench.app.radio.signing.on && texts_sent(bench, Refusal::inconsistent) == 1);
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.secret_key[3] = 5, setup.initial_timestamp = std::uint64_t(1) << 48;
    bench.say(setup);
    CHECK(!bench.app.radio.signing.on && texts_sent(bench, Refusal::out_of_range) == 1);  // a stamp has 48 bits
    setup.initial_timestamp = 1000;
    bench.say(setup);
    CHECK(bench.app.radio.signing.on);
    begin_signing(bench.key, setup.secret_key, 2000);
    sign.param_value = 0;
    bench.say(sign);
    CHECK(!bench.app.radio.signing.on);
    bench.key.on = false, sign.param_value = 1;
    bench.run(100), bench.say(sign);
    CHECK(bench.app.radio.signing.on);
    bench.key.on = true;
    setup.secret_key[3] = 0;  // a key of zeros deletes the key and ends signing
    bench.say(setup), bench.run(100);
    CHECK(!bench.app.radio.signing.on && key(bench.vehicle()) == nullptr);
    bench.key.on = false;
    bench.say(sign);
    CHECK(!bench.app.radio.signing.on);
}

/// Start signing with a key that the ground has, too.
static void begin_signing(Bench& bench) {
    mavlink_setup_signing_t setup{};
    setup.target_system = 1, setup.secret_key[3] = 5, setup.initial_timestamp = 1'000'000'000;
    bench.say(setup);
    begin_signing(bench.key, setup.secret_key, setup.initial_timestamp);
    CHECK(bench.app.radio.signing.on);
}

/// A modem's status is used without a signature. Its ids do not count as those of a station.
static void test_status_of_a_modem() {
    Bench bench;
    begin_signing(bench);
    int heard = 0;
    for (int k = 0; k < 50; ++k) {
        const Sender ground = bench.ground;
        bench.key.on = false, bench.ground.sequence = std::uint8_t(bench.ground.sequence + 20);
        mavlink_radio_status_t status{};
        status.txbuf = 100;
        bench.say(status, 1);
        bench.key.on = true, bench.ground = ground;
        bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, float(k % 2 == 0)));
        heard += snapshot(bench.vehicle()).armed() == (k % 2 == 0);
    }
    CHECK(heard == 50 && bench.app.radio.not_signed == 0);
    bench.key.on = false;
    mavlink_radio_status_t full{};
    full.txbuf = 10;
    bench.say(full, 1);
    CHECK(bench.app.radio.telemetry.throttle == 100);  // a status with a station's ids is not a modem's
    bench.ground = {modem.system, modem.component, 0};
    bench.say(full, 1);
    CHECK(bench.app.radio.telemetry.throttle == 80);
}

/// A ninth station is heard like the others; the station that was silent for longest then counts as new.
static void test_ninth_stream() {
    Bench bench;
    begin_signing(bench);
    std::vector<Bytes> recorded;
    for (int k = 0; k < 20; ++k) {
        bench.ground.component = std::uint8_t(100 + k);
        recorded.push_back(bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, float(k % 2 == 0))));
        bench.hear(recorded.back()), bench.run(30);
        CHECK(snapshot(bench.vehicle()).armed() == (k % 2 == 0));
    }
    bench.run(2000);
    for (const Bytes& frame : recorded) {  // a forgotten stream does not let its recordings in
        bench.hear(frame), bench.run(30);
        CHECK(!snapshot(bench.vehicle()).armed());
    }
}

/// A station without the key learns why nothing happens, by its first heartbeat; from then on rarely, however much
/// comes without a signature.
static void test_unsigned_stations_learn_why() {
    Bench bench;
    begin_signing(bench);
    bench.key.on = false;
    mavlink_heartbeat_t beat{};
    beat.type = MAV_TYPE_GCS;
    bench.say(beat);
    CHECK(texts_sent(bench, Refusal::not_signed) == 1);
    for (int k = 0; k < 1900; ++k) bench.say(beat, 1);
    CHECK(texts_sent(bench, Refusal::not_signed) == 2);
}

/// A command with a later time than the stored one does not arm: after a loss of power its recording would arm, too.
static void test_arming_waits_for_the_stamp() {
    Bench bench;
    begin_signing(bench);
    bench.key.stamp += 2 * stamp_reserve;
    const Bytes arm = bench.frame(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.hear(arm), bench.run(40);
    CHECK(!snapshot(bench.vehicle()).armed() && texts_sent(bench, Refusal::busy) == 1);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(snapshot(bench.vehicle()).armed());
    boot(bench.app, robot::description, bench.board);
    bench.run(60), bench.hear(arm), bench.run(40);
    CHECK(!snapshot(bench.vehicle()).armed() && bench.app.radio.not_signed == 1);
}

/// A robot whose key is lost accepts no command, signed or not.
static void test_a_lost_key() {
    Bench bench;
    begin_signing(bench);
    bench.run(100);
    for (int sector : {key_sector + 0, key_sector + 1}) bench.board.erase(sector);
    boot(bench.app, robot::description, bench.board);
    bench.run(100);
    CHECK(bench.vehicle().locked);
    for (bool with_key : {false, true}) {
        bench.key.on = with_key;
        std::memset(bench.key.key, with_key ? 0 : 5, key_length);
        mavlink_setup_signing_t setup{};
        setup.target_system = 1, setup.secret_key[3] = 9;
        bench.say(setup), bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
        CHECK(!snapshot(bench.vehicle()).armed() && key(bench.vehicle()) == nullptr);
    }
    CHECK(bench.app.radio.not_signed == 4);
}

int main() {
    test_unsigned_stations_learn_why();
    test_arming_waits_for_the_stamp();
    test_a_lost_key();
    test_status_of_a_modem();
    test_ninth_stream();
    test_signing();
    test_a_recording_after_a_restart();
    test_signing_by_parameter();
    return failures();
}
