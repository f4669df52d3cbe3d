/// Tests of the services for ground stations: modes, orders by command, messages on request, checks before arming,
/// calibration, restart, files.
#include "radio_test.hpp"

static State state(const Bench& bench) { return snapshot(bench.vehicle()).state; }

static float mode_of(State of) { return float(mode_base + int(of)); }

/// The modes are listed with their names, and selected by their numbers only: 2 is another autopilot's ALT_HOLD.
static void test_modes() {
    Bench bench;
    bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_AVAILABLE_MODES), 300);
    const auto list = said<mavlink_available_modes_t>(bench.board.said);
    CHECK(int(list.size()) == selectable_modes && selectable_modes == 7);
    for (std::size_t k = 0; k < list.size(); ++k) {
        const int of = int(list[k].custom_mode) - mode_base;
        CHECK(list[k].mode_index == k + 1 && list[k].number_modes == selectable_modes && 0 < of && of < states);
        CHECK(std::strcmp(list[k].mode_name, state_texts[of].name) == 0);
    }
    bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_AVAILABLE_MODES, 3), 300);
    CHECK(last_said<mavlink_available_modes_t>(bench).mode_index == 3);
    bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_AVAILABLE_MODES, 8));
    CHECK(last_answer(bench) == Refusal::out_of_range);

    CHECK(upload(bench, {item(MAV_CMD_NAV_WAYPOINT, 10, 0, 1)}) == MAV_MISSION_ACCEPTED);
    bench.run(300);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(state(bench) == State::rest);
    for (int other = 0; other < 100; ++other) {
        bench.say(command(MAV_CMD_DO_SET_MODE, 1, float(other)));
        CHECK(last_answer(bench) == Refusal::unknown && state(bench) == State::rest);
    }
    mavlink_command_long_t auto_mode = command(MAV_CMD_DO_SET_MODE, 1, 4);  // of MAVSDK
    for (int submode : {0, 1, 2, 4, 3, 5, 6}) {
        auto_mode.param3 = float(submode);
        bench.say(auto_mode);
        CHECK((last_answer(bench) == Refusal::none) == (submode > 2));
        if (submode < 3) CHECK(state(bench) == State::rest);
        if (submode == 4) CHECK(state(bench) == State::mission);
        if (submode == 3) CHECK(state(bench) == State::paused);
    }
    for (State of : {State::manual, State::gait, State::mission, State::paused, State::home, State::surface}) {
        bench.say(command(MAV_CMD_DO_SET_MODE, 1, mode_of(of)));
        CHECK(last_answer(bench) == Refusal::none && (state(bench) == of || state(bench) == State::rest));
    }
    mavlink_set_mode_t old{};
    old.target_system = 1, old.base_mode = 1, old.custom_mode = std::uint32_t(mode_of(State::manual));
    bench.say(old);
    CHECK(state(bench) == State::manual);
    bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_CURRENT_MODE), 100);
    CHECK(last_said<mavlink_current_mode_t>(bench).custom_mode == std::uint32_t(mode_of(State::manual)));
}

/// The commands of ground stations' buttons.
static void test_orders() {
    Bench bench;
    auto items = box();
    CHECK(upload(bench, items) == MAV_MISSION_ACCEPTED);
    bench.run(300);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    const auto order = [&](int what, float first, State then) {
        bench.say(command(what, first));
        const bool arrived = then == State::home && state(bench) == State::rest;  // home is near
        CHECK(last_answer(bench) == Refusal::none && (state(bench) == then || arrived));
    };
    order(MAV_CMD_MISSION_START, 0, State::mission);
    order(MAV_CMD_DO_PAUSE_CONTINUE, 0, State::paused);
    order(MAV_CMD_DO_SET_MISSION_CURRENT, float(items.size() - 1), State::paused);
    CHECK(bench.vehicle().leg == 2);
    bench.say(command(MAV_CMD_DO_SET_MISSION_CURRENT, float(items.size())));
    CHECK(last_answer(bench) == Refusal::out_of_range);
    mavlink_mission_set_current_t current{};
    current.target_system = 1, current.seq = std::uint16_t(items.size() - 2);
    bench.say(current, 100);
    CHECK(bench.vehicle().leg == 1);
    CHECK(last_said<mavlink_mission_current_t>(bench).seq == items.size() - 2);
    order(MAV_CMD_DO_PAUSE_CONTINUE, 1, State::mission);
    order(MAV_CMD_NAV_RETURN_TO_LAUNCH, 0, State::home);
    order(MAV_CMD_DO_SET_STANDARD_MODE, MAV_STANDARD_MODE_MISSION, State::mission);
    bench.say(command(MAV_CMD_NAV_LAND));
    CHECK(last_answer(bench) == Refusal::none && state(bench) != State::mission);
    order(MAV_CMD_COMPONENT_ARM_DISARM, 0, State::disarmed);
}

/// Position, home and satellites are sent once there is an origin; before, a request is refused with the reason.
static void test_positions() {
    Bench bench;
    bench.board.said.clear();
    bench.run(300);
    const Origin& at = origin(bench.vehicle());
    CHECK(at.known);
    for (int id : {MAVLINK_MSG_ID_GLOBAL_POSITION_INT, MAVLINK_MSG_ID_HOME_POSITION, MAVLINK_MSG_ID_GPS_RAW_INT,
                   MAVLINK_MSG_ID_EXTENDED_SYS_STATE, MAVLINK_MSG_ID_VFR_HUD, MAVLINK_MSG_ID_SYS_STATUS,
                   MAVLINK_MSG_ID_PROTOCOL_VERSION, MAVLINK_MSG_ID_AUTOPILOT_VERSION}) {
        bench.say(command(MAV_CMD_REQUEST_MESSAGE, float(id)), 100);
        CHECK(last_answer(bench) == Refusal::none);
    }
    const auto position = last_said<mavlink_global_position_int_t>(bench);
    CHECK(std::abs(position.lat - at.latitude) < 100 && std::abs(position.lon - at.longitude) < 100);
    CHECK(position.alt == position.relative_alt && std::abs(position.alt) < 500 && position.hdg < 36000);
    const auto fix = last_said<mavlink_gps_raw_int_t>(bench);
    CHECK(fix.fix_type == GPS_FIX_TYPE_3D_FIX && std::abs(fix.lat - 500000000) < 100);
    CHECK(std::abs(last_said<mavlink_home_position_t>(bench).latitude - position.lat) < 100);
    CHECK(last_said<mavlink_extended_sys_state_t>(bench).landed_state == MAV_LANDED_STATE_ON_GROUND);
    const auto status = last_said<mavlink_sys_status_t>(bench);
    CHECK(status.onboard_control_sensors_health & MAV_SYS_STATUS_PREARM_CHECK);
    CHECK(status.onboard_control_sensors_health & MAV_SYS_STATUS_SENSOR_GPS);
    Bench dark;
    dark.app.vehicle.origin.known = false;
    dark.hear(dark.frame(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_GLOBAL_POSITION_INT)));
    communicate(dark.app, dark.board);
    CHECK(dark.app.radio.refused == 1);
}

/// Converting places to degrees and back is exact within a step, over a hundred kilometers.
static void test_degrees() {
    const Origin at = origin_at(601234567, 1799999000);
    for (int k = -10; k <= 10; ++k) {
        const Corner<float> place{997.0f * float(k), -5003.0f * float(k)};
        const Degrees degrees = degrees_of(at, place);
        const Corner<float> back = local(at, degrees.latitude, degrees.longitude);
        CHECK_NEAR(back.x, place.x, 0.02);
        CHECK_NEAR(back.y, place.y, 0.02);
    }
}

static void test_intervals() {
    Bench bench;
    const auto interval = [&](int id) {
        bench.say(command(MAV_CMD_GET_MESSAGE_INTERVAL, float(id)), 100);
        const auto answers = said<mavlink_message_interval_t>(bench.board.said);
        CHECK(!answers.empty() && answers.back().message_id == id);
        return answers.empty() ? 7 : answers.back().interval_us;
    };
    CHECK(interval(MAVLINK_MSG_ID_ATTITUDE) == 250000 && interval(MAVLINK_MSG_ID_VFR_HUD) == -1);
    CHECK(interval(MAVLINK_MSG_ID_WIND_COV) == 0);
    bench.say(command(MAV_CMD_SET_MESSAGE_INTERVAL, MAVLINK_MSG_ID_VFR_HUD, 1e6f));
    CHECK(interval(MAVLINK_MSG_ID_VFR_HUD) == 1000000);
}

static void test_times() {
    Bench bench;
    mavlink_timesync_t ask{};
    ask.ts1 = 123456789;
    bench.say(ask, 10);
    const auto answers = said<mavlink_timesync_t>(bench.board.said);
    CHECK(answers.size() == 1 && answers[0].ts1 == ask.ts1 && answers[0].tc1 > 500000000);
    ask.tc1 = 5;  // an answer
    bench.say(ask, 10);
    CHECK(said<mavlink_timesync_t>(bench.board.said).size() == 1);
    mavlink_system_time_t time{};
    time.time_unix_usec = 1;
    const std::uint32_t before = bench.app.radio.refused;
    bench.say(time, 10);
    CHECK(bench.app.radio.refused == before);
}

/// Every cause that forbids arming is reported by name; the gyroscope is calibrated at rest; accelerometer and compass
/// cannot be calibrated here.
static void test_preparations() {
    Bench bench;
    bench.board.leak = true;
    bench.run(300);
    bench.say(command(MAV_CMD_RUN_PREARM_CHECKS), 100);
    int leaks = 0;
    for (const auto& m : said<mavlink_statustext_t>(bench.board.said))
        leaks += std::strncmp(m.text, fault_texts[int(firmware::Fault::leak)].sentence, sizeof m.text) == 0;
    CHECK(last_answer(bench) == Refusal::none && 1 <= leaks);
    const auto status = last_said<mavlink_sys_status_t>(bench);
    CHECK(!(status.onboard_control_sensors_health & MAV_SYS_STATUS_PREARM_CHECK));
    bench.board.leak = false;
    bench.run(20);
    const int zero = parameter_named(bench.vehicle(), "rate_zero_0");
    CHECK(value(bench.vehicle(), zero) == 0);
    bench.say(command(MAV_CMD_PREFLIGHT_CALIBRATION, 1), 200);
    CHECK(last_answer(bench) == Refusal::none && value(bench.vehicle(), zero) != 0);
    mavlink_command_long_t other = command(MAV_CMD_PREFLIGHT_CALIBRATION, 0, 1);
    bench.say(other);
    CHECK(last_answer(bench) == Refusal::by_program && texts_sent(bench, Refusal::by_program) == 1);
    other = command(MAV_CMD_PREFLIGHT_CALIBRATION), other.param5 = 1;
    bench.say(other);
    CHECK(last_answer(bench) == Refusal::by_program);
    for (int what : {MAV_CMD_DO_START_MAG_CAL, MAV_CMD_DO_ACCEPT_MAG_CAL, MAV_CMD_DO_CANCEL_MAG_CAL}) {
        bench.say(command(what));
        CHECK(last_answer(bench) == Refusal::by_program);
    }
}

static void test_restart() {
    Bench bench;
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    bench.say(command(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1));
    CHECK(last_answer(bench) == Refusal::armed && snapshot(bench.vehicle()).tick > 60);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 0));
    bench.board.said.clear();
    bench.say(command(MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1), int(restart_delay));
    CHECK(last_answer(bench) == Refusal::none);
    bench.run(10);
    CHECK(snapshot(bench.vehicle()).tick < 20);
}

/// Read a file as a ground station does: open, burst, until the last piece.
static void test_files() {
    Bench bench;
    const int name = 3;
    mavlink_file_transfer_protocol_t m{};
    m.target_system = 1;
    const auto ask = [&](FtpHead head, const char* text = "") {
        head.size = std::uint8_t(std::strlen(text));
        m = ftp_message({1, 0}, head, text, head.size);
        bench.board.said.clear();
        bench.say(m, 1500);
        return said<mavlink_file_transfer_protocol_t>(bench.board.said);
    };
    for (int k = 0; k < robot::description.files; ++k) {
        const FileInfo& file = robot::description.file[k];
        auto answers = ask({7, 0, ftp_open, 0, 0, 0, 0, 0}, file.name);
        CHECK(answers.size() == 1 && ftp_head_of(answers[0]).code == ftp_ack && ftp_head_of(answers[0]).sequence == 8);
        const std::uint8_t session = 0;
        Bytes got;
        for (const auto& piece : ask({9, session, ftp_burst, 0, 0, 0, 0, 0})) {
            const FtpHead head = ftp_head_of(piece);
            CHECK(head.code == ftp_ack && head.offset == got.size());
            got.insert(got.end(), piece.payload + ftp_head, piece.payload + ftp_head + head.size);
        }
        CHECK(got.size() == std::size_t(file.size) && std::memcmp(got.data(), file.bytes, got.size()) == 0);
        answers = ask({99, session, ftp_burst, 0, 0, 0, 0, std::uint32_t(file.size)});
        CHECK(answers.size() == 1 && ftp_head_of(answers[0]).code == ftp_nak &&
              answers[0].payload[ftp_head] == ftp_end);
        answers = ask({9, session, ftp_read, 0, 0, 0, 0, 10});
        CHECK(answers.size() == 1 && std::memcmp(answers[0].payload + ftp_head, file.bytes + 10, 20) == 0);
    }
    for (const char* text : {"@PARAM/param.pck", "", "/", "general.jso", "general.jsonx"}) {
        const auto answers = ask({name, 0, ftp_open, 0, 0, 0, 0, 0}, text);
        CHECK(answers.size() == 1 && answers[0].payload[ftp_head] == ftp_not_found);
    }
    CHECK(ask({name, 0, ftp_terminate, 0, 0, 0, 0, 0}).size() == 1);
    const auto answers = ask({name, 0, ftp_read, 0, 0, 0, 0, 0});
    CHECK(answers.size() == 1 && answers[0].payload[ftp_head] == ftp_no_session);
    bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_COMPONENT_METADATA), 100);
    CHECK(std::strcmp(last_said<mavlink_component_metadata_t>(bench).uri, "mftp://general.json") == 0);
}

/// An order to arm that a fault forbids is answered with the fault's own sentence. Texts have the severity of what they
/// report: critical is a leak, and not the refusal or the default parameters.
static void test_reason_of_a_refusal() {
    Bench bench;
    bench.board.leak = true;
    bench.run(200);
    bench.say(command(MAV_CMD_COMPONENT_ARM_DISARM, 1));
    CHECK(last_answer(bench) == Refusal::faulty && texts_sent(bench, Refusal::faulty) == 0);
    std::vector<int> leak, defaults;
    for (const auto& m : said<mavlink_statustext_t>(bench.board.said)) {
        if (std::strncmp(m.text, "there is water in the hull", sizeof m.text) == 0) leak.push_back(m.severity);
        if (std::strncmp(m.text, "no stored parameters", 20) == 0) defaults.push_back(m.severity);
    }
    CHECK(leak == (std::vector<int>{MAV_SEVERITY_CRITICAL, MAV_SEVERITY_WARNING}));  // as a fault, and as the reason
    CHECK(defaults == (std::vector<int>{MAV_SEVERITY_NOTICE}));
}

/// DO_SET_HOME sets home to the present place, or to coordinates, which only COMMAND_INT carries to the centimeter.
static void test_home() {
    Bench bench;
    bench.run(200);
    mavlink_command_int_t there{};
    there.command = MAV_CMD_DO_SET_HOME, there.frame = MAV_FRAME_GLOBAL, there.target_system = 1;
    there.param4 = std::numeric_limits<float>::quiet_NaN(), there.z = 123;
    there.x = origin(bench.vehicle()).latitude + 10000, there.y = origin(bench.vehicle()).longitude;
    bench.board.said.clear();
    bench.say(there);
    CHECK(last_answer(bench) == Refusal::none);
    CHECK_NEAR(last_said<mavlink_home_position_t>(bench).x, 111.2, 0.1);
    CHECK(last_said<mavlink_home_position_t>(bench).latitude == there.x);
    bench.say(command(MAV_CMD_DO_SET_HOME, 1));
    CHECK(last_answer(bench) == Refusal::none);
    CHECK_NEAR(last_said<mavlink_home_position_t>(bench).x, here(bench.vehicle()).y, 1);
    bench.say(command(MAV_CMD_DO_SET_HOME, 0));
    CHECK(last_answer(bench) == Refusal::int_only);
    CHECK(last_said<mavlink_command_ack_t>(bench).result == MAV_RESULT_COMMAND_INT_ONLY);
    there.frame = MAV_FRAME_BODY_FRD, bench.say(there);
    CHECK(last_answer(bench) == Refusal::bad_frame);
    there.frame = MAV_FRAME_GLOBAL, there.x = INT32_MAX, bench.say(there);
    CHECK(last_answer(bench) == Refusal::out_of_range);
    there.frame = MAV_FRAME_LOCAL_NED, there.x = 30'0000, there.y = -20'0000, bench.say(there);
    CHECK(last_answer(bench) == Refusal::none && home_of(bench.vehicle()).y == 30 && home_of(bench.vehicle()).x == -20);
    bench.app.vehicle.unplaced = true;  // the origin was given, but the robot's place in it is unknown
    bench.say(there);
    CHECK(last_answer(bench) == Refusal::not_placed);
}

int main() {
    test_reason_of_a_refusal();
    test_modes();
    test_orders();
    test_positions();
    test_degrees();
    test_intervals();
    test_times();
    test_preparations();
    test_restart();
    test_home();
    test_files();
    return failures();
}
