/// The pilot and its mission as Python hands them over: named columns, in the order of core visit_fields.
#pragma once

#include "controller.hpp"
#include "hypertuna/pilot/pilot.hpp"

namespace hypertuna {

template <class T>
Pilot<T> read_pilot(const NamedColumns& controller, const NamedColumns& columns) {
    Pilot<T> pilot{};
    pilot.controller = read_controller<T>(controller);
    Steering<T>& steering = pilot.guidance.steering;
    steering.joints = pilot.controller.joints;
    const double gaits = column_at(columns, "gaits", 0);
    if (!(gaits >= 1 && gaits <= most_gaits)) throw nb::value_error("columns: gaits must be from 1 to 12");
    steering.table.gaits = int(gaits);
    visit_fields(pilot, [&](const char* name, int index, auto& field) {
        field = std::remove_reference_t<decltype(field)>(column_at(columns, name, std::size_t(index)));
    });
    return pilot;
}

/// A mission that owns its waypoints and its fence.
template <class T>
struct OwnedMission {
    std::vector<Waypoint<T>> waypoints;
    std::vector<Corner<T>> fence;
    Mission<T> mission{};

    /// Rows of waypoints are x, y, depth, speed, radius; of the fence x, y.
    OwnedMission(const NamedColumns& columns, const Input<2>& way, const Input<2>& corners) {
        check_extent("waypoints", way.shape(1), 5);
        check_extent("fence", corners.shape(1), 2);
        for (std::size_t k = 0; k < way.shape(0); ++k) {
            const double* row = way.data() + 5 * k;
            waypoints.push_back({T(row[0]), T(row[1]), T(row[2]), T(row[3]), T(row[4])});
        }
        for (std::size_t k = 0; k < corners.shape(0); ++k)
            fence.push_back({T(corners.data()[2 * k]), T(corners.data()[2 * k + 1])});
        const auto at = [&](const char* name, std::size_t index = 0) { return T(column_at(columns, name, index)); };
        mission.waypoint = waypoints.data(), mission.waypoints = int(waypoints.size());
        mission.corner = fence.data(), mission.corners = int(fence.size());
        mission.start = {at("start"), at("start", 1)}, mission.home = {at("home"), at("home", 1)};
        mission.home_radius = at("home_radius"), mission.home_speed = at("home_speed");
        mission.depth_most = at("depth_most"), mission.reserve = at("reserve"), mission.duration = at("duration");
        mission.surface_every = at("surface_every"), mission.stay = at("stay") != T(0);
    }
    OwnedMission(const OwnedMission&) = delete;
    OwnedMission& operator=(const OwnedMission&) = delete;
};

}  // namespace hypertuna
