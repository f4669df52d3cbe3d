/// Lock-step: a board whose sensors and servos are simulated by a twin at the other end of two pipes.
///
/// Each tick waits for a request with the sensors' samples and at most one command, and ends with a reply that has the
/// pulses, the vehicle's state, and a digest of all computed numbers. Little-endian, no padding.
#pragma once

#include <algorithm>

#include "app/app.hpp"

namespace hypertuna::firmware {

inline constexpr std::int32_t no_sample = INT32_MIN;

/// Commands of a request, with the arguments `which` and `number`.
enum class OrderKind : std::uint8_t {
    none,
    give,      // which: the order
    gait,      // number: frequency, amplitudes, phases, biases, fins
    sticks,    // number: ahead, turn, climb
    leg,       // which
    origin,    // its place is the fix of the request
    begin,     // mission; number: home, home_radius, home_speed, depth, reserve, duration, surface_every, stay, center,
               // range, start, declination, silence_below
    waypoint,  // number: x, y, depth, speed, radius, hold
    corner,    // number: x, y
    end,       // end of the mission, which is then set
    parameter,  // which, number
};
inline constexpr int order_numbers =
    std::max(16, 3 * max_joints + 3);       // largest number of a mission's numbers, and of a gait's
inline constexpr Station ground{255, 190};  // station that the requests come from

struct ToBoard {
    std::int32_t sample[counted_channels];
    std::int32_t fix[2], accuracy;
    std::uint8_t flags, order, which, satellites;
    float number[order_numbers];
    std::uint8_t missed;             // ticks before this one that the board missed, while its clock ran
    std::uint8_t length, radio[62];  // bytes that the radio received

    static constexpr std::uint8_t fixed = 1, leak = 2, ground = 4, last = 8, stack = 16;
    static constexpr std::uint8_t reset = 32, power = 64;  // the board boots before this tick; without loss of power
};
static_assert(sizeof(ToBoard) == 4 * (counted_channels + 3 + 1 + order_numbers + 16));

struct FromBoard {
    std::uint32_t tick;
    float pulse[max_servos];
    float at[9];  // quaternion, x, y, depth, speed, position error
    std::uint32_t status, reasons, faults;
    std::uint8_t mode, state, answer, refusal, leg, spare[3];
    std::uint32_t digest;
    // The fields below depend on the board.
    std::uint32_t controller, pilot, whole, radio,
        stack;  // counts of the clock; largest number of bytes of stack used so far
};
static_assert(sizeof(FromBoard) == 4 * (1 + max_servos + 9 + 3 + 2 + 1 + 5));

/// A mission received in parts.
struct MissionBuffer {
    Waypoint<float> waypoint[max_waypoints];
    Corner<float> corner[max_corners];
    Mission<float> mission;
};

inline Refusal add(MissionBuffer& buffer, OrderKind kind, const float* number) {
    Mission<float>& m = buffer.mission;
    if (kind == OrderKind::begin) {
        m = {buffer.waypoint,
             0,
             buffer.corner,
             0,
             {number[9], number[10]},
             number[11],
             {number[12], number[13]},
             {number[0], number[1]},
             number[2],
             number[3],
             number[4],
             number[5],
             number[6],
             number[7],
             number[8] != 0.0f,
             number[15] != 0.0f,
             number[14]};
        return Refusal::none;
    }
    if (kind == OrderKind::waypoint) {
        if (m.waypoints == max_waypoints) return Refusal::too_many;
        buffer.waypoint[m.waypoints++] = {number[0], number[1], number[2], number[3], number[4], number[5]};
        return Refusal::none;
    }
    if (m.corners == max_corners) return Refusal::too_many;
    buffer.corner[m.corners++] = {number[0], number[1]};
    return Refusal::none;
}

inline Command<float> command_of(int joints, const float* number) {
    Command<float> command{};
    const float* next = number;
    command.frequency = *next++;
    for (int j = 0; j < joints; ++j) command.amplitude[j] = *next++;
    for (int j = 0; j < joints; ++j) command.phase[j] = *next++;
    for (int j = 0; j < joints; ++j) command.bias[j] = *next++;
    for (int k = 0; k < 2; ++k) command.fin[k] = *next++;
    return command;
}

/// Execute the command of a request.
[[gnu::cold]] inline Refusal execute(Vehicle& vehicle, MissionBuffer& buffer, const ToBoard& request) {
    const float* number = request.number;
    const int joints = vehicle.model.pilot.controller.joints;
    switch (const OrderKind kind = OrderKind(request.order)) {
        case OrderKind::none:
            return Refusal::none;
        case OrderKind::give:
            return give(vehicle, Order(request.which), ground);
        case OrderKind::gait:
            return set_gait(vehicle, ground, command_of(joints, number));
        case OrderKind::sticks:
            return sticks(vehicle, ground, number[0], number[1], number[2]);
        case OrderKind::leg:
            return set_leg(vehicle, ground, request.which);
        case OrderKind::origin:
            return set_origin(vehicle, ground, request.fix[0], request.fix[1]);
        case OrderKind::end:
            return set_mission(vehicle, ground, buffer.mission);
        case OrderKind::parameter:
            return set_parameter(vehicle, ground, request.which, number[0]);
        default:
            return kind <= OrderKind::end ? add(buffer, kind, number) : Refusal::unknown;
    }
}

/// Running digest of 32-bit words (FNV-1a).
struct Digest {
    std::uint32_t value = 2166136261u;

    void add(std::uint32_t word) {
        for (int k = 0; k < 4; ++k) value = (value ^ (word >> 8 * k & 0xff)) * 16777619u;
    }
    void add(const float* numbers, int count) {
        for (int k = 0; k < count; ++k) add(std::bit_cast<std::uint32_t>(numbers[k]));
    }
};

/// Digest of every number of a tick: readings, estimate, command, output.
[[gnu::cold]] inline std::uint32_t digest(const Snapshot& now) {
    Digest sum;
    const Estimate<float>& at = now.estimate;
    const Command<float>& command = now.command;
    const ControllerOutput<float>& out = now.output;
    visit_channels([&](const auto& channel, int) { sum.add(channel.of(now.readings), channel.size); });
    sum.add(&now.readings.accuracy, 1), sum.add(&at.q.w, 4), sum.add(&at.rate.x, 3), sum.add(&at.facing.x, 3),
        sum.add(at.current, 2);
    for (const float* x : {&at.depth, &at.sink, &at.x, &at.y, &at.speed, &at.factor, &at.position_error,
                           &at.drift_error, &at.tilt, &command.frequency, &now.battery_left})
        sum.add(x, 1);
    sum.add(command.amplitude, max_joints), sum.add(command.phase, max_joints), sum.add(command.bias, max_joints);
    sum.add(command.fin, 2), sum.add(out.pulse, max_servos), sum.add(out.target, max_servos);
    sum.add(out.set, max_joints), sum.add(out.pressure, max_circuits);
    for (std::uint16_t where : out.status.at) sum.add(where);
    return sum.value;
}

using FlashMemory = std::uint8_t[flash_sectors * flash_sector];

/// Board in lock-step. `Wire` moves whole blocks and keeps time: read(bytes, count) -> bool, write(bytes, count),
/// log(bytes, count) -> int, clock(), per_tick(), stack(), receive(bytes, count) -> int, send(bytes, count) -> int.
template <class Wire>
struct Lockstep {
    Wire& wire;
    FlashMemory& memory;
    ToBoard request;
    float pulse[max_servos];
    std::uint32_t due = 0, begun = 0;  // clock at the start of the tick: that of the board, that of the wire
    std::uint32_t word = 0;            // survives a reset without loss of power
    bool by_watchdog = false;          // the watchdog caused the last reset

    bool wait() {
        if (!wire.read(&request, sizeof(request))) return false;
        due += (1u + request.missed) * wire.per_tick(), begun = wire.clock();
        return true;
    }
    /// Reset the board: its flash memory stays, and so does the word if the power stayed.
    void reset() {
        by_watchdog = request.flags & ToBoard::power;
        if (!by_watchdog) word = 0xa5a5a5a5;
        for (float& to : pulse) to = 0;
    }
    void read(Raw& raw) {
        const std::int32_t* sample = request.sample;
        visit_channels([&](const auto& channel, int first) {
            if (channel.converter == Converter::none) return;
            for (int k = 0; k < channel.size; ++k, ++sample)
                if (*sample != no_sample) raw.channel[first + k].add(*sample);
        });
        raw.fixed = request.flags & ToBoard::fixed, raw.leak = request.flags & ToBoard::leak;
        for (int k = 0; k < 2; ++k) raw.fix[k] = request.fix[k];
        raw.accuracy = request.accuracy, raw.satellites = request.satellites;
    }
    void drive(const float (&to)[max_servos], int count) {
        for (int k = 0; k < count; ++k) pulse[k] = to[k];
    }
    void feed() {}
    std::uint32_t clock() { return due + (wire.clock() - begun); }
    std::uint32_t per_tick() { return wire.per_tick(); }
    bool watchdog_reset() { return by_watchdog; }
    void keep(std::uint32_t to) { word = to; }
    std::uint32_t kept() { return word; }
    void load(int at, std::uint8_t* to, int count) { std::memcpy(to, memory + at, std::size_t(count)); }
    void program(int at, const std::uint8_t* from, int count) {
        for (int k = 0; k < count; ++k) memory[at + k] &= from[k];
    }
    void erase(int sector) { std::memset(memory + sector * flash_sector, 0xff, flash_sector); }
    bool recovers() { return false; }
    int log(const std::uint8_t* from, int count) { return wire.log(from, count); }
    int receive(std::uint8_t* to, int count) {
        const int sent = request.length, got = sent < count ? sent : count;
        std::memcpy(to, request.radio, std::size_t(got));
        return got + wire.receive(to + got, count - got);
    }
    int send(const std::uint8_t* from, int count) { return wire.send(from, count); }

    void reply(const Vehicle& vehicle, Refusal refusal) {
        const Snapshot& now = vehicle.now;
        const Estimate<float>& at = now.estimate;
        FromBoard out{};
        out.tick = now.tick;
        for (int k = 0; k < max_servos; ++k) out.pulse[k] = pulse[k];
        const float values[9] = {at.q.w, at.q.x, at.q.y, at.q.z, at.x, at.y, at.depth, at.speed, at.position_error};
        for (int k = 0; k < 9; ++k) out.at[k] = values[k];
        out.status = now.output.status.flags, out.reasons = now.reasons.flags, out.faults = now.faults.flags;
        out.mode = std::uint8_t(now.mode), out.state = std::uint8_t(now.state);
        out.answer = std::uint8_t(now.answer), out.refusal = std::uint8_t(refusal), out.leg = std::uint8_t(now.leg);
        out.digest = digest(now);
        out.controller = vehicle.profile.controller, out.pilot = vehicle.profile.pilot;
        out.whole = vehicle.profile.whole, out.radio = vehicle.profile.radio;
        if (request.flags & ToBoard::stack) out.stack = wire.stack();
        wire.write(&out, sizeof(out));
    }
};

/// Run until the twin ends.
template <class Wire>
void run(App& app, MissionBuffer& buffer, Lockstep<Wire>& board, const Description& robot) {
    std::memset(board.memory, 0xff, sizeof(board.memory));
    buffer.mission.waypoint = buffer.waypoint,
    buffer.mission.corner = buffer.corner;  // also for a mission that never begins
    boot(app, robot, board);
    while (board.wait()) {
        if (board.request.flags & ToBoard::reset) {
            board.reset();
            std::memset(static_cast<void*>(&app), 0, sizeof(app));
            boot(app, robot, board);
            board.begun = board.wire.clock();  // the time of the boot counts before this tick
        }
        communicate(app, board);
        if (board.request.flags & ToBoard::ground) on_ground_contact(app.vehicle, ground);
        const Refusal refusal = execute(app.vehicle, buffer, board.request);
        tick(app.vehicle, board);
        board.reply(app.vehicle, refusal);
        if (board.request.flags & ToBoard::last) break;
    }
}

}  // namespace hypertuna::firmware
