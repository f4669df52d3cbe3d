/// Bindings of the firmware's tables: refusals, faults, sources of the command, records of the black box.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "app/vehicle/faults.hpp"
#include "app/vehicle/record.hpp"
#include "app/vehicle/refusal.hpp"
#include "model.hpp"

namespace hypertuna {

void bind_firmware(nb::module_& m) {
    m.def(
        "refusal_table",
        [] {
            std::vector<std::pair<std::string, std::string>> rows;
            for (const firmware::RefusalText& text : firmware::refusal_texts)
                rows.emplace_back(text.name, text.sentence);
            return rows;
        },
        "Refusals of the firmware in the order of their numbers: name and sentence.");
    m.def(
        "fault_table",
        [] {
            std::vector<std::tuple<std::string, std::string, std::string, bool, bool>> rows;
            for (const firmware::FaultText& text : firmware::fault_texts)
                rows.emplace_back(text.name, text.sentence, firmware::answer_names[int(text.answer)], text.latched,
                                  text.forbids_arming);
            return rows;
        },
        "Faults that the firmware knows in the order of their bits: name, sentence, answer, whether it is latched "
        "until the robot is armed again, and whether it forbids arming.");
    m.def(
        "record_fields",
        [](int joints) {
            std::vector<std::tuple<std::string, bool, int>> rows;
            const auto add = [&](const char* name, const auto& first, int count = 1) {
                rows.emplace_back(name, !std::is_same_v<std::decay_t<decltype(first)>, std::uint32_t>, count);
            };
            firmware::visit_record(firmware::Snapshot{}, joints, add);
            return rows;
        },
        nb::arg("joints"),
        "Fields of a black box record of a tick, in order: name, whether it is a float, and count. A field with four "
        "names has a byte for each.");
    m.attr("RECORD_MARK") = firmware::record_mark;
    m.attr("RECORD_ROBOT") = int(firmware::Kind::robot);
    m.attr("RECORD_TICK") = int(firmware::Kind::tick);
    m.attr("RECORD_LAYOUT") = firmware::record_layout;
    m.def(
        "control_table",
        [] {
            std::vector<std::pair<std::string, std::string>> rows;
            for (const firmware::ControlText& text : firmware::control_texts)
                rows.emplace_back(text.name, text.sentence);
            return rows;
        },
        "Sources of the controller's command in the order of their numbers: name and sentence.");
}

}  // namespace hypertuna
