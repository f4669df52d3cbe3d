/// The controller and the sensors as Python hands them over: named columns, in the order of core visit_fields.
#pragma once

#include <cmath>
#include <stdexcept>

#include "hypertuna/simulation/sensors.hpp"
#include "model.hpp"

namespace hypertuna {

using NamedColumns = std::map<std::string, std::vector<double>>;

/// One number of the columns.
inline double column_at(const NamedColumns& columns, const std::string& name, std::size_t index) {
    const auto found = columns.find(name);
    if (found == columns.end()) throw nb::value_error(("columns: lacks " + name).c_str());
    if (found->second.size() <= index) check_extent(name.c_str(), found->second.size(), index + 1);
    return found->second[index];
}

template <class T>
Controller<T> read_controller(const NamedColumns& columns) {
    Controller<T> model{};
    const double joints = column_at(columns, "joints", 0);
    if (!(joints >= 1 && joints <= most_joints)) throw nb::value_error("columns: joints must be from 1 to 4");
    model.joints = int(joints);
    visit_fields(model, [&](const char* name, int index, auto& field) {
        field = std::remove_reference_t<decltype(field)>(column_at(columns, name, std::size_t(index)));
    });
    return model;
}

/// Kinds of faults by the names of the command line, in the order of FaultKind.
inline std::vector<std::string> fault_kinds() { return {"none", "stuck", "open", "spike", "nan"}; }
inline FaultKind fault_kind(const std::string& name) {
    const std::vector<std::string> kinds = fault_kinds();
    const auto found = std::find(kinds.begin(), kinds.end(), name);
    if (found == kinds.end()) throw nb::value_error(("faults: no such kind: " + name).c_str());
    return FaultKind(found - kinds.begin());
}

/// The models of the sensors that the controller reads, or also of those that only the pilot reads.
template <class T>
Sensors<T> read_sensors(const NamedColumns& columns, std::uint64_t seed, Reader last = Reader::controller) {
    Sensors<T> sensors{};
    sensors.joints = int(column_at(columns, "joints", 0));
    sensors.root_tick = T(std::sqrt(column_at(columns, "tick", 0)));
    sensors.seed = seed;
    const auto fill = [&](const char* sensor, const char* name, T& field) {
        field = T(column_at(columns, std::string(sensor) + "." + name, 0));
    };
    visit_fields(sensors, Reader::controller, fill);
    if (last == Reader::pilot) {
        visit_fields(sensors, Reader::pilot, fill);
        sensors.fix_every = int(column_at(columns, "fix_every", 0));
    }
    return sensors;
}

/// Readings by the names of the channels.
inline void read_readings(const NamedColumns& columns, int joints, Reader last, PilotReadings<double>& readings) {
    visit_channels([&](const auto& channel, int) {
        if (channel.reader > last || channel.converter == Converter::none) return;
        const auto found = columns.find(channel.name);
        if (found == columns.end()) throw nb::value_error((std::string("readings: lacks ") + channel.name).c_str());
        check_extent(channel.name, found->second.size(), std::size_t(channel.count(joints)));
        std::copy(found->second.begin(), found->second.end(), channel.of(readings));
    });
}

}  // namespace hypertuna
