/// States: every pair of state and order on a vehicle, against the table and against rules that must hold for any
/// table.
#include "vehicle_test.hpp"

static const Station other{7, 190};

/// Bring the vehicle into a state by orders and events, as it gets there in the water.
static void enter_state(State state) {
    begin();
    set_mission(v, ground, plan());
    float_on(v, board, 300);
    if (state == State::disarmed) return;
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    if (state == State::held) CHECK(give(v, Order::mission, ground) == Refusal::none), give(v, Order::hold);
    if (state == State::paused) CHECK(give(v, Order::mission, ground) == Refusal::none);
    const Order order = state_texts[int(state)].order;
    if (order != Order::count && state != State::rest) CHECK(give(v, order, ground) == Refusal::none);
    CHECK(v.now.state == state);
}

/// All pairs: the state that follows, or the refusal, is that of the table; all needs are met here.
static void all_pairs() {
    int pairs = 0, changed = 0;
    for (int s = 0; s < states; ++s)
        for (int o = 0; o < orders; ++o) {
            enter_state(State(s));
            const Rule& rule = rules.row[o];
            const Cell& cell = rule.next[s];
            const State before = v.before;
            Refusal refusal = Refusal::none;
            if (rule.who == Who::board)
                give(v, Order(o));
            else
                refusal = give(v, Order(o), ground);
            CHECK(refusal == cell.refusal);
            const State expected = cell.back ? before : cell.changes() ? cell.next : State(s);
            CHECK(v.now.state == expected);
            float_on(v, board, 1);  // and the tick after it is sound
            ++pairs, changed += cell.changes();
        }
    CHECK(pairs == states * orders && changed > 80);
}

/// Rules that must hold, written without the table.
static void safety() {
    for (int s = 0; s < states; ++s) {
        const State state = State(s);
        // Disarming is accepted in every state, from every station.
        for (Station from : {ground, other}) {
            enter_state(state);
            CHECK(give(v, Order::disarm, from) == Refusal::none && v.now.state == State::disarmed);
        }
        // Nothing but arming, and a boot under water, arms.
        enter_state(State::disarmed);
        for (int o = 0; o < orders; ++o) {
            const bool arms = Order(o) == Order::arm || Order(o) == Order::revive;
            CHECK((rules.row[o].next[int(State::disarmed)].changes()) == arms);
        }
        // No station gives what only the board may.
        enter_state(state);
        for (int o = int(Order::stop); o < orders; ++o) CHECK(give(v, Order(o), ground) == Refusal::unknown);
        CHECK(v.now.state == state);
        // What is set while disarmed only.
        for (Order order : {Order::set_parameter, Order::set_key, Order::set_origin, Order::zero_depth})
            CHECK(check(v, order, ground) == (state == State::disarmed ? Refusal::none : Refusal::armed));
    }
    // Only disarming ends the rest after a fault, whoever orders.
    for (State state : {State::held, State::rest}) {
        enter_state(state);
        v.now.answer = Answer::rest;
        v.now.faults.set(Fault::tilt, true);
        for (int o = 0; o < int(Order::stop); ++o)
            for (Station from : {ground, other}) {
                if (Order(o) == Order::disarm) continue;
                give(v, Order(o), from);
                CHECK(v.now.state == state);
            }
        CHECK(give(v, Order::surface, ground) == Refusal::faulty);
    }
    // A robot that is called home may be stopped by disarming, or made to ascend, and by nothing else.
    enter_state(State::home);
    v.now.answer = Answer::home;
    for (Order order : {Order::rest, Order::manual, Order::gait, Order::mission})
        CHECK(give(v, order, ground) == Refusal::faulty && v.now.state == State::home);
    CHECK(give(v, Order::pause, ground) == Refusal::not_now && give(v, Order::go_on, ground) == Refusal::not_now);
    CHECK(give(v, Order::surface, ground) == Refusal::none && v.now.state == State::surface);
    // A robot that must ascend does not swim away.
    v.now.answer = Answer::disarm;
    for (Order order : {Order::rest, Order::manual, Order::gait, Order::mission, Order::home})
        CHECK(give(v, order, ground) == Refusal::faulty && v.now.state == State::surface);
}

/// Every order to arm that is refused names what is missing.
static void needs() {
    begin();
    CHECK(give(v, Order::arm, ground) == Refusal::not_ready);
    float_on(v, board, 100);
    for (const char* name : {"leak", "depth_sensor", "key_lost"}) {
        for (int f = 0; f < faults; ++f) {
            if (std::strcmp(fault_texts[f].name, name) != 0) continue;
            v.memory.present = {}, v.locked = Fault(f) == Fault::key_lost;
            if (!v.locked) v.memory.present.set(Fault(f), true);
            CHECK(give(v, Order::arm, ground) == Refusal::faulty);
            CHECK(std::strcmp(sentence(v, Refusal::faulty), fault_texts[f].sentence) == 0);
        }
        v.memory.present = {}, v.locked = false;
    }
    v.now.estimate.depth = -0.6f;
    CHECK(give(v, Order::arm, ground) == Refusal::no_depth);
    v.now.estimate.depth = 0.05f;
    CHECK(give(v, Order::mission, ground) == Refusal::disarmed && give(v, Order::arm, ground) == Refusal::none);
    CHECK(give(v, Order::mission, ground) == Refusal::no_mission);
}

/// One station is in control: that which armed, or took control since by an order. The others may only make the robot
/// safer, and their heartbeats do not hold off the loss of the link.
static void control_of_stations() {
    enter_state(State::manual);
    CHECK(sticks(v, other, 0, 0, 0) == Refusal::other_pilot && sticks(v, ground, 0, 0, 0) == Refusal::none);
    CHECK(set_leg(v, other, 0) == Refusal::other_pilot && clear_mission(v, other) == Refusal::other_pilot);
    for (int k = 0; k < 600; ++k) on_ground_contact(v, other), float_on(v, board, 1);
    CHECK(v.now.faults.has(Fault::link_lost) && v.now.state == State::rest);
    CHECK(give(v, Order::manual, other) == Refusal::none && sticks(v, other, 0, 0, 0) == Refusal::none);
    CHECK(sticks(v, ground, 0, 0, 0) == Refusal::other_pilot);
    for (int k = 0; k < 600; ++k) on_ground_contact(v, other), float_on(v, board, 1);
    CHECK(!v.now.faults.has(Fault::link_lost));
    // A station that calls the robot home, pauses or disarms it does not take control.
    enter_state(State::mission);
    for (Order order : {Order::pause, Order::home, Order::surface, Order::disarm})
        CHECK(give(v, order, other) == Refusal::none && v.pilot == (order == Order::disarm ? Station{} : ground));
}

/// A pause keeps the leg; the mission resumes there, also from other states, and starts anew after it was armed again.
static void pauses() {
    enter_state(State::mission);
    CHECK(set_leg(v, ground, 1) == Refusal::none && set_leg(v, ground, 2) == Refusal::out_of_range);
    float_on(v, board, 30);
    CHECK(v.now.leg == 1 && beats());
    CHECK(give(v, Order::pause, ground) == Refusal::none);
    float_on(v, board, 300);
    CHECK(!beats() && v.now.leg == 1 && v.now.command.fin[0] == 0 && !v.now.reasons.has(Reason::recalled));
    CHECK(give(v, Order::go_on, ground) == Refusal::none);
    float_on(v, board, 30);
    CHECK(v.now.state == State::mission && v.now.leg == 1 && beats());
    CHECK(give(v, Order::rest, ground) == Refusal::none);
    float_on(v, board, 30);
    CHECK(!beats() && v.now.leg == 1 && v.now.mode == Mode::idle);
    CHECK(give(v, Order::mission, ground) == Refusal::none);
    float_on(v, board, 30);
    CHECK(v.now.leg == 1);
    give(v, Order::disarm, ground), float_on(v, board, 30);
    CHECK(give(v, Order::arm, ground) == Refusal::none && v.leg == 0);
}

/// A mission that resumes from another state keeps what it reached: a waypoint is skipped only by order.
static void what_was_reached_stays() {
    enter_state(State::mission);
    begin_leg(v.state.guidance, v.mission, 1, {0, 0});
    v.state.guidance.reached = 1, v.state.guidance.reasons.clear(Reason::skipped);
    float_on(v, board, 30);
    CHECK(v.leg == 1);
    for (Order away : {Order::rest, Order::surface}) {
        CHECK(give(v, away, ground) == Refusal::none);
        float_on(v, board, 30);
        CHECK(give(v, Order::mission, ground) == Refusal::none);
        float_on(v, board, 30);
        CHECK(v.state.guidance.leg == 1 && v.state.guidance.reached == 1 && !v.now.reasons.has(Reason::skipped));
    }
    CHECK(give(v, Order::rest, ground) == Refusal::none && set_leg(v, ground, 0) == Refusal::none);
    CHECK(give(v, Order::mission, ground) == Refusal::none);
    CHECK(v.state.guidance.leg == 0 && v.state.guidance.reached == 0);
    CHECK(set_leg(v, ground, 1) == Refusal::none && v.state.guidance.reasons.has(Reason::skipped));
    give(v, Order::disarm, ground), float_on(v, board, 30);
    CHECK(give(v, Order::arm, ground) == Refusal::none && v.progress.reached == 0);
}

/// Home is where the robot was armed, not where it booted or where a mission without a home was uploaded.
static void home_is_where_it_was_armed() {
    const auto swim = [] {
        CHECK(set_gait(v, ground, beat()) == Refusal::none);
        for (int k = 0; k < 4000; ++k) on_ground_contact(v, ground), float_on(v, board, 1);
    };
    begin_armed();
    MissionForm form{};
    form.item[form.items++] = {ItemKind::waypoint, local_frame, 0}, form.item[form.items++] = form.item[0];
    CHECK(set_mission(v, ground, plan(), &form) == Refusal::none);
    swim();
    give(v, Order::disarm, ground), float_on(v, board, 300);
    const Place at = here(v);
    CHECK(std::hypot(at.x, at.y) > 5 && give(v, Order::arm, ground) == Refusal::none);
    CHECK(v.mission.home.x == at.x && v.mission.home.y == at.y);
    CHECK(clear_mission(v, ground) == Refusal::none);
    swim();
    CHECK(std::hypot(here(v).x - at.x, here(v).y - at.y) > 5 && give(v, Order::home, ground) == Refusal::none);
    float_on(v, board, 30);
    CHECK(beats() && v.now.mode == Mode::home && v.detour.home.x == at.x && v.detour.home.y == at.y);
    CHECK(std::strcmp(state_texts[int(v.now.state)].name, "home") == 0);
}

int main() {
    all_pairs();
    safety();
    needs();
    control_of_stations();
    pauses();
    what_was_reached_stays();
    home_is_where_it_was_armed();
    CHECK(allocations == 0);
    return failures();
}
