/// The model as Python hands it over: named columns, laid out in the order of core parameters.hpp.
#pragma once

#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "kernels.hpp"

namespace hypertuna {

/// One named parameter column: as many numbers as there are links, groups, or one.
struct ParameterColumn {
    const char* name;
    enum class Extent { one, groups, links } extent;
};

/// The columns in the order of core parameters.hpp, gait first.
std::vector<ParameterColumn> parameter_columns(const Model& model);

void bind_model(nb::module_& m);
void bind_settle(nb::module_& m);
void bind_swimmer(nb::module_& m);
void bind_actuation(nb::module_& m);
void bind_control(nb::module_& m);
void bind_pilot(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_firmware(nb::module_& m);

}  // namespace hypertuna
