/// The world around a robot: a bench, the plane of still water, or a sea.
#pragma once

#include "hypertuna/host/columns.hpp"
#include "hypertuna/simulation/sea.hpp"

namespace hypertuna {

struct World {
    bool clamped;                    // the head is held still, as on a bench
    std::optional<Sea<double>> sea;  // none: the robot moves in the plane
    std::vector<double> gaps;        // s, pairs: from and until when there are no satellites
};

/// A world from `clamped` (0 or 1), `gaps` (n, 2) and the sea's columns `sea.NAME`; each may be left out.
inline Loaded<World> load_world(const NamedColumns& columns) {
    ColumnReader in(columns);
    World world{in.has("clamped") && in.number("clamped") != 0, {}, {}};
    if (const NamedColumn* gaps = in.find("gaps")) world.gaps = in.numbers("gaps", gaps->rows, 2);
    if (in.has("sea.density")) world.sea = read_sea<double>(in.row("sea", sea_columns).data());
    if (world.clamped && world.sea) in.refuse("clamped: must be 0 at sea");
    return in.loaded(std::move(world));
}

}  // namespace hypertuna
