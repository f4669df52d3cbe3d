/// Bindings of pump, lines and servos.
#include "model.hpp"

namespace hypertuna {

void bind_hydraulics(nb::module_&) {}

}  // namespace hypertuna
