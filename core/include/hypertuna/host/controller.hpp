/// Load what runs on board from columns: controller, sensors with their errors, pilot and mission.
#pragma once

#include "hypertuna/host/columns.hpp"
#include "hypertuna/pilot/pilot.hpp"
#include "hypertuna/simulation/sensors.hpp"

namespace hypertuna {

/// Fill every number that the part's visit_fields names.
template <class Part>
void read_fields(ColumnReader& in, Part& part) {
    visit_fields(part, [&](const char* name, int index, auto& field) {
        field = std::remove_reference_t<decltype(field)>(in.number(name, std::size_t(index)));
    });
}

inline Loaded<Controller<double>> load_controller(const NamedColumns& columns) {
    ColumnReader in(columns);
    Controller<double> controller{};
    controller.joints = in.whole("joints", 1, max_joints);
    read_fields(in, controller);
    return in.loaded(std::move(controller));
}

/// Load the models of the sensors from `joints`, `tick` and `SENSOR.NAME`; those of the pilot, too, where there is
/// `fix_every`.
inline Loaded<Sensors<double>> load_sensors(const NamedColumns& columns, std::uint64_t seed) {
    ColumnReader in(columns);
    Sensors<double> sensors{};
    sensors.joints = in.whole("joints", 1, max_joints);
    sensors.root_tick = std::sqrt(in.number("tick"));
    sensors.seed = seed;
    const auto read = [&](const char* sensor, const char* name, double& field) {
        field = in.number(std::string(sensor) + "." + name);
    };
    visit_fields(sensors, Reader::controller, read);
    sensors.fix_every = 1;
    if (in.has("fix_every")) {
        visit_fields(sensors, Reader::pilot, read);
        sensors.fix_every = in.whole("fix_every", 1, 1 << 30);
    }
    return in.loaded(std::move(sensors));
}

/// Load a pilot from its columns, around a controller.
inline Loaded<Pilot<double>> load_pilot(const Controller<double>& controller, const NamedColumns& columns) {
    ColumnReader in(columns);
    Pilot<double> pilot{};
    pilot.controller = controller;
    Steering<double>& steering = pilot.guidance.steering;
    steering.joints = controller.joints;
    steering.table.gaits = in.whole("gaits", 1, max_gaits);
    read_fields(in, pilot);
    return in.loaded(std::move(pilot));
}

/// A mission that owns its waypoints and its fence.
struct MissionData {
    std::vector<Waypoint<double>> waypoint;
    std::vector<Corner<double>> corner;
    Mission<double> mission;

    MissionData() : mission{} {}
    MissionData(MissionData&&) = default;
    MissionData(const MissionData&) = delete;  // the mission points at both vectors
};

/// Load a mission from `waypoints` (n, 5: x, y, depth, speed, radius), `hold` (n), `fence` (n, 2: x, y) and its other
/// numbers by name.
inline Loaded<MissionData> load_mission(const NamedColumns& columns) {
    ColumnReader in(columns);
    MissionData data;
    const auto rows = [&](const char* name, std::size_t width) {
        const NamedColumn* const column = in.find(name);
        return in.numbers(name, column ? column->rows : 0, width);
    };
    const std::vector<double> way = rows("waypoints", 5), fence = rows("fence", 2);
    const std::vector<double> hold = in.numbers("hold", way.size() / 5);
    for (std::size_t k = 0; k + 5 <= way.size(); k += 5)
        data.waypoint.push_back({way[k], way[k + 1], way[k + 2], way[k + 3], way[k + 4], hold[k / 5]});
    for (std::size_t k = 0; k + 2 <= fence.size(); k += 2) data.corner.push_back({fence[k], fence[k + 1]});
    Mission<double>& mission = data.mission;
    mission.waypoint = data.waypoint.data(), mission.waypoints = int(data.waypoint.size());
    mission.corner = data.corner.data(), mission.corners = int(data.corner.size());
    read_fields(in, mission);
    return in.loaded(std::move(data));
}

}  // namespace hypertuna
