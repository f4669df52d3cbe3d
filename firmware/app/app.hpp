/// App: the vehicle and its radio, on a board.
#pragma once

#include "app/radio/radio.hpp"
#include "app/vehicle/tick.hpp"

namespace hypertuna::firmware {

struct App {
    Vehicle vehicle;
    Radio radio;
    std::uint8_t received[256];  // bytes since the last tick: 25 kB/s
};

template <Board B>
void boot(App& app, const Description& robot, B& board) {
    boot(app.vehicle, robot, board);
    boot(app.radio, app.vehicle);
}

/// The radio's part of a tick, before the vehicle's.
template <Board B>
void communicate(App& app, B& board) {
    const std::uint32_t start = board.clock();
    const int count = board.receive(app.received, int(sizeof(app.received)));
    tick(app.radio, app.vehicle, app.received, count);
    Outbox& out = app.radio.out;
    if (0 < out.fill) drop_sent(out, board.send(out.bytes, out.fill));
    app.vehicle.profile.radio = board.clock() - start;
    if (app.radio.restart_at != 0 && app.radio.restart_at == app.vehicle.now.tick) boot(app, *app.vehicle.robot, board);
}

/// One tick of radio and vehicle.
template <Board B>
void tick(App& app, B& board) {
    communicate(app, board);
    tick(app.vehicle, board);
}

}  // namespace hypertuna::firmware
