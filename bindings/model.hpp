/// Shared parts of the bindings: models, arrays, and one function for each part of the module.
#pragma once

#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "hypertuna/host/kernels.hpp"

namespace hypertuna {

/// The kernel in use: the one that HYPERTUNA_ISA names, else the fastest.
const Kernel& kernel();

void bind_model(nb::module_& m);
void bind_settle(nb::module_& m);
void bind_swimmer(nb::module_& m);
void bind_actuation(nb::module_& m);
void bind_control(nb::module_& m);
void bind_pilot(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_batch(nb::module_& m);
void bind_firmware(nb::module_& m);
void bind_film(nb::module_& m);

}  // namespace hypertuna
