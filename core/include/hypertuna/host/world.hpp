/// The world around a robot: a bench, the plane of still water, or a sea with its weather and satellites.
#pragma once

#include "hypertuna/host/columns.hpp"
#include "hypertuna/simulation/receiver.hpp"

namespace hypertuna {

struct World {
    bool clamped = false;            // the head is held still, as on a bench
    std::optional<Sea<double>> sea;  // empty: the robot moves in the plane
    Weather<double> weather{{0, 0}, 1, {0, 0}, 1, 1};
    Receiver<double> receiver{};
    std::vector<double> gaps;    // s, pairs: start and end of times without satellites
    std::vector<double> resets;  // s: s: times at which robot and receiver lose power for an instant power for an
                                 // instant, and its receiver, too
    std::vector<double> snags;   // s, s, m, triples: start, end and length of a line that holds the nose
    double released = 0;         // s until which the robot is held at its start
};

/// Load a world from `clamped` (0 or 1), `gaps` (n, 2), `resets` (n), `snags` (n, 3), `released`, the sea's columns
/// `sea.NAME`, `weather.NAME` and `receiver.NAME`; each may be left out.
inline Loaded<World> load_world(const NamedColumns& columns) {
    ColumnReader in(columns);
    World world{};
    world.clamped = in.has("clamped") && in.number("clamped") != 0;
    if (const NamedColumn* gaps = in.find("gaps")) world.gaps = in.numbers("gaps", gaps->rows, 2);
    if (const NamedColumn* resets = in.find("resets")) world.resets = in.numbers("resets", resets->rows);
    if (const NamedColumn* snags = in.find("snags")) world.snags = in.numbers("snags", snags->rows, 3);
    if (in.has("released")) world.released = in.number("released");
    if (in.has("sea.density")) world.sea = read_sea<double>(in.row("sea", sea_columns).data());
    if (in.has("weather.tide_east")) world.weather = read_weather(in.row("weather", weather_columns).data());
    if (in.has("receiver.cold")) world.receiver = read_receiver(in.row("receiver", receiver_columns).data());
    if (!(0 < world.weather.tide_period && 0 < world.weather.gust_time && 0 < world.weather.gust_depth))
        in.refuse("weather.tide_period, weather.gust_time and weather.gust_depth: must be positive");
    if (world.clamped && world.sea) in.refuse("clamped: must be 0 at sea");
    return in.loaded(std::move(world));
}

}  // namespace hypertuna
