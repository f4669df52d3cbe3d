/// Missions over the radio: complete and valid, or not at all.
#include "radio_test.hpp"

/// Up, and down again: the same items. One that is broken off, or has a bad item, leaves what was on board.
static void test_missions() {
    Bench bench;
    const auto items = box();
    CHECK(upload(bench, items) == MAV_MISSION_ACCEPTED);
    const Mission<float>& m = mission(bench.vehicle());
    CHECK(m.waypoints == 3 && m.corners == 4 && m.depth_max == 4.0f && m.reserve == 0.2f);
    CHECK(m.silence_below && m.waypoint[2].hold == 60.0f);
    CHECK_NEAR(m.declination, -9 * pi / 180, 1e-6);
    CHECK(m.stay && m.home_radius == 2.5f && m.home_speed == 0.4f);
    CHECK(m.waypoint[2].x == 20.0f && m.waypoint[2].y == 20.0f && m.waypoint[2].depth == 1.5f);
    CHECK(m.waypoint[1].speed == 0.35f && m.home.x == 2.0f && m.home.y == 1.0f);

    std::size_t same = 0;
    CHECK(visit_items(m, [&](const mavlink_mission_item_int_t& got) {
              const auto& sent = items[same++];
              CHECK(got.command == sent.command && got.x == sent.x && got.y == sent.y && got.z == sent.z);
              CHECK(abs(got.param1 - sent.param1) < 1e-5f && got.param2 == sent.param2);
          }) == int(items.size()));

    auto bad = items;
    bad[8].z = std::bit_cast<float>(0x7fc00000u);
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bad = items, bad[8].frame = MAV_FRAME_BODY_FRD;
    CHECK(upload(bench, bad) == MAV_MISSION_UNSUPPORTED_FRAME);
    bad = {items[0], items[1]};
    CHECK(upload(bench, bad) == MAV_MISSION_ERROR);
    bad = items, bad[8].param1 = -1;  // no time to stay
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bad = items, bad[0].param1 = 1e6f;  // the vehicle's own check, of the whole
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    CHECK(mission(bench.vehicle()).waypoints == 3 && mission(bench.vehicle()).depth_max == 4.0f);

    CHECK(upload(bench, {items.begin(), items.end()}, items.size()) == 255);  // no item comes at all
    bench.run(int(request_timeout) * (max_tries + 1));
    const auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(!acks.empty() && acks.back().type == MAV_MISSION_OPERATION_CANCELLED);
    CHECK(said<mavlink_mission_request_int_t>(bench.board.said).size() == max_tries);
    CHECK(mission(bench.vehicle()).waypoints == 3);
}

/// A place in degrees counts from the first fix: a thousandth of a degree of latitude is 111.2 m.
static void test_mission_in_degrees() {
    Bench bench;
    bench.run(200);
    CHECK(origin(bench.vehicle()).known);
    auto point = item(MAV_CMD_NAV_WAYPOINT, 0, 0, -1, 0, 2);
    point.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT;
    point.x = origin(bench.vehicle()).latitude + 10000, point.y = origin(bench.vehicle()).longitude;
    CHECK(upload(bench, {point}) == MAV_MISSION_ACCEPTED);
    CHECK_NEAR(mission(bench.vehicle()).waypoint[0].y, 111.2, 0.1);
    CHECK_NEAR(mission(bench.vehicle()).waypoint[0].x, 0, 1e-3);
    CHECK(mission(bench.vehicle()).waypoint[0].depth == 1.0f);
    point.x = INT32_MIN;
    CHECK(upload(bench, {point}) == MAV_MISSION_INVALID_PARAM5_X);
    point.x = 0, point.y = INT32_MAX;
    CHECK(upload(bench, {point}) == MAV_MISSION_INVALID_PARAM5_X);
}

/// The last item once more, because its answer was lost: the same answer once more.
static void test_lost_acknowledgement_of_a_mission() {
    Bench bench;
    auto items = box();
    CHECK(upload(bench, items) == MAV_MISSION_ACCEPTED);
    bench.board.said.clear();
    items.back().seq = std::uint16_t(items.size() - 1), items.back().target_system = 1;
    bench.say(items.back());
    auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(acks.size() == 1 && acks[0].type == MAV_MISSION_ACCEPTED);
    auto bad = box();
    bad[9].z = -1;  // the whole is refused at its last item
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bench.board.said.clear();
    bench.say(items.back());
    acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(acks.size() == 1 && acks[0].type == MAV_MISSION_INVALID);
    bench.board.said.clear();
    bench.ground.system = 254;  // not somebody else's
    bench.say(items.back());
    CHECK(said<mavlink_mission_ack_t>(bench.board.said).empty());
}

int main() {
    test_missions();
    test_mission_in_degrees();
    test_lost_acknowledgement_of_a_mission();
    return failures();
}
