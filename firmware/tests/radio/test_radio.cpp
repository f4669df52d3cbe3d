/// The radio: commands, parameters, contact with the ground, and the data rate.
#include <array>

#include "radio_test.hpp"

static void test_arm_gait_disarm() {
    Bench bench;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(last_answer(bench) == Refusal::none);
    CHECK(snapshot(bench.vehicle()).armed());
    mavlink_command_long_t gait = command(HYPERTUNA_CMD_GAIT, 2, 10);
    gait.param3 = 15, gait.param4 = 40;
    bench.say(gait);
    CHECK(last_answer(bench) == Refusal::none);
    CHECK_NEAR(snapshot(bench.vehicle()).command.frequency, 2, 1e-6);
    CHECK_NEAR(snapshot(bench.vehicle()).command.amplitude[1], 15 * pi / 180, 1e-6);
    gait.param1 = 1000;
    bench.say(gait);
    CHECK(last_answer(bench) == Refusal::out_of_range);
    CHECK(texts_sent(bench, Refusal::out_of_range) == 1);
    CHECK_NEAR(snapshot(bench.vehicle()).command.frequency, 2, 1e-6);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    CHECK(!snapshot(bench.vehicle()).armed());
    for (float value : {0.5f, 2.0f, -1.0f, std::bit_cast<float>(0x7fc00000u)}) {
        bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, value));
        CHECK(last_answer(bench) == Refusal::out_of_range);
    }
    bench.say(command(MAV_CMD_NAV_TAKEOFF));
    CHECK(last_answer(bench) == Refusal::unknown);
}

static void test_parameters() {
    Bench bench;
    mavlink_param_set_t set{};
    set.target_system = 1, set.param_type = MAV_PARAM_TYPE_REAL32, set.param_value = 0.25f;
    put_text(set.param_id, "learning");
    bench.say(set);
    const int k = parameter_named(bench.vehicle(), "learning");
    CHECK(value(bench.vehicle(), k) == 0.25f);
    for (float wrong : {7.0f, std::bit_cast<float>(0x7fc00000u)}) {
        set.param_value = wrong;
        bench.board.said.clear();
        bench.say(set, 200);
        CHECK(value(bench.vehicle(), k) == 0.25f);
        const auto values = said<mavlink_param_value_t>(bench.board.said);
        CHECK(values.size() == 1 && values[0].param_value == 0.25f);
        CHECK(said<mavlink_param_error_t>(bench.board.said).size() == 1);
        CHECK(texts_sent(bench, Refusal::out_of_range) == 1);
    }
    bench.board.said.clear();
    mavlink_param_request_list_t list{};
    list.target_system = 1;
    bench.say(list, 3000);
    const auto values = said<mavlink_param_value_t>(bench.board.said);
    CHECK(int(values.size()) == parameter_count(bench.vehicle()));
    for (std::size_t i = 0; i < values.size(); ++i) CHECK(values[i].param_index == i);
}

/// COMMAND_INT is handled like COMMAND_LONG; a bias for which it has no field is refused, not left out.
static void test_command_int() {
    Bench bench;
    mavlink_command_int_t m{};
    m.target_system = 1, m.command = MAV_CMD_COMPONENT_ARM_DISARM, m.param1 = 1, m.x = 500000000;
    bench.say(m);
    CHECK(last_answer(bench) == Refusal::none && snapshot(bench.vehicle()).armed());
    m.command = HYPERTUNA_CMD_GAIT, m.param1 = 2, m.param2 = 10, m.param3 = 15, m.param4 = 40;
    bench.say(m);
    CHECK(last_answer(bench) == Refusal::out_of_range);
    m.x = 0;
    bench.say(m);
    CHECK(last_answer(bench) == Refusal::none);
    CHECK_NEAR(snapshot(bench.vehicle()).command.amplitude[1], 15 * pi / 180, 1e-6);
    m.command = MAV_CMD_COMPONENT_ARM_DISARM, m.param1 = 0;
    while (has_room(bench.app.radio.out)) reply(bench.app.radio.out, mavlink_command_ack_t{});
    bench.say(m, 1);  // disarming is carried out without a place for its answer
    CHECK(!snapshot(bench.vehicle()).armed());
    m.target_system = 2, m.param1 = 1;
    bench.say(m);
    CHECK(!snapshot(bench.vehicle()).armed());
}

/// An axis of INT16_MAX is one that the joystick does not have.
static void test_unused_axes() {
    Bench bench;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.say(command(MAV_CMD_DO_SET_MODE, 1, float(mode_base + int(State::manual))));
    mavlink_manual_control_t stick{};
    stick.target = 1, stick.z = 750;
    stick.x = stick.y = stick.r = INT16_MAX;
    bench.say(stick, 2);
    CHECK(snapshot(bench.vehicle()).command.frequency == 0);  // not centered yet
    stick.z = 500;
    bench.say(stick, 2);
    stick.z = 750;
    bench.say(stick, 2);
    CHECK(snapshot(bench.vehicle()).command.frequency > 0.5f && snapshot(bench.vehicle()).command.fin[0] == 0);
    stick.r = INT16_MIN;
    const std::uint32_t before = bench.app.radio.refused;
    bench.say(stick, 2);
    CHECK(bench.app.radio.refused == before + 1);
}

/// A centered joystick, as QGroundControl sends it by default, moves nothing, even where it trembles.
static void test_centered_stick() {
    Bench bench;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    mavlink_manual_control_t stick{};
    stick.target = 1, stick.z = 500;
    bench.say(stick, 2);  // in mode rest
    CHECK(snapshot(bench.vehicle()).state == State::rest && bench.app.radio.refused == 0);
    bench.say(command(MAV_CMD_DO_SET_MODE, 1, float(mode_base + int(State::manual))));
    for (int k = -20; k <= 20; ++k) {
        stick.x = std::int16_t(2 * k), stick.r = std::int16_t(-2 * k), stick.z = std::int16_t(500 + k);
        bench.say(stick, 2);
        const Command<float>& command = snapshot(bench.vehicle()).command;
        CHECK(command.frequency == 0 && command.fin[0] == 0 && command.bias[0] == 0);
    }
    stick.z = 1000;
    bench.ground.system = 254;  // another station's stick
    bench.say(stick, 2);
    CHECK(snapshot(bench.vehicle()).command.frequency == 0 && texts_sent(bench, Refusal::other_pilot) <= 1);
    bench.ground.system = 255;
    bench.say(stick, 2);
    CHECK(snapshot(bench.vehicle()).command.frequency > 0.5f);
}

/// A message to another robot is no sign of life of this robot's ground station; a message to all is.
static void test_who_is_heard() {
    Bench bench;
    for (int target : {2, 0}) {
        auto order = command(MAV_CMD_NAV_LAND);
        mavlink_manual_control_t stick{};
        mavlink_set_gps_global_origin_t place{};
        order.target_system = stick.target = place.target_system = std::uint8_t(target);
        bench.say(order, 1), bench.say(stick, 1), bench.say(place, 1);
        CHECK((1 < bench.vehicle().silence) == (target == 2));
    }
}

/// At 4.8 kbit/s the robot sends at most its share for any request, no answer waits behind telemetry, and no queue
/// grows.
static void test_radio_budget() {
    Bench bench;
    bench.board.said.clear();
    for (const TelemetryMessage& message : telemetry_messages)
        if (message.id != MAVLINK_MSG_ID_HEARTBEAT)
            bench.say(command(MAV_CMD_SET_MESSAGE_INTERVAL, float(message.id), 1e4f));  // 100 Hz each
    mavlink_param_request_list_t list{};
    list.target_system = 1;
    const Outbox& out = bench.app.radio.out;
    const auto cost = [&] { return double(out.sent) + packet_cost * double(out.frames); };
    const double before = cost();
    const int seconds = 60;
    for (int s = 0; s < seconds; ++s) {
        if (s % 10 == 0) bench.say(list, 1);
        for (int k = 0; k < 5; ++k) bench.say(command(MAV_CMD_NAV_LAND), 1);
        bench.run(100 - 5 - (s % 10 == 0));
    }
    const double rate = 8.0 * (cost() - before) / seconds;
    CHECK(rate <= 4800 * 0.75 * 1.01);
    CHECK(rate >= 4800 * 0.75 * 0.95);
    CHECK(bench.app.radio.out.max_waiting <= max_answers);
    CHECK(bench.app.radio.out.fill == 0);
    const auto hearts = said<mavlink_heartbeat_t>(bench.board.said);
    CHECK(int(hearts.size()) >= seconds - 2);
    for (int k = 1; k < streams; ++k) CHECK(bench.app.radio.telemetry.stream[k].sent > 0);
}

/// Counts and pressure for calibrations are sent when asked for: those that reading = scale (counts - zero) begins
/// with.
static void test_raw_readings() {
    Bench bench;
    CHECK(said<mavlink_raw_imu_t>(bench.board.said).empty() &&
          said<mavlink_scaled_pressure_t>(bench.board.said).empty());
    for (int id : {MAVLINK_MSG_ID_RAW_IMU, MAVLINK_MSG_ID_SCALED_PRESSURE})
        bench.say(command(MAV_CMD_SET_MESSAGE_INTERVAL, float(id), 2e5f));
    bench.run(1000);
    const auto imu = said<mavlink_raw_imu_t>(bench.board.said);
    const auto pressure = said<mavlink_scaled_pressure_t>(bench.board.said);
    CHECK(imu.size() > 10 && pressure.size() > 10);
    const Calibration& c = bench.vehicle().model.calibration;
    const auto reading = [&](const char* name, int k, float counts) {
        int first = 0;
        visit_channels(
            [&](const auto& channel, int at) { first = std::string_view(channel.name) == name ? at : first; });
        return c.scale[first + k] * (counts - c.zero[first + k]);
    };
    for (const auto& m : imu) {
        CHECK_NEAR(reading("acceleration", 0, m.xacc), 0, 0.1);
        CHECK_NEAR(reading("acceleration", 2, m.zacc), 9.81, 0.1);
        CHECK_NEAR(reading("rate", 2, m.zgyro), 0, 0.02);
        CHECK_NEAR(reading("field", 0, m.xmag), -0.6, 0.03);
        CHECK_NEAR(reading("field", 2, m.zmag), -0.8, 0.03);
    }
    for (const auto& m : pressure) CHECK_NEAR(reading("depth", 0, 10 * m.press_abs), 0.05, 0.03);
}

/// A radio whose buffer fills up gets less telemetry, and more again when it is empty; heartbeats and answers stay.
static void test_radio_status() {
    Bench bench;
    const Telemetry& telemetry = bench.app.radio.telemetry;
    const auto report = [&](int room, int times, int ticks, Sender from) {
        mavlink_radio_status_t status{};
        status.txbuf = std::uint8_t(room);
        std::swap(bench.ground, from);
        for (int k = 0; k < times; ++k) bench.say(status, ticks);
        std::swap(bench.ground, from);
    };
    const Sender radio{modem.system, modem.component, 0};
    report(0, 100, 10, {7, 7, 0}), report(0, 100, 10, {1, 68, 0}), report(0, 100, 10, {51, 1, 0});  // of no radio
    CHECK(telemetry.throttle == 100);
    report(10, 10, 100, radio);
    CHECK(telemetry.throttle == 10);
    bench.board.said.clear();
    const std::uint32_t before = bench.app.radio.out.sent;
    bench.run(900);
    CHECK(bench.app.radio.out.sent - before < 600);
    CHECK(bench.app.radio.out.sent - before > 200);
    CHECK(said<mavlink_heartbeat_t>(bench.board.said).size() >= 8);
    for (int k = 0; k < 20; ++k) bench.say(command(MAV_CMD_NAV_LAND), 30);
    CHECK(said<mavlink_command_ack_t>(bench.board.said).size() == 20);
    report(100, 80, 100, radio);
    CHECK(telemetry.throttle == 100);
    // A radio that stopped reporting may have been replaced.
    report(0, 10, 100, radio);
    CHECK(telemetry.throttle == 10);
    bench.run(1100);
    CHECK(telemetry.throttle == 100);
    // A robot that sends no telemetry cannot fill a buffer.
    for (const TelemetryMessage& message : telemetry_messages)
        if (message.id != MAVLINK_MSG_ID_HEARTBEAT)
            bench.say(command(MAV_CMD_SET_MESSAGE_INTERVAL, float(message.id), -1));
    bench.run(200);
    report(0, 1, 1, radio);  // what was sent before
    const int last = telemetry.throttle;
    report(0, 5, 100, radio);
    CHECK(telemetry.throttle == last && last >= 80);
}

/// One heartbeat per second under any load of requests: clients report a lost link after three seconds without one.
static void test_heartbeats_in_a_download() {
    Bench bench;
    CHECK(upload(bench, box()) == MAV_MISSION_ACCEPTED);
    bench.run(200);
    bench.board.said.clear();
    mavlink_mission_request_int_t request{};
    request.target_system = 1;
    const int seconds = 20;
    for (int k = 0; k < 5 * seconds; ++k) {  // more answers than the radio carries
        request.seq = std::uint16_t(k % 10);
        for (int again = 0; again < 3; ++again) bench.say(request, 1);
        bench.run(17);
    }
    CHECK(int(said<mavlink_mission_item_int_t>(bench.board.said).size()) > seconds);
    CHECK(int(said<mavlink_heartbeat_t>(bench.board.said).size()) >= seconds - 1);
}

/// A robot that rests after a failsafe and hears nobody sends a beacon: each message twice a minute, with the last
/// place that the receiver gave and its time, and heartbeats. When it is heard again, telemetry goes on.
static void test_beacon() {
    Bench bench;
    bench.run(500);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    const auto count = [&](int seconds) {
        bench.board.said.clear();
        bench.run(100 * seconds);
        const Bytes& all = bench.board.said;
        return std::array<std::size_t, 4>{said<mavlink_heartbeat_t>(all).size(), said<mavlink_attitude_t>(all).size(),
                                          said<mavlink_global_position_int_t>(all).size(),
                                          said<mavlink_gps_raw_int_t>(all).size()};
    };
    bench.run(600);  // the robot hears nobody, but no failsafe has acted
    CHECK(snapshot(bench.vehicle()).faults.has(firmware::Fault::link_lost) && 20 < count(60)[2]);
    bench.board.leak = true, bench.board.sky = false;
    const std::uint32_t last = bench.vehicle().fix.tick;
    bench.run(6000);
    CHECK(snapshot(bench.vehicle()).state == State::rest && snapshot(bench.vehicle()).answer == Answer::surface);
    const auto [heartbeats, attitudes, places, fixes] = count(300);
    CHECK(298 <= heartbeats && heartbeats <= 301);
    for (const std::size_t beacons : {attitudes, places, fixes}) CHECK(9 <= beacons && beacons <= 11);
    const auto raw = last_said<mavlink_gps_raw_int_t>(bench);
    CHECK(raw.fix_type == GPS_FIX_TYPE_NO_FIX && raw.time_usec == 10000ull * last);
    CHECK(std::abs(raw.lat - 500000000) < 100 && std::abs(raw.lon - 80000000) < 100);
    CHECK(0 < last_said<mavlink_pilot_t>(bench).position_error);
    mavlink_heartbeat_t alive{};
    alive.type = MAV_TYPE_GCS, alive.autopilot = MAV_AUTOPILOT_INVALID;
    bench.say(alive, 10);
    CHECK(8 < count(4)[1]);
}

/// So does a robot that has disarmed itself because its battery is empty, at any interval of a message; one that was
/// only never armed does not.
static void test_beacon_of_an_empty_battery() {
    for (float voltage : {11.0f, 15.0f}) {
        Bench bench;
        bench.run(500);
        const float seconds = voltage < 12 ? 20 : 1;
        bench.say(command(MAV_CMD_SET_MESSAGE_INTERVAL, float(MAVLINK_MSG_ID_ATTITUDE), 1e6f * seconds));
        if (voltage < 12) bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
        bench.board.voltage = voltage;
        bench.run(6000);
        CHECK(snapshot(bench.vehicle()).state == State::disarmed);
        bench.board.said.clear();
        bench.run(30'000);  // 5 minutes: ten beacons, or about a message a second
        const std::size_t attitudes = said<mavlink_attitude_t>(bench.board.said).size();
        CHECK(voltage < 12 ? 9 <= attitudes && attitudes <= 11 : 100 < attitudes);
    }
}

/// After a restart the place in the stored mission's origin is unknown until the next fix, so none is sent. Here the
/// robot was 400 m north of the origin, and a radio that sent the origin would be as wrong.
static void test_place_after_a_restart() {
    Bench bench;
    bench.run(500);
    CHECK(upload(bench, box()) == MAV_MISSION_ACCEPTED);
    bench.run(500);
    bench.board.place += 36'000, bench.board.sky = false;
    boot(bench.app, robot::description, bench.board);
    bench.board.said.clear(), bench.run(600);
    CHECK(said<mavlink_global_position_int_t>(bench.board.said).empty());
    CHECK(last_said<mavlink_pilot_t>(bench).position_error == UINT16_MAX);
    bench.say(command(MAV_CMD_REQUEST_MESSAGE, float(MAVLINK_MSG_ID_GLOBAL_POSITION_INT)));
    CHECK(last_answer(bench) == Refusal::not_placed);
    bench.board.sky = true, bench.run(600);
    CHECK(std::abs(last_said<mavlink_global_position_int_t>(bench).lat - 500'036'000) < 200);
    CHECK(last_said<mavlink_pilot_t>(bench).position_error < 500);
}

/// Fixes of another place: from the second on the receiver is not healthy, until half a minute has passed or the true
/// ones are back. The robot stays where it is, unless they stay.
static void test_false_place() {
    for (const int seconds : {20, 40}) {
        Bench bench;
        bench.run(1000);
        const auto healthy = [&] {
            bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_SYS_STATUS));
            const auto status = last_said<mavlink_sys_status_t>(bench);
            return (status.onboard_control_sensors_health & MAV_SYS_STATUS_SENSOR_GPS) != 0;
        };
        CHECK(healthy());
        bench.board.place += 100'000;  // 1.1 km
        bench.run(210);
        CHECK(!healthy() && std::abs(snapshot(bench.vehicle()).estimate.y) < 3);
        bench.run(100 * (seconds - 3));
        bench.board.place -= seconds < 30 ? 100'000 : 0, bench.run(110);
        CHECK(healthy() && (1000 < snapshot(bench.vehicle()).estimate.y) == (30 < seconds));
    }
}

int main() {
    test_beacon();
    test_beacon_of_an_empty_battery();
    test_place_after_a_restart();
    test_false_place();
    test_heartbeats_in_a_download();
    test_arm_gait_disarm();
    test_parameters();
    test_command_int();
    test_unused_axes();
    test_centered_stick();
    test_who_is_heard();
    test_radio_budget();
    test_radio_status();
    test_raw_readings();
    return failures();
}
