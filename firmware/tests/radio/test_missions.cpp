/// Tests of missions over the radio: accepted complete and valid, or not at all.
#include "radio_test.hpp"

/// A mission that is uploaded and downloaded again has the same items. An upload that is interrupted or has a bad item
/// leaves the mission on board unchanged.
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

    const auto got = download(bench);
    CHECK(got.size() == items.size());
    for (std::size_t k = 0; k < got.size() && k < items.size(); ++k) CHECK(same(got[k], items[k]));

    auto bad = items;
    bad[8].z = std::bit_cast<float>(0x7fc00000u);
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bad = items, bad[8].frame = MAV_FRAME_BODY_FRD;
    CHECK(upload(bench, bad) == MAV_MISSION_UNSUPPORTED_FRAME);
    bad = {items[0], items[1]};
    CHECK(upload(bench, bad) == MAV_MISSION_ERROR);
    bad = items, bad[8].param1 = -1;  // an invalid time to stay
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bad = items, bad[0].param1 = 1e6f;  // refused by the vehicle's own check of the whole mission
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    CHECK(mission(bench.vehicle()).waypoints == 3 && mission(bench.vehicle()).depth_max == 4.0f);

    CHECK(upload(bench, {items.begin(), items.end()}, items.size()) == 255);  // no item comes at all
    bench.run(int(request_timeout) * (max_tries + 1));
    const auto acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(!acks.empty() && acks.back().type == MAV_MISSION_OPERATION_CANCELLED);
    CHECK(said<mavlink_mission_request_int_t>(bench.board.said).size() == max_tries);
    CHECK(mission(bench.vehicle()).waypoints == 3);
}

/// Places in degrees are relative to the first fix: a thousandth of a degree of latitude is 111.2 m.
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
    CHECK(upload(bench, {point}) == MAV_MISSION_INVALID);
    point.x = 0, point.y = INT32_MAX;
    CHECK(upload(bench, {point}) == MAV_MISSION_INVALID);
}

/// The last item is sent again because its answer was lost: the answer is the same.
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
    bad[9].param2 = 0.1f;  // the whole mission is refused at its last item
    CHECK(upload(bench, bad) == MAV_MISSION_INVALID);
    bench.board.said.clear();
    bench.say(items.back());
    acks = said<mavlink_mission_ack_t>(bench.board.said);
    CHECK(acks.size() == 1 && acks[0].type == MAV_MISSION_INVALID);
    bench.board.said.clear();
    bench.ground.system = 254;  // an upload by another station
    bench.say(items.back());
    CHECK(said<mavlink_mission_ack_t>(bench.board.said).empty());
}

/// Each change of mission or fence changes its own number only; a client recognizes its mission on board by the number.
static void test_numbers_of_plans() {
    Bench bench;
    const auto acked = [&] { return last_said<mavlink_mission_ack_t>(bench).opaque_id; };
    const auto counted = [&](std::uint8_t type) {
        download(bench, type);
        return last_said<mavlink_mission_count_t>(bench).opaque_id;
    };
    const auto current = [&] {
        bench.board.said.clear();
        bench.say(command(MAV_CMD_REQUEST_MESSAGE, MAVLINK_MSG_ID_MISSION_CURRENT));
        return last_said<mavlink_mission_current_t>(bench);
    };
    constexpr std::uint8_t way = MAV_MISSION_TYPE_MISSION, fence = MAV_MISSION_TYPE_FENCE;
    CHECK(current().mission_id == 0 && current().fence_id == 0 && counted(way) == 0 && counted(fence) == 0);
    const std::vector<mavlink_mission_item_int_t> circle = {item(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 0, 0, 0, 90)},
                                                  wider = {item(MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 0, 0, 0, 91)};
    const std::vector<mavlink_mission_item_int_t> there = {item(MAV_CMD_NAV_WAYPOINT, 20, 0, 1, 0, 2)};
    CHECK(upload(bench, circle, 0, fence) == MAV_MISSION_ACCEPTED);
    const std::uint32_t first_fence = acked();
    CHECK(upload(bench, there) == MAV_MISSION_ACCEPTED);
    const std::uint32_t first = acked();
    CHECK(first != 0 && first_fence != 0 && current().mission_id == first && current().fence_id == first_fence);
    CHECK(counted(way) == first && counted(fence) == first_fence);
    CHECK(upload(bench, wider, 0, fence) == MAV_MISSION_ACCEPTED);
    const std::uint32_t second_fence = acked();
    CHECK(second_fence != first_fence && current().fence_id == second_fence && current().mission_id == first);
    for (int k = 0; k < 4; ++k) {  // any number of a waypoint
        auto other = there;
        (k == 0 ? other[0].param1 : k == 1 ? other[0].param2 : other[0].z) += 1.0f;
        if (k == 3) other = there, other[0].x += 1;
        CHECK(upload(bench, other) == MAV_MISSION_ACCEPTED);
        const std::uint32_t next = acked();
        CHECK(next != first && current().mission_id == next && current().fence_id == second_fence);
    }
    CHECK(upload(bench, {item(MAV_CMD_NAV_WAYPOINT, 200, 0, 1, 0, 2)}) == MAV_MISSION_INVALID && acked() == 0);
    // A fence among a mission's items counts in the numbers of both.
    CHECK(upload(bench, box()) == MAV_MISSION_ACCEPTED);
    const std::uint32_t with_fence = acked();
    auto moved = box();
    moved[3].x -= 10000;
    CHECK(upload(bench, moved) == MAV_MISSION_ACCEPTED && acked() != with_fence);
    bench.run(300);
    boot(bench.app, robot::description, bench.board);
    bench.run(60);
    CHECK(current().mission_id != 0 && current().mission_id != with_fence);
    mavlink_mission_clear_all_t clear{};
    clear.target_system = 1, clear.mission_type = MAV_MISSION_TYPE_ALL;
    bench.say(clear);
    CHECK(acked() == 0 && current().mission_id == 0 && current().fence_id == 0);
}

static const float no_number = std::bit_cast<float>(0x7fc00000u);

static mavlink_mission_item_int_t at_degrees(const Bench& bench, int what, int north, int east, float z) {
    auto m = item(what, 0, 0, z);
    m.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT_INT;
    m.x = origin(bench.vehicle()).latitude + north, m.y = origin(bench.vehicle()).longitude + east;
    return m;
}

/// A mission as MAVSDK sends it: NaN where a number has no use, speeds behind their waypoints, the way home last. As
/// many items come back, in their frames, with their values.
static void test_items_come_back() {
    Bench bench;
    bench.run(200);
    std::vector<mavlink_mission_item_int_t> items;
    for (int k = 0; k < 3; ++k) {
        auto point = at_degrees(bench, MAV_CMD_NAV_WAYPOINT, 1234 * k - 777, 4321 - 999 * k, -0.5f * float(k));
        point.param1 = 10.0f * float(k), point.param2 = k == 0 ? no_number : 2.5f, point.param4 = no_number;
        items.push_back(point);
        auto speed = item(MAV_CMD_DO_CHANGE_SPEED, 0, 0, 0, 1, 0.2f + 0.05f * float(k));
        speed.frame = MAV_FRAME_MISSION, speed.param3 = -1.0f;
        items.push_back(speed);
    }
    auto back = item(MAV_CMD_NAV_RETURN_TO_LAUNCH, 0, 0, 0);
    back.frame = MAV_FRAME_MISSION, back.param1 = back.param2 = back.param3 = back.param4 = no_number;
    items.push_back(back);
    CHECK(upload(bench, items) == MAV_MISSION_ACCEPTED);
    const Mission<float>& m = mission(bench.vehicle());
    CHECK(m.waypoints == 3 && m.waypoint[2].hold == 20.0f && m.waypoint[2].speed == 0.25f &&
          m.waypoint[2].depth == 1.0f);
    const auto got = download(bench);
    CHECK(got.size() == items.size());
    for (std::size_t k = 0; k < got.size() && k < items.size(); ++k) CHECK(same(got[k], items[k]));
    std::swap(items[5], items[6]);  // not the last
    CHECK(upload(bench, items) == MAV_MISSION_INVALID && texts_sent(bench, Refusal::way_home) == 1);
}

/// Altitudes count upward from the surface, depths downward. Frames of the body, of the terrain or of other axes are
/// refused.
static void test_frames() {
    Bench bench;
    bench.run(200);
    for (int frame :
         {MAV_FRAME_GLOBAL, MAV_FRAME_GLOBAL_INT, MAV_FRAME_GLOBAL_RELATIVE_ALT, MAV_FRAME_GLOBAL_RELATIVE_ALT_INT}) {
        auto point = at_degrees(bench, MAV_CMD_NAV_WAYPOINT, 100, 100, -2);
        point.frame = std::uint8_t(frame);
        CHECK(upload(bench, {point}) == MAV_MISSION_ACCEPTED && mission(bench.vehicle()).waypoint[0].depth == 2.0f);
        CHECK(download(bench).at(0).frame == frame);
        point.z = 400;
        CHECK(upload(bench, {point}) == MAV_MISSION_INVALID);
        CHECK(texts_sent(bench, "item 0: above the water: altitude 400 m, max 0") == 1);
        point.z = no_number;
        CHECK(upload(bench, {point}) == MAV_MISSION_INVALID && texts_sent(bench, "item 0: altitude is no number") == 1);
    }
    for (int frame : {MAV_FRAME_LOCAL_OFFSET_NED, MAV_FRAME_LOCAL_ENU, MAV_FRAME_BODY_NED, MAV_FRAME_BODY_FRD,
                      MAV_FRAME_GLOBAL_TERRAIN_ALT, MAV_FRAME_GLOBAL_TERRAIN_ALT_INT, MAV_FRAME_MISSION}) {
        auto point = item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1);
        point.frame = std::uint8_t(frame);
        CHECK(upload(bench, {point}) == MAV_MISSION_UNSUPPORTED_FRAME);
        CHECK(texts_sent(bench, "item 0: unsupported frame: degrees or local NED") == 1);
    }
    Bench lost;  // without an origin, degrees have no place
    auto point = item(MAV_CMD_NAV_WAYPOINT, 0, 0, 0);
    point.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, point.x = 500000000, point.y = 80000000;
    if (!origin(lost.vehicle()).known)
        CHECK(upload(lost, {point}) == MAV_MISSION_DENIED &&
              texts_sent(lost, "item 0: the position is unknown: no fix yet") == 1);
}

/// Unsupported items are refused with the item's number and command; the mission on board stays.
static void test_unsupported_items() {
    Bench bench;
    CHECK(upload(bench, box()) == MAV_MISSION_ACCEPTED);
    const auto point = item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1);
    CHECK(upload(bench, {point, item(MAV_CMD_NAV_TAKEOFF, 0, 0, 0)}) == MAV_MISSION_UNSUPPORTED);
    CHECK(texts_sent(bench, "item 1, command 22: unsupported: use waypoints") == 1);
    std::vector<mavlink_mission_item_int_t> long_one(101, point);
    long_one.back().command = HYPERTUNA_CMD_GAIT;
    for (int k = 64; k < 100; ++k) long_one[std::size_t(k)] = item(MAV_CMD_DO_CHANGE_SPEED, 0, 0, 0, 1, 0.3f);
    CHECK(upload(bench, long_one) == MAV_MISSION_UNSUPPORTED);
    CHECK(texts_sent(bench, "item 100, command 52510: unsupported: use waypoint") == 1);  // all that a text holds
    CHECK(upload(bench, {point}, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_UNSUPPORTED);
    CHECK(texts_sent(bench, "item 0, command 16: unsupported: use waypoints") == 1);
    CHECK(mission(bench.vehicle()).waypoints == 3);
}

/// A radius of 0, or none, means the default of mission files, and is downloaded as it was uploaded; a radius below the
/// accuracy of fixes is refused.
static void test_no_radius() {
    Bench bench;
    for (float radius : {0.0f, no_number}) {
        const auto point = item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1, 0, radius);
        CHECK(upload(bench, {point}) == MAV_MISSION_ACCEPTED && mission(bench.vehicle()).waypoint[0].radius == 3.0f);
        CHECK(same(download(bench).at(0), point));
    }
    for (float radius : {0.1f, 1.0f}) {
        CHECK(upload(bench, {item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1, 0, radius)}) == MAV_MISSION_INVALID);
        CHECK(texts_sent(bench, radius < 1 ? "item 0: radius 0.1 m, min 1.89" : "item 0: radius 1 m, min 1.89") == 1);
    }
}

/// An item that is refused is named with its quantity, its value and the bound, also where the whole is checked.
static void test_a_refusal_names_item_quantity_and_bound() {
    Bench bench;
    bench.run(200);
    const auto good = item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1);
    const auto speed = [](float to) { return item(MAV_CMD_DO_CHANGE_SPEED, 0, 0, 0, 1, to); };
    auto far = item(MAV_CMD_NAV_WAYPOINT, 0, 0, 1), pole = at_degrees(bench, MAV_CMD_NAV_WAYPOINT, 0, 0, -1);
    far.y = 2000000000, pole.x = 900000000;
    const struct {
        mavlink_mission_item_int_t item;
        const char* text;
    } cases[] = {
        {item(MAV_CMD_NAV_WAYPOINT, 1, 1, -5), "item 1: above the water: altitude 5 m, max 0"},
        {item(MAV_CMD_NAV_WAYPOINT, 1, 1, 9000), "item 1: depth 9000 m, max 4.7"},
        {item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1, -5), "item 1: time to stay -5 s, min 0"},
        {item(MAV_CMD_NAV_WAYPOINT, 1, 1, 1, 0, -1), "item 1: radius -1 m, min 0.01"},
        {far, "item 1: east of the origin 200000 m, max 100000"},
        {pole, "item 1: latitude 90 deg, max 89.99"},
        {speed(-1), "item 1: speed -1 m/s, min 0.01"},
        {speed(no_number), "item 1: speed 0 m/s, min 0.01"},
        {speed(9.9f), "item 2: speed 9.9 m/s, max 0.95"},
        {item(HYPERTUNA_CMD_BOUNDS, 0, 0, 0, 9500), "limit of depth 9500 m, max 10"},
        {item(HYPERTUNA_CMD_BOUNDS, 0, 0, 0, 0.4f), "limit of depth 0.4 m, min 0.5"},
        {item(HYPERTUNA_CMD_BOUNDS, 0, 0, 9.9f), "home speed 9.9 m/s, max 0.95"},
        {item(HYPERTUNA_CMD_BOUNDS, 0, 0, 0, 0, 2), "reserve 2, max 1"},
    };
    for (const auto& each : cases) {
        CHECK(upload(bench, {good, each.item, good}) == MAV_MISSION_INVALID);
        if (texts_sent(bench, each.text) != 1) std::printf("not sent: %s\n", each.text);
        CHECK(texts_sent(bench, each.text) == 1);
        CHECK(said<mavlink_statustext_t>(bench.board.said).size() == 1);
    }
    // A leg that crosses a notch of the fence, and lists that are too long.
    std::vector<mavlink_mission_item_int_t> notched;
    for (auto [north, east] :
         {std::pair{-30, -30}, {-30, 30}, {30, 30}, {30, 10}, {-10, 10}, {-10, -10}, {30, -10}, {30, -30}})
        notched.push_back(item(MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, float(north), float(east), 0, 8));
    notched.push_back(item(MAV_CMD_DO_SET_HOME, -20, 0, 0));
    for (float east : {20.0f, -20.0f}) notched.push_back(item(MAV_CMD_NAV_WAYPOINT, 20, east, 1));
    CHECK(upload(bench, notched) == MAV_MISSION_INVALID);
    CHECK(texts_sent(bench, "item 10: a straight course would leave the fence") == 1);
    const std::vector<mavlink_mission_item_int_t> many(65, good), more(max_items + 1, good);
    CHECK(upload(bench, many) == MAV_MISSION_NO_SPACE && texts_sent(bench, "item 64: waypoints 65, max 64") == 1);
    CHECK(upload(bench, more) == MAV_MISSION_NO_SPACE && texts_sent(bench, "items 165, max 164") == 1);
    CHECK(mission(bench.vehicle()).waypoints == 0);
}

static std::vector<mavlink_mission_item_int_t> square(const Bench& bench, int half) {
    std::vector<mavlink_mission_item_int_t> items;
    for (int k = 0; k < 4; ++k) {
        items.push_back(at_degrees(bench, MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, k < 2 ? -half : half,
                                   k % 3 == 0 ? -half : half, 0));
        items.back().frame = MAV_FRAME_GLOBAL, items.back().param1 = 4;
    }
    return items;
}

/// A fence is a separate list: it is downloaded as it was uploaded, applies to missions before and after it, and is
/// cleared alone.
static void test_fence() {
    Bench bench;
    bench.run(200);
    const auto fence = square(bench, 3000);
    CHECK(upload(bench, fence, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_ACCEPTED);
    CHECK(mission(bench.vehicle()).corners == 4 && !bench.vehicle().has_mission);
    const auto got = download(bench, MAV_MISSION_TYPE_FENCE);
    CHECK(got.size() == 4);
    for (std::size_t k = 0; k < got.size(); ++k) CHECK(same(got[k], fence[k]));
    bench.run(400);  // until it is stored
    const float before = bench.app.vehicle.now.estimate.y;
    bench.app.vehicle.now.estimate.y = 100;  // outside, without a mission
    CHECK(give(bench.app.vehicle, Order::arm, Station{255, 190}) == Refusal::robot_outside);
    bench.app.vehicle.now.estimate.y = before;
    CHECK(upload(bench, {at_degrees(bench, MAV_CMD_NAV_WAYPOINT, 5000, 0, -1)}) == MAV_MISSION_INVALID);
    CHECK(texts_sent(bench, "item 0: fence margin -22.25 m, min 2.99") == 1);
    CHECK(upload(bench, {at_degrees(bench, MAV_CMD_NAV_WAYPOINT, 2000, 0, -1)}) == MAV_MISSION_ACCEPTED);
    CHECK(mission(bench.vehicle()).corners == 4 && download(bench).size() == 1);
    CHECK(upload(bench, square(bench, 1000), 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_INVALID);
    CHECK(texts_sent(bench, "mission item 0: fence margin -11.12 m, min 2.99") == 1);
    auto circle = at_degrees(bench, MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, 0, 0, 0);
    circle.param1 = 60;
    CHECK(upload(bench, {circle}, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_ACCEPTED);
    CHECK(download(bench, MAV_MISSION_TYPE_FENCE).size() == 1 && mission(bench.vehicle()).range == 60.0f);
    CHECK(upload(bench, {}, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_ACCEPTED);  // no items: cleared
    CHECK(mission(bench.vehicle()).range == 0.0f && bench.vehicle().has_mission);
    CHECK(upload(bench, fence, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_ACCEPTED);
    mavlink_mission_clear_all_t clear{};
    clear.target_system = 1;
    bench.say(clear);
    CHECK(!bench.vehicle().has_mission && download(bench).empty() && mission(bench.vehicle()).corners == 4);
    clear.mission_type = MAV_MISSION_TYPE_ALL;
    bench.say(clear);
    CHECK(mission(bench.vehicle()).corners == 0 && download(bench, MAV_MISSION_TYPE_FENCE).empty());
}

/// An exclusion fence, two fences, or a line are refused with the reason; so are rally points, except an empty list.
static void test_other_fences() {
    Bench bench;
    bench.run(200);
    for (int what : {MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION, MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION}) {
        auto out = at_degrees(bench, what, 100, 100, 0);
        out.param1 = 4;
        CHECK(upload(bench, {out}, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_UNSUPPORTED);
        CHECK(texts_sent(bench, "item 0: one polygon or circle to stay inside of") == 1);
    }
    auto two = square(bench, 3000), more = square(bench, 1000);
    two.insert(two.end(), more.begin(), more.end());
    CHECK(upload(bench, two, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_UNSUPPORTED);
    auto line = square(bench, 1000);
    line.resize(2);
    CHECK(upload(bench, line, 0, MAV_MISSION_TYPE_FENCE) == MAV_MISSION_INVALID);
    CHECK(upload(bench, {at_degrees(bench, MAV_CMD_NAV_RALLY_POINT, 1, 1, 0)}, 0, MAV_MISSION_TYPE_RALLY) ==
          MAV_MISSION_UNSUPPORTED);
    CHECK(texts_sent(bench, Refusal::no_rally) == 1 && download(bench, MAV_MISSION_TYPE_RALLY).empty());
    CHECK(upload(bench, {}, 0, MAV_MISSION_TYPE_RALLY) == MAV_MISSION_ACCEPTED);
    CHECK(fence_items(bench.vehicle()) == 0);
}

/// Mission and fence belong to the origin of their coordinates: another origin moves neither. In other water both are
/// dropped, with their items.
static void test_origin() {
    for (const bool fence : {true, false}) {
        Bench bench;
        bench.run(200);
        const auto items = fence ? square(bench, 3000) : box();
        CHECK(upload(bench, items, 0, fence ? MAV_MISSION_TYPE_FENCE : MAV_MISSION_TYPE_MISSION) ==
              MAV_MISSION_ACCEPTED);
        mavlink_set_gps_global_origin_t elsewhere{};
        elsewhere.target_system = 1, elsewhere.latitude = 100000000, elsewhere.longitude = 100000000;
        bench.say(elsewhere);
        CHECK(texts_sent(bench, Refusal::elsewhere) == 1 && mission(bench.vehicle()).corners == 4);
        bench.run(400);  // until it is stored
        boot(bench.app, robot::description, bench.board);
        CHECK(mission(bench.vehicle()).corners == 4 && bench.vehicle().has_mission != fence);
        const std::int32_t far[2] = {100000000, 100000000};
        on_first_fix(bench.app.vehicle, far);
        CHECK(mission(bench.vehicle()).corners == 0 && !bench.vehicle().has_mission);
        CHECK(download(bench).empty() && download(bench, MAV_MISSION_TYPE_FENCE).empty());
    }
}

int main() {
    test_origin();
    test_items_come_back();
    test_frames();
    test_unsupported_items();
    test_no_radius();
    test_a_refusal_names_item_quantity_and_bound();
    test_fence();
    test_other_fences();
    test_missions();
    test_mission_in_degrees();
    test_numbers_of_plans();
    test_lost_acknowledgement_of_a_mission();
    return failures();
}
