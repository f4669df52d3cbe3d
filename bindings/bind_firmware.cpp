/// Bindings of the firmware's tables: what it says of refusals and faults, in the words that it sends.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "app/faults.hpp"
#include "app/refusal.hpp"
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
}

}  // namespace hypertuna
