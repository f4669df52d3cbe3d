/// Bindings of many twins at once.
#include <nanobind/stl/tuple.h>

#include "hypertuna/host/batch.hpp"
#include "records.hpp"

namespace hypertuna {

/// Plant, command, world, sensors, faults and twist (6) of a run.
using BatchRow =
    std::tuple<const PlantData*, const GaitCommand*, const World*, const LiveSensors*, std::vector<FaultRow>, Input<1>>;

static std::vector<NamedArrays> simulate_batch(const std::vector<BatchRow>& rows, std::size_t ticks, int steps,
                                               std::size_t every) {
    std::vector<BatchMember> members;
    std::vector<const GaitCommand*> commands;
    for (const auto& [plant, command, world, sensors, faults, twist] : rows) {
        check_extent("twist", twist.shape(0), twist_numbers);
        if (world->sea) throw nb::value_error("world: a batch moves in the plane");
        members.push_back({plant,
                           world->clamped,
                           command->controller,
                           {sensors->model, read_faults(faults)},
                           read_twist(twist.data())});
        commands.push_back(command);
    }
    check(check_batch(members));
    if (every < 1 || steps < 1) throw nb::value_error("every, steps: must be one or more");
    const Run run{ticks, every, members[0].controller.tick, steps, {}, {}, 0};
    std::vector<Record> records;
    {
        const nb::gil_scoped_release unlocked;
        records = simulate(*kernel().machines, std::move(members), commands, run);
    }
    std::vector<NamedArrays> out;
    for (Record& record : records) out.push_back(arrays_of(std::move(record)));
    return out;
}

void bind_batch(nb::module_& m) {
    m.def("simulate_batch", &simulate_batch, nb::arg("runs"), nb::kw_only(), nb::arg("ticks"), nb::arg("steps"),
          nb::arg("every") = 1,
          "Run twins in the plane side by side: (plant, command, world, sensors, faults, twist (6)) each, of robots of "
          "the same structure. Records as `simulate` gives them, to the same bits.");
    m.def("twin_lanes", [] { return kernel().machines->lanes; }, "Twins that one instruction serves.");
}

}  // namespace hypertuna
