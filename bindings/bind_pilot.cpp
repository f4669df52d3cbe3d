/// Bindings of the pilot on board.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <span>

#include "app/vehicle/parameters.hpp"
#include "controller.hpp"

namespace hypertuna {

using PilotRow = nb::typed<nb::dict, nb::str, nb::any>;

static PilotReadings<double> pilot_readings(const Row& columns, int joints) {
    PilotReadings<double> r{};
    read_readings(columns, joints, Reader::pilot, r);
    r.fixed = columns.count("fix") != 0;
    for (int k = 0; r.fixed && k < 2; ++k) r.fix[k] = number_at(columns, "fix", std::size_t(k));
    if (columns.count("accuracy") != 0) r.accuracy = number_at(columns, "accuracy", 0);
    return r;
}

static PilotRow pilot_row(const PilotStep<double>& step, int joints) {
    const auto list = [](const double* from, int count) { return std::vector<double>(from, from + count); };
    const Estimate<double>& at = step.estimate;
    PilotRow row;
    row["pulse"] = list(step.output.pulse, servos_of(joints));
    row["target"] = list(step.output.target, servos_of(joints));
    row["frequency"] = step.command.frequency;
    row["amplitude"] = list(step.command.amplitude, joints);
    row["bias"] = list(step.command.bias, joints);
    row["fin"] = list(step.command.fin, 2);
    row["quaternion"] = list(&at.q.w, 4);
    row["facing"] = list(&at.facing.x, 3);
    row["depth"] = at.depth, row["sink"] = at.sink, row["x"] = at.x, row["y"] = at.y;
    row["speed"] = at.speed, row["current"] = list(at.current, 2), row["position_error"] = at.position_error;
    row["mode"] = mode_texts[int(step.mode)].name;
    std::vector<std::string> why;
    for (int r = 0; r < reasons; ++r)
        if (step.reasons.has(Reason(r))) why.push_back(reason_texts[r].name);
    row["reasons"] = why;
    row["flags"] = step.output.status.flags;
    return row;
}

void bind_pilot(nb::module_& m) {
    m.attr("MAX_GAITS") = max_gaits;
    const auto table = [&m](const char* name, std::span<const NamedText> texts, const char* meaning) {
        m.def(
            name,
            [texts] {
                std::vector<std::pair<std::string, std::string>> rows;
                for (const NamedText& text : texts) rows.emplace_back(text.name, text.sentence);
                return rows;
            },
            meaning);
    };
    table("mode_table", mode_texts, "Modes of the pilot in the order of their numbers: name and sentence.");
    table("reason_table", reason_texts, "Reasons of the pilot in the order of their bits: name and sentence.");
    table("ending_table", ending_texts, "Ends of a flight in the order of their numbers: name and sentence.");
    m.def(
        "ending", [](int mode, std::uint32_t reasons) { return int(ending_of(Mode(mode), Reasons{reasons})); },
        nb::arg("mode"), nb::arg("reasons"), "How a flight ends in a mode of the pilot: place in `ending_table`.");
    m.def(
        "onboard_fields",
        [](int joints, int gaits) {
            Pilot<float> pilot{};
            pilot.controller.joints = pilot.guidance.steering.joints = joints;
            pilot.guidance.steering.table.gaits = gaits;
            std::vector<std::tuple<std::string, std::string, int>> fields;
            const auto list = [&](const char* part, auto& model) {
                visit_fields(model, [&](const char* name, int k, auto&) { fields.emplace_back(part, name, k); });
            };
            Mission<float> mission{};
            firmware::Limits limits{};
            list("controller", pilot.controller), list("pilot", pilot), list("mission", mission),
                list("limits", limits);
            return fields;
        },
        nb::arg("joints"), nb::arg("gaits"),
        "Every number of controller, pilot, mission and limits in the order that core and firmware take them in: part, "
        "column, index.");
    nb::class_<LivePilot>(m, "Pilot", "The pilot on board with its mission and state, in double precision.")
        .def(
            "__init__",
            [](LivePilot* self, const LiveController& controller, const Mapping& columns, const Mapping& mission) {
                const Pilot<double> model = take(load_pilot(controller.model, MappedColumns(columns).columns));
                MissionData data = take(load_mission(MappedColumns(mission).columns));
                const PilotState<double> state = init(model, data.mission);
                new (self) LivePilot{model, std::move(data), state};
            },
            nb::arg("controller"), nb::arg("columns"), nb::arg("mission"),
            "At the start of a mission, from the columns of hypertuna.control.guidance.")
        .def(
            "fly",
            [](LivePilot& self, const Row& readings) {
                const int joints = self.model.controller.joints;
                const auto next = fly(self.model, self.state, pilot_readings(readings, joints), self.mission.mission);
                self.state = next.state;
                return pilot_row(next, joints);
            },
            nb::arg("readings"),
            "One tick: pulses [s], command, estimate, mode and reasons. Readings have `fix` where one came, and may "
            "have\n"
            "its `accuracy` [m].");
}

}  // namespace hypertuna
