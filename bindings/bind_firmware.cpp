/// Bindings of the firmware's tables: what it says of refusals and faults, in the words that it sends.
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
                                  text.forbids);
            return rows;
        },
        "Faults that the firmware knows in the order of their bits: name, sentence, answer, whether it is remembered "
        "until it is armed anew, and whether it forbids arming.");
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
        "Words of the black box's record of a tick in their order: name, whether they are numbers in single precision, "
        "and how many. Four names in one share its bytes.");
    m.attr("RECORD_MARK") = firmware::record_mark;
    m.attr("RECORD_ROBOT") = int(firmware::Kind::robot);
    m.attr("RECORD_TICK") = int(firmware::Kind::tick);
    m.attr("RECORD_LAYOUT") = firmware::record_layout;
    m.def(
        "control_names",
        [] { return std::vector<std::string>(std::begin(firmware::control_names), std::end(firmware::control_names)); },
        "Who makes the command, in the order of their numbers.");
}

}  // namespace hypertuna
