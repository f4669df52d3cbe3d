/// Bindings of the firmware's tables: refusals, faults, states and orders, records of the black box.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "app/vehicle/faults.hpp"
#include "app/vehicle/record.hpp"
#include "app/vehicle/states.hpp"
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
            std::vector<std::tuple<std::string, std::string, std::string, bool, bool, std::string, std::string>> rows;
            firmware::Limits limits{};
            for (const firmware::FaultText& text : firmware::fault_texts) {
                std::string choice;
                firmware::visit_fields(limits, [&](const char* name, int, const float& field) {
                    if (text.choice != nullptr && &field == &(limits.*text.choice)) choice = name;
                });
                rows.emplace_back(text.name, text.sentence, firmware::answer_names[int(text.answer)], text.latched,
                                  text.forbids_arming, firmware::severity_name(text.severity), choice);
            }
            return rows;
        },
        "Faults that the firmware knows in the order of their bits: name, sentence, answer, whether it is latched "
        "until the robot is armed again, whether it forbids arming, its severity, and the parameter that may choose "
        "another answer.");
    m.def(
        "answer_table",
        [] {
            return std::vector<std::string>(firmware::answer_names,
                                            firmware::answer_names + int(firmware::max_choice) + 1);
        },
        "Answers to a fault that a parameter may choose, in the order of their numbers.");
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
    m.attr("BOARD_JOINTS") = board_joints;
    m.attr("BOARD_SERVOS") = servos_of(board_joints);
    m.attr("MAX_PARAMETERS") = firmware::max_parameters;
    m.attr("RECORD_MARK") = firmware::record_mark;
    m.attr("RECORD_ROBOT") = int(firmware::Kind::robot);
    m.attr("RECORD_TICK") = int(firmware::Kind::tick);
    m.attr("RECORD_LAYOUT") = firmware::record_layout;
    m.def(
        "state_table",
        [] {
            std::vector<std::tuple<std::string, std::string, std::string>> rows;
            for (const firmware::StateText& text : firmware::state_texts)
                rows.emplace_back(text.name, text.sentence,
                                  text.order == firmware::Order::count ? "" : firmware::rule_of(text.order).name);
            return rows;
        },
        "States of the robot in the order of their numbers: name, sentence, and the order that selects it as a mode.");
    m.def(
        "order_table",
        [] {
            std::vector<
                std::tuple<std::string, std::string, std::string, std::vector<std::string>, std::vector<std::string>>>
                rows;
            for (const firmware::Rule& rule : firmware::rules.row) {
                std::vector<std::string> needs, cells;
                for (int k = 0; k < int(firmware::Need::count); ++k)
                    if (rule.needs >> k & 1) needs.emplace_back(firmware::need_texts[k].name);
                for (const firmware::Cell& cell : rule.next)
                    cells.emplace_back(cell.refusal != firmware::Refusal::none
                                           ? std::string("!") + firmware::refusal_texts[int(cell.refusal)].name
                                       : cell.back      ? "back"
                                       : cell.changes() ? firmware::state_texts[int(cell.next)].name
                                                        : "");
                rows.emplace_back(rule.name, rule.sentence, firmware::who_names[int(rule.who)], needs, cells);
            }
            return rows;
        },
        "Orders and events of the firmware: name, sentence, who gives it, what must hold, and for each state the next "
        "one, an empty string where it does not change, `back` for the one before, or `!` and the refusal.");
    m.def(
        "need_table",
        [] {
            std::vector<std::pair<std::string, std::string>> rows;
            for (const firmware::NeedText& text : firmware::need_texts) rows.emplace_back(text.name, text.sentence);
            return rows;
        },
        "What must hold for an order to change the state: name and sentence.");
    m.attr("MODE_BASE") = firmware::mode_base;
}

}  // namespace hypertuna
