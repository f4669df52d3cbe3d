/// States of the robot, the orders of the ground and the events on board that change them, and the table of both.
///
/// Nothing else changes the state: `give` (orders.hpp) looks up the row of the order and the column of the state.
#pragma once

#include "app/vehicle/refusal.hpp"

namespace hypertuna::firmware {

/// What the robot does. MAVLink's custom_mode is mode_base + index; `disarmed` appears as `rest` without the armed
/// flag.
enum class State : std::uint8_t { disarmed, rest, manual, gait, mission, paused, home, surface, held, count };
inline constexpr int states = int(State::count), mode_base = 100;

/// What changes the state or needs its permission: orders of a ground station, then events on board.
enum class Order : std::uint8_t {
    arm,
    disarm,
    rest,
    manual,
    gait,
    mission,
    pause,
    go_on,
    home,
    surface,
    sticks,
    set_leg,
    upload,
    clear,
    set_parameter,
    set_key,
    set_origin,
    set_home,
    zero_depth,
    // events
    stop,
    recall,
    ascend,
    halt,
    hold,
    release,
    end,
    complete,
    arrive,
    drop,
    emerge,
    fail,
    spend,
    revive,
    count
};
inline constexpr int orders = int(Order::count);

/// A sender of commands over the radio, by its MAVLink ids.
struct Station {
    std::uint8_t system, component;
    bool operator==(const Station&) const = default;
};

/// Who may give an order.
enum class Who : std::uint8_t {
    anyone,  // any station: orders that make the robot safer
    taker,   // any station, which becomes the pilot station
    pilot,   // the pilot station; any station while disarmed
    board,   // the supervisor or the pilot on board
    count
};
inline constexpr const char* who_names[int(Who::count)] = {"any station", "any station, which takes control",
                                                           "the station in control", "on board"};

/// What must hold for an order to change the state, in the order in which it is checked.
enum class Need : std::uint8_t { sound, stored, attitude, depth, inside, obeys, rises, upright, mission, start, count };
struct NeedText {
    const char* name;
    const char* sentence;
};
inline constexpr NeedText need_texts[int(Need::count)] = {
    {"sound", "no fault forbids arming"},
    {"stored", "parameters, key and mission are stored"},
    {"attitude", "the attitude is known"},
    {"depth", "the depth is plausible"},
    {"inside", "the robot is inside the fence of the mission on board, where its position is known"},
    {"obeys", "no fault calls it home, up, to a stop or to rest"},
    {"rises", "no fault calls it up, to a stop or to rest"},
    {"upright", "no fault makes it rest"},
    {"mission", "there is a mission on board"},
    {"start", "the mission fits the present parameters, and the course to its current waypoint stays inside the fence"},
};

/// Whether the pilot on board makes the command.
constexpr bool is_guided(State state) {
    return state == State::mission || state == State::home || state == State::surface;
}

/// Whether the ground makes the command: the depth limit is the hull's, and silence counts under water too.
constexpr bool by_ground(State state) { return state == State::rest || state == State::manual || state == State::gait; }

struct StateText {
    const char* name;
    const char* sentence;
    Order order;  // order by which a ground station selects the state as a mode; Order::count if it does not
};
inline constexpr StateText state_texts[states] = {
    {"disarmed", "no servo pulses once the tail is at rest", Order::count},
    {"rest", "armed: tail at rest, fins level", Order::rest},
    {"manual", "the sticks make the command", Order::manual},
    {"gait", "a steady gait of the ground makes the command", Order::gait},
    {"mission", "the pilot follows the mission on board", Order::mission},
    {"paused", "the mission waits on its leg: tail at rest, fins level", Order::pause},
    {"home", "the pilot swims home at the surface", Order::home},
    {"surface", "the pilot ascends here, then rests", Order::surface},
    {"held", "tilted: tail at rest until upright, then it continues as before", Order::count},
};

/// Effect of an order in a state: another state, the same state (the order is accepted), or a refusal.
struct Cell {
    State next = State::count;  // State::count: the state does not change
    Refusal refusal = Refusal::none;
    bool back = false;  // return to the state before `held`

    constexpr Cell(State to) : next(to) {}
    constexpr Cell(Refusal why) : refusal(why) {}
    constexpr Cell(bool returns) : back(returns) {}
    constexpr bool changes() const { return back || next != State::count; }
};

struct Rule {
    const char* name;
    const char* sentence;
    Who who;
    std::uint16_t needs;  // a bit for each Need
    Cell next[states];
};

namespace table {

constexpr std::uint16_t needs() { return 0; }
template <class... N>
constexpr std::uint16_t needs(Need first, N... others) {
    return std::uint16_t(1u << int(first) | needs(others...));
}
inline constexpr Cell stay{Refusal::none}, back{true};
inline constexpr Cell off{State::disarmed}, rest{State::rest}, manual{State::manual}, gait{State::gait},
    mission{State::mission}, paused{State::paused}, home{State::home}, up{State::surface}, held{State::held};
inline constexpr Cell disarmed{Refusal::disarmed}, armed{Refusal::armed}, faulty{Refusal::faulty},
    not_now{Refusal::not_now};
inline constexpr std::uint16_t free = needs(), obeys = needs(Need::obeys);

}  // namespace table

/// A row per order, a column per state.
inline constexpr struct Rules {
    Rule row[orders];
} rules = [] {
    using namespace table;
    constexpr std::uint16_t arming = needs(Need::sound, Need::stored, Need::attitude, Need::depth, Need::inside),
                            begins = needs(Need::obeys, Need::mission, Need::start), rises = needs(Need::rises),
                            upright = needs(Need::upright);
    // clang-format off
    return Rules{{
    //                                                    disarmed  rest     manual   gait     mission  paused   home     surface  held
    {"arm", "arm", Who::taker, arming,                     {rest,     stay,    stay,    stay,    stay,    stay,    stay,    stay,    stay}},
    {"disarm", "disarm", Who::anyone, free,                {stay,     off,     off,     off,     off,     off,     off,     off,     off}},
    {"rest", "rest", Who::taker, obeys,                    {disarmed, stay,    rest,    rest,    rest,    rest,    rest,    rest,    faulty}},
    {"manual", "follow the sticks", Who::taker, obeys,     {disarmed, manual,  stay,    manual,  manual,  manual,  manual,  manual,  faulty}},
    {"gait", "follow a gait", Who::taker, obeys,           {disarmed, gait,    gait,    stay,    gait,    gait,    gait,    gait,    faulty}},
    {"mission", "start or resume the mission", Who::taker, begins,
                                                           {disarmed, mission, mission, mission, stay,    mission, mission, mission, faulty}},
    {"pause", "pause", Who::anyone, free,                  {disarmed, stay,    rest,    rest,    paused,  stay,    not_now, not_now, faulty}},
    {"go_on", "end the pause", Who::taker, obeys,          {disarmed, not_now, not_now, not_now, stay,    mission, not_now, not_now, faulty}},
    {"home", "swim home", Who::anyone, rises,              {disarmed, home,    home,    home,    home,    home,    stay,    home,    faulty}},
    {"surface", "ascend here", Who::anyone, upright,         {disarmed, up,      up,      up,      up,      up,      up,      stay,    faulty}},
    {"sticks", "deflection of the sticks", Who::pilot, free,
                                                           {disarmed, not_now, stay,    not_now, not_now, not_now, not_now, not_now, not_now}},
    {"set_leg", "set the current waypoint", Who::pilot, free,
                                                           {stay,     stay,    stay,    stay,    stay,    stay,    not_now, not_now, not_now}},
    {"upload", "replace the mission", Who::pilot, free,    {stay,     stay,    stay,    stay,    not_now, not_now, not_now, stay,    not_now}},
    {"clear", "delete the mission", Who::pilot, free,      {stay,     stay,    stay,    stay,    not_now, not_now, not_now, stay,    not_now}},
    {"set_parameter", "set a parameter", Who::pilot, free, {stay,     armed,   armed,   armed,   armed,   armed,   armed,   armed,   armed}},
    {"set_key", "set the key", Who::pilot, free,           {stay,     armed,   armed,   armed,   armed,   armed,   armed,   armed,   armed}},
    {"set_origin", "set the origin", Who::pilot, free,     {stay,     armed,   armed,   armed,   armed,   armed,   armed,   armed,   armed}},
    {"set_home", "set home", Who::pilot, free,             {stay,     stay,    stay,    stay,    not_now, not_now, not_now, stay,    not_now}},
    {"zero_depth", "take this depth as the surface", Who::pilot, free,
                                                           {stay,     armed,   armed,   armed,   armed,   armed,   armed,   armed,   armed}},
    {"stop", "ground silent, or a fault without a way home", Who::board, free,
                                                           {stay,     stay,    rest,    rest,    stay,    stay,    stay,    stay,    stay}},
    {"recall", "a fault calls it home", Who::board, free,  {stay,     home,    home,    home,    home,    home,    stay,    stay,    stay}},
    {"ascend", "a fault calls it up", Who::board, free,    {stay,     up,      up,      up,      up,      up,      up,      stay,    stay}},
    {"halt", "a fault stops it here", Who::board, free,    {stay,     stay,    rest,    rest,    rest,    rest,    rest,    stay,    stay}},
    {"hold", "tilted", Who::board, free,                   {stay,     stay,    rest,    rest,    held,    stay,    held,    held,    stay}},
    {"release", "upright again", Who::board, free,         {stay,     stay,    stay,    stay,    stay,    stay,    stay,    stay,    back}},
    {"end", "the pilot ends the mission early", Who::board, free,
                                                           {stay,     stay,    stay,    stay,    home,    stay,    stay,    stay,    stay}},
    {"complete", "the mission is complete", Who::board, free,
                                                           {stay,     stay,    stay,    stay,    rest,    stay,    rest,    stay,    stay}},
    {"arrive", "home is reached", Who::board, free,        {stay,     stay,    stay,    stay,    stay,    stay,    rest,    stay,    stay}},
    {"drop", "the mission belongs to another water", Who::board, free,
                                                           {stay,     stay,    stay,    stay,    rest,    rest,    rest,    stay,    stay}},
    {"emerge", "the surface is reached", Who::board, free, {stay,     stay,    stay,    stay,    stay,    stay,    stay,    rest,    stay}},
    {"fail", "the ascent failed", Who::board, free,        {stay,     stay,    stay,    stay,    stay,    stay,    stay,    rest,    stay}},
    {"spend", "the battery is empty, at the surface", Who::board, free,
                                                           {stay,     off,     off,     off,     off,     off,     off,     off,     off}},
    {"revive", "booted under water", Who::board, free,     {up,       stay,    stay,    stay,    stay,    stay,    stay,    stay,    stay}},
    }};
    // clang-format on
}();

constexpr const Rule& rule_of(Order order) { return rules.row[int(order)]; }

/// Whether an order makes the robot safer: any station may give it, or it ends what the robot does.
constexpr bool makes_safer(Order order) {
    return order == Order::rest || order == Order::manual ||
           (order < Order::count && rule_of(order).who == Who::anyone);
}

}  // namespace hypertuna::firmware
