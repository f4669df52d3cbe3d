/// App: the vehicle and its radio, on a board.
#pragma once

#include "link.hpp"
#include "tick.hpp"

namespace hypertuna::firmware {

struct App {
    Vehicle vehicle;
    Link link;
};

template <Board B>
void boot(App& app, const Description& robot, B& board) {
    boot(app.vehicle, robot, board);
    boot(app.link, app.vehicle);
}

/// Take in what the radio brought, before the vehicle's tick.
template <Board B>
void listen(App& app, B& board) {
    std::uint8_t bytes[most_bytes] = {};
    const int count = board.receive(bytes, most_bytes);
    tick(app.link, app.vehicle, bytes, count);
    Outbox& out = app.link.out;
    if (0 < out.fill) taken(out, board.send(out.bytes, out.fill));
}

/// One tick of all.
template <Board B>
void tick(App& app, B& board) {
    listen(app, board);
    tick(app.vehicle, board);
}

}  // namespace hypertuna::firmware
