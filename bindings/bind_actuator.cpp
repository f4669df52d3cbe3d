/// Bindings of muscles and soft joints.
#include "model.hpp"

namespace hypertuna {

void bind_actuator(nb::module_&) {}

}  // namespace hypertuna
