/// Bindings of the controller on board.
#include "model.hpp"

namespace hypertuna {

void bind_controller(nb::module_&) {}

}  // namespace hypertuna
