/// Tests of missions that a fence or a depth forbids: they are refused at upload, at arming, and when they begin.
#include "vehicle_test.hpp"

using hypertuna::Corner;
using hypertuna::inside;

static Refusal given(std::vector<Corner<float>> fence, std::vector<Waypoint<float>> to, Corner<float> home = {},
                     bool stay = false) {
    static std::vector<Corner<float>> corner;
    static std::vector<Waypoint<float>> waypoint;
    corner = fence, waypoint = to;
    Mission<float> m = plan();
    m.corner = corner.data(), m.corners = int(corner.size()), m.home = home, m.stay = stay;
    m.waypoint = waypoint.data(), m.waypoints = int(waypoint.size());
    return set_mission(v, ground, m);
}

static const std::vector<Corner<float>> square = {{-50, -50}, {50, -50}, {50, 50}, {-50, 50}};

/// A mission for each reason of refusal, by hand.
static void refusals_by_hand() {
    begin();
    CHECK(given(square, {{10, 10, 1, 0.3f, 2, 0}}) == Refusal::none);
    CHECK(given(square, {{60, 10, 1, 0.3f, 2, 0}}) == Refusal::outside_fence);
    CHECK(given(square, {{10, 10, 1, 0.3f, 2, 0}}, {0, 51}) == Refusal::outside_fence);
    const std::vector<Corner<float>> bow = {{-50, -50}, {50, 50}, {50, -50}, {-50, 50}};
    CHECK(given(bow, {{40, 0, 1, 0.3f, 2, 0}}, {40, 0}) == Refusal::bad_fence);
    CHECK(given({{0, 0}, {10, 10}, {30, 30}}, {{5, 5, 1, 0.3f, 2, 0}}) == Refusal::bad_fence);
    CHECK(given({{-50, -50}, {-50, -50}, {50, 0}, {0, 50}}, {{0, 0, 1, 0.3f, 2, 0}}) == Refusal::bad_fence);
    // Two halls and a corridor between their southern ends.
    const std::vector<Corner<float>> halls = {{0, 0},   {60, 0},  {60, 60}, {40, 60},
                                              {40, 10}, {20, 10}, {20, 60}, {0, 60}};
    const Waypoint<float> west{10, 50, 1, 0.3f, 2, 0}, east{50, 50, 1, 0.3f, 2, 0}, below{10, 5, 1, 0.3f, 2, 0},
        beside{50, 5, 1, 0.3f, 2, 0};
    CHECK(given(halls, {west, east}, {10, 20}, true) == Refusal::leaves_fence);
    CHECK(given(halls, {west, below, beside, east}, {10, 20}, true) == Refusal::none);
    CHECK(given(halls, {west, below, beside, east}, {10, 20}) == Refusal::leaves_fence);  // on its way home
    CHECK(given(square, {{10, 10, 4.5f, 0.3f, 2, 0}}) == Refusal::too_deep);              // than the mission's 4 m
    Mission<float> m = plan();
    m.depth_max = 31;
    CHECK(set_mission(v, ground, m) == Refusal::too_deep);  // than the 30 m of the depth sensor
    m = plan(), m.range = 60;
    CHECK(set_mission(v, ground, m) == Refusal::outside_fence);  // a circle: its second waypoint is 80 m away
    m.range = 90;
    CHECK(set_mission(v, ground, m) == Refusal::none);
}

/// Rules of mission files (hypertuna.mission.checks): radii below the accuracy of fixes, places too near the fence,
/// limits of depth that an overshoot or a dipping nose passes.
static void margins() {
    begin();
    const float error = v.model.pilot.guidance.error_fix, margin = v.model.pilot.guidance.fence_margin;
    CHECK(1.5f < error && error < 2.0f && margin == 3.0f);
    CHECK(given(square, {{10, 10, 1, 0.3f, error - 0.05f, 0}}) == Refusal::too_small);
    CHECK(given(square, {{10, 10, 1, 0.3f, error + 0.05f, 0}}) == Refusal::none);
    Mission<float> m = plan();
    m.home_radius = error - 0.05f;
    CHECK(set_mission(v, ground, m) == Refusal::too_small);
    m.home_radius = error + 0.05f;
    CHECK(set_mission(v, ground, m) == Refusal::none);
    CHECK(given(square, {{50 - margin + 0.1f, 10, 1, 0.3f, 2, 0}}) == Refusal::outside_fence);
    CHECK(given(square, {{50 - margin, 10, 1, 0.3f, 2, 0}}) == Refusal::none);
    CHECK(given(square, {{10, 10, 3.75f, 0.3f, 2, 0}}) == Refusal::too_deep);  // of 4 m, with 0.3 m more
    CHECK(given(square, {{10, 10, 3.7f, 0.3f, 2, 0}}) == Refusal::none);
    m.depth_max = 0.45f;
    CHECK(set_mission(v, ground, m) == Refusal::too_deep);  // the nose dips by 0.5 m
    m.depth_max = 0.5f;
    CHECK(set_mission(v, ground, m) == Refusal::none);
}

/// A mission on board begins only if it could still be uploaded: parameters may have changed since, also before a
/// restart.
static void a_mission_of_other_parameters() {
    const auto begun = [](const char* name, float to) {
        begin();
        float_on(v, board, 100);
        CHECK(given(square, {{46, 10, 3, 0.3f, 2, 0}}) == Refusal::none);
        CHECK(set_parameter(v, ground, index_of(name), to) == Refusal::none);
        float_on(v, board, 400);  // until both are stored
        boot(v, robot::description, board);
        float_on(v, board, 100);
        CHECK(v.has_mission && give(v, Order::arm, ground) == Refusal::none);
        return give(v, Order::mission, ground);
    };
    CHECK(begun("depth_max", 4) == Refusal::none);
    CHECK(begun("depth_max", 3) == Refusal::too_deep);  // the mission's limit is 4 m
    CHECK(begun("fence_margin", 6) == Refusal::outside_fence);
    // Without a home of its own it comes home to where it was armed.
    static const Corner<float> bend[6] = {{-40, -10}, {40, -10}, {40, 60}, {20, 60}, {20, 10}, {-40, 10}};
    static const Waypoint<float> to[2] = {{30, 0, 1, 0.3f, 2, 0}, {30, 50, 1, 0.3f, 2, 0}};
    Mission<float> m = plan();
    m.corner = bend, m.corners = 6, m.waypoint = to, m.home = {30, 5};
    MissionForm form{2, 0.3f, {{ItemKind::waypoint, local_frame, 0}, {ItemKind::waypoint, local_frame, 0}}, 0};
    begin();
    float_on(v, board, 100);
    CHECK(set_mission(v, ground, m, &form) == Refusal::none);
    float_on(v, board, 300);
    CHECK(give(v, Order::arm, ground) == Refusal::none && v.home.x == 0);
    CHECK(give(v, Order::mission, ground) == Refusal::leaves_fence);
}

/// A mission whose fence the robot is outside of neither begins nor lets the robot arm; a recall is not refused.
static void a_robot_outside() {
    begin_armed();
    std::vector<Corner<float>> far = square;
    for (Corner<float>& corner : far) corner.x += 200;
    CHECK(given(far, {{200, 10, 1, 0.3f, 2, 0}}, {200, 0}) == Refusal::none);
    CHECK(give(v, Order::mission, ground) == Refusal::robot_outside && v.now.state == State::rest);
    CHECK(give(v, Order::disarm, ground) == Refusal::none);
    float_on(v, board, 300);
    CHECK(give(v, Order::arm, ground) == Refusal::none);  // nobody knows where it is
    CHECK(give(v, Order::disarm, ground) == Refusal::none);
    CHECK(clear_mission(v, ground) == Refusal::none && set_origin(v, ground, 500000000, 80000000) == Refusal::none);
    CHECK(given(far, {{200, 10, 1, 0.3f, 2, 0}}, {200, 0}) == Refusal::none);
    float_on(v, board, 300), fix(500000000, 80000000), float_on(v, board, 1);
    CHECK(give(v, Order::arm, ground) == Refusal::robot_outside);
    CHECK(clear_mission(v, ground) == Refusal::none);
    float_on(v, board, 300);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    CHECK(given(far, {{200, 10, 1, 0.3f, 2, 0}}, {200, 0}) == Refusal::none && v.now.armed());
    v.silence = 100'000;
    float_on(v, board, 300);
    CHECK(v.now.state == State::home && v.state.guidance.reasons.has(Reason::recalled));
    // The first leg counts from where the robot is.
    const std::vector<Corner<float>> horseshoe = {{-40, -5}, {40, -5}, {40, 60}, {20, 60}, {20, 5}, {-40, 5}};
    begin_armed();
    CHECK(given(horseshoe, {{30, 50, 1, 0.3f, 2, 0}}, {0, 0}, true) == Refusal::none);
    CHECK(give(v, Order::mission, ground) == Refusal::leaves_fence);
    CHECK(given(horseshoe, {{30, 0, 1, 0.3f, 2, 0}, {30, 50, 1, 0.3f, 2, 0}}, {0, 0}, true) == Refusal::none);
    CHECK(give(v, Order::mission, ground) == Refusal::none);
}

/// Home by order: inside the fence, where the last course leads, and until the robot is disarmed.
static void home_by_order() {
    const auto home_is = [](float x, float y) { return home_of(v).x == x && home_of(v).y == y; };
    begin_armed();
    CHECK(set_home(v, ground, {20, 10}) == Refusal::none && home_is(20, 10));
    CHECK(set_home(v, ground, {2e5f, 0}) == Refusal::out_of_range);
    CHECK(set_home(v, {7, 7}, {0, 0}) == Refusal::other_pilot && home_is(20, 10));
    fix(500000000, 80000000);
    v.silence = 100'000;
    float_on(v, board, 300);  // without a mission it is called there
    CHECK(v.now.state == State::home && v.detour.home.x == 20 && v.detour.home.y == 10);
    CHECK(set_home(v, ground, {0, 0}) == Refusal::not_now && home_is(20, 10));
    CHECK(give(v, Order::disarm, ground) == Refusal::none);
    float_on(v, board, 300);
    const Place at = here(v);
    CHECK(home_is(at.x, at.y) && set_home(v, ground, {30, 0}) == Refusal::none && home_is(30, 0));
    CHECK(give(v, Order::arm, ground) == Refusal::none && home_is(30, 0));
    // That of the mission on board is changed with it, and stored.
    begin();
    CHECK(given(square, {{10, 10, 1, 0.3f, 2, 0}}) == Refusal::none && home_is(0, 0));
    float_on(v, board, 100);
    const std::uint32_t number = v.numbers.mission, fence = v.numbers.fence;
    CHECK(set_home(v, ground, {60, 0}) == Refusal::outside_fence && home_is(0, 0) && v.numbers.mission == number);
    CHECK(set_home(v, ground, {40, 0}) == Refusal::none && home_is(40, 0));
    CHECK(v.numbers.mission != number && v.numbers.fence == fence);
    float_on(v, board, 100);
    boot(v, robot::description, board);
    CHECK(home_is(40, 0) && v.mission.waypoints == 1 && v.numbers.mission != number && v.numbers.fence == fence);
    const std::vector<Corner<float>> horseshoe = {{-40, -5}, {40, -5}, {40, 60}, {20, 60}, {20, 5}, {-40, 5}};
    CHECK(given(horseshoe, {{30, 50, 1, 0.3f, 2, 0}}, {30, 0}) == Refusal::none);
    CHECK(set_home(v, ground, {-30, 0}) == Refusal::leaves_fence && home_is(30, 0));
    // A mission that does not say where home is has it of the order, too.
    begin_armed();
    MissionForm form{};
    form.item[form.items++] = {ItemKind::waypoint, local_frame, 0}, form.item[form.items++] = form.item[0];
    CHECK(set_home(v, ground, {5, -10}) == Refusal::none);
    CHECK(set_mission(v, ground, plan(), &form) == Refusal::none && home_is(5, -10));
    CHECK(give(v, Order::mission, ground) == Refusal::none && v.mission.home.x == 5 && v.mission.home.y == -10);
}

/// Random fences and missions: what is accepted lies inside with all its courses, point by point.
static void random_missions() {
    begin();
    int accepted = 0, left = 0;
    for (int seed = 0; seed < 40000; ++seed) {
        const auto draw = [&](int what) {
            return hypertuna::uniform<float>(hypertuna::random_bits(3, std::uint64_t(what), std::uint64_t(seed)));
        };
        std::vector<Corner<float>> fence;
        const int corners = 3 + int(5 * draw(0));
        for (int k = 0; k < corners; ++k) {
            const float angle = float(2 * hypertuna::pi) * (float(k) + 0.9f * draw(1 + k)) / float(corners),
                        far = 5 + 75 * draw(20 + k);
            fence.push_back({far * std::cos(angle), far * std::sin(angle)});
        }
        std::vector<Waypoint<float>> to;
        for (int k = 0; k < 2; ++k)
            to.push_back({80 * (draw(40 + k) - 0.5f), 80 * (draw(50 + k) - 0.5f), 1, 0.3f, 2, 0});
        const Refusal refusal = given(fence, to);
        const Mission<float>& m = v.mission;
        accepted += refusal == Refusal::none, left += refusal == Refusal::leaves_fence;
        if (refusal != Refusal::none) continue;
        Corner<float> at{to[0].x, to[0].y};
        for (const Corner<float> next : {Corner<float>{to[1].x, to[1].y}, Corner<float>{}}) {
            for (float part = 0; part <= 1; part += 1.0f / 64)
                CHECK(0 < inside(m, at.x + part * (next.x - at.x), at.y + part * (next.y - at.y)).distance);
            at = next;
        }
    }
    std::printf("random missions: %d accepted, %d leave their fence on the way\n", accepted, left);
    CHECK(5000 < accepted && 10 < left);
}

int main() {
    a_mission_of_other_parameters();
    refusals_by_hand();
    margins();
    a_robot_outside();
    home_by_order();
    random_missions();
    return failures();
}
