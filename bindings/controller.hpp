/// Controller, sensors and pilot with their states: tests and users advance them tick by tick.
#pragma once

#include <nanobind/stl/map.h>
#include <nanobind/stl/tuple.h>

#include <map>
#include <tuple>

#include "hypertuna/host/controller.hpp"
#include "model.hpp"

namespace hypertuna {

struct LiveController {
    Controller<double> model;
    ControllerState<double> state;
};

struct LiveSensors {
    Sensors<double> model;
    SensorsState<double> state;
    double tick;  // s
};

struct LivePilot {
    Pilot<double> model;
    MissionData mission;
    PilotState<double> state;
};

using FaultRow = std::tuple<std::string, int, int, double, double>;  // kind, first and last channel, start and end [s]

inline std::vector<Fault<double>> read_faults(const std::vector<FaultRow>& rows) {
    std::vector<Fault<double>> faults;
    for (const auto& [name, first, last, start, end] : rows) {
        const auto kind = std::ranges::find(fault_kinds, name);
        if (kind == std::end(fault_kinds)) throw nb::value_error(("faults: no such kind: " + name).c_str());
        faults.push_back({FaultKind(kind - fault_kinds), first, last, start, end});
    }
    return faults;
}

/// Rows of readings and commands by name, one tick at a time.
using Row = std::map<std::string, std::vector<double>>;

/// One number of a row.
inline double number_at(const Row& row, const std::string& name, std::size_t index) {
    const auto column = row.find(name);
    if (column == row.end()) throw nb::value_error(("columns: lacks " + name).c_str());
    if (column->second.size() <= index) check_extent(name.c_str(), column->second.size(), index + 1);
    return column->second[index];
}

/// Readings by the names of the channels.
inline void read_readings(const Row& columns, int joints, Reader last, PilotReadings<double>& readings) {
    visit_channels([&](const auto& channel, int) {
        if (channel.reader > last || channel.converter == Converter::none) return;
        const auto column = columns.find(channel.name);
        if (column == columns.end()) throw nb::value_error((std::string("readings: lacks ") + channel.name).c_str());
        check_extent(channel.name, column->second.size(), std::size_t(channel.count(joints)));
        std::copy(column->second.begin(), column->second.end(), channel.of(readings));
    });
}

}  // namespace hypertuna
