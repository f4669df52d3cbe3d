/// App: the vehicle and its radio, on a board.
#pragma once

#include "app/radio/radio.hpp"
#include "app/vehicle/tick.hpp"

namespace hypertuna::firmware {

struct App {
    Vehicle vehicle;
    Link link;
    std::uint8_t heard[256];  // bytes of the radio since the last tick: 25 kB/s
};

template <Board B>
void boot(App& app, const Description& robot, B& board) {
    boot(app.vehicle, robot, board);
    begin_radio(app.link, app.vehicle);
}

/// Take in what the radio brought, before the vehicle's tick.
template <Board B>
void listen(App& app, B& board) {
    const std::uint32_t start = board.clock();
    const int count = board.receive(app.heard, int(sizeof(app.heard)));
    work_radio(app.link, app.vehicle, app.heard, count);
    Outbox& out = app.link.out;
    if (0 < out.fill) taken(out, board.send(out.bytes, out.fill));
    app.vehicle.profile.link = board.clock() - start;
}

/// One tick of all.
template <Board B>
void tick(App& app, B& board) {
    listen(app, board);
    tick(app.vehicle, board);
}

}  // namespace hypertuna::firmware
