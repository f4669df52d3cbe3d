/// Bindings of the controller on board and of the sensors.
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "controller.hpp"

namespace hypertuna {

static std::vector<std::tuple<std::string, std::string, std::string>> condition_table() {
    static constexpr const char* places[] = {"robot", "joint", "circuit", "servo"};
    std::vector<std::tuple<std::string, std::string, std::string>> rows;
    for (const ConditionText& text : condition_texts)
        rows.emplace_back(text.name, places[int(text.place)], text.sentence);
    return rows;
}

template <std::size_t N>
static void fill(double (&to)[N], const std::vector<double>& from, const char* name, std::size_t wanted) {
    check_extent(name, from.size(), wanted);
    std::copy(from.begin(), from.end(), to);
}

static Readings<double> readings_of(const Row& columns, int joints) {
    PilotReadings<double> readings{};
    read_readings(columns, joints, Reader::controller, readings);
    return readings.robot;
}

static Row columns_of(const Readings<double>& robot, int joints) {
    const PilotReadings<double> readings = without_pilot(robot);
    Row columns;
    visit_channels([&](const auto& channel, int) {
        const double* first = channel.of(readings);
        if (channel.reader == Reader::controller) columns[channel.name] = {first, first + channel.count(joints)};
    });
    return columns;
}

/// A kind of sensor as a row for Python (hypertuna.description.channels.Channel).
using ChannelRow = std::tuple<std::string, std::string, std::string, std::string, std::string, std::string, std::string,
                              bool, int, int>;

static constexpr const char* per_names[] = {"joint", "circuit", "robot"};
static constexpr const char* converter_names[] = {"analog", "digital", "none"};

static std::vector<ChannelRow> channel_rows() {
    std::vector<ChannelRow> rows;
    visit_channels([&](const auto& c, int first) {
        rows.emplace_back(c.name, c.part, c.column, c.unit, c.meaning, per_names[int(c.per)],
                          converter_names[int(c.converter)], c.reader == Reader::pilot, first, c.size);
    });
    return rows;
}

static Command<double> command_of(const Row& columns, int joints, bool fresh, bool armed) {
    Command<double> command{};
    command.frequency = number_at(columns, "frequency", 0);
    const auto take = [&](const char* name, auto& to, std::size_t wanted) {
        const auto column = columns.find(name);
        if (column != columns.end()) fill(to, column->second, name, wanted);
    };
    take("amplitude", command.amplitude, joints), take("phase", command.phase, joints);
    take("bias", command.bias, joints), take("fin", command.fin, 2);
    command.fresh = fresh, command.armed = armed;
    return command;
}

static nb::typed<nb::dict, nb::str, nb::any> output_of(const ControllerOutput<double>& out, int joints) {
    const auto array = [](const double* from, int count) {
        Output to = zeros({std::size_t(count)});
        std::copy(from, from + count, to.data());
        return to;
    };
    nb::typed<nb::dict, nb::str, nb::any> row;
    row["pulse"] = array(out.pulse, servos_of(joints));
    row["target"] = array(out.target, servos_of(joints));
    row["set"] = array(out.set, joints);
    row["pressure"] = array(out.pressure, 2 * joints);
    row["flags"] = out.status.flags;
    row["at"] = std::vector<int>(out.status.at, out.status.at + conditions);
    return row;
}

static Row sense_row(LiveSensors& senses, const Row& truth, const std::vector<FaultRow>& rows) {
    const std::vector<Fault<double>> faults = read_faults(rows);
    const Readings<double> truths = readings_of(truth, senses.model.joints);
    const double time = double(senses.state.count) * senses.tick;
    const auto sensed = sense(senses.model, senses.state, truths, faults.data(), int(faults.size()), time);
    senses.state = sensed.state;
    return columns_of(sensed.readings, senses.model.joints);
}

void bind_control(nb::module_& m) {
    m.attr("MAX_JOINTS") = max_joints;
    m.attr("MAX_COORDINATES") = max_coordinates;
    m.attr("MAX_SERVOS") = max_servos;
    m.def(
        "fault_kinds", [] { return std::vector<std::string>(std::begin(fault_kinds), std::end(fault_kinds)); },
        "Kinds of sensor faults, none first.");
    m.def(
        "channel_table", &channel_rows,
        "Kinds of sensors in the order of their channels: name, part that fails as one, column of logs, unit, meaning, "
        "what has one (joint, circuit, robot), converter (analog, digital, none), whether only the pilot reads it, "
        "first channel, channels reserved.");
    m.def("condition_table", &condition_table,
          "Conditions of the controller's status in the order of its bits: name, what a bit of its place stands for "
          "(robot, joint, circuit, servo), sentence.");
    nb::class_<LiveController>(m, "LiveController", "The controller on board with its state, in double precision.")
        .def(
            "__init__",
            [](LiveController* self, const Mapping& columns) {
                const Controller<double> model = take(load_controller(MappedColumns(columns).columns));
                new (self) LiveController{model, init(model)};
            },
            nb::arg("columns"), "At rest, from the columns of hypertuna.control.controller_columns.")
        .def(
            "step",
            [](LiveController& self, const Row& readings, const Row& command, bool fresh, bool armed) {
                const int joints = self.model.joints;
                const auto next = step(self.model, self.state, readings_of(readings, joints),
                                       command_of(command, joints, fresh, armed));
                self.state = next.state;
                return output_of(next.output, joints);
            },
            nb::arg("readings"), nb::arg("command"), nb::kw_only(), nb::arg("fresh") = true, nb::arg("armed") = true,
            "One tick: servo pulses [s], their angles [rad], bends set [rad], valid pressures [Pa], and the "
            "status: "
            "flags with one bit per condition, and where it holds.");
    nb::class_<LiveSensors>(m, "Sensors", "The sensors of a robot with what they get wrong.")
        .def(
            "__init__",
            [](LiveSensors* self, const Mapping& mapping, std::uint64_t seed) {
                const MappedColumns mapped(mapping);
                const Sensors<double> model = take(load_sensors(mapped.columns, seed));
                new (self) LiveSensors{model, {}, ColumnReader(mapped.columns).number("tick")};
            },
            nb::arg("columns"), nb::arg("seed"), "From the columns of hypertuna.sensing.sensor_columns.")
        .def("read", &sense_row, nb::arg("truth"), nb::arg("faults") = std::vector<FaultRow>(),
             "Readings of a tick for the true values; faults as (kind, first channel, last channel, start, end) [s].");
}

}  // namespace hypertuna
