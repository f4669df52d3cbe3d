/// Bindings of the whole robot, servo to wake.
#include "model.hpp"

namespace hypertuna {

void bind_twin(nb::module_&) {}

}  // namespace hypertuna
