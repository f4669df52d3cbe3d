#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "hypertuna/host/directions.hpp"
#include "model.hpp"

namespace hypertuna {

static std::vector<std::string> parameter_names(const Model& model) {
    std::vector<std::string> names;
    for (const auto& [name, count, single] : parameter_columns(model))
        for (int k = 0; k < count; ++k)
            names.push_back(single ? name : std::string(name) + "[" + std::to_string(k) + "]");
    return names;
}

/// Name of a water law, and of each of its columns the name, the unit and whether it has one value per link.
using WaterLaw = std::pair<std::string, std::vector<std::tuple<std::string, std::string, bool>>>;

/// Columns of every water law, in the order of WaterLaws.
static std::vector<WaterLaw> water_laws() {
    std::vector<WaterLaw> laws;
    WaterLaws::each<double>([&](auto law) {
        using Law = typename decltype(law)::type;
        auto& [name, columns] = laws.emplace_back(Law::name, 0);
        for (const WaterColumn& column : Law::columns) columns.emplace_back(column.name, column.unit, column.per_link);
    });
    return laws;
}

void bind_model(nb::module_& m) {
    nb::set_leak_warnings(false);  // a robot that is alive at exit keeps its model
    m.attr("IMAGE_VERSION") = image_version;
    m.def("water_laws", &water_laws,
          "The water laws, each with the columns of its coefficients: name, unit, whether one value per link.");
    nb::class_<Model>(m, "Model", "A robot in its water, ready for the core. Immutable.")
        .def(
            "__init__",
            [](Model* self, const std::string& law, const Mapping& columns) {
                new (self) Model(take(load_model(law, MappedColumns(columns).columns)));
            },
            nb::arg("law"), nb::arg("columns"),
            "From `body_length` [m], `joint_group` and `joint_share` (links: joint i is at the front of link i, its "
            "group is -1 where it is rigid), the law's flags (0 or 1), and the parameters after the gait's, by the "
            "names of `parameter_names`; there are as many groups as bandwidths.")
        .def_ro("links", &Model::links, "Number of links.")
        .def_ro("groups", &Model::groups, "Number of joint groups.")
        .def("parameter_names", &parameter_names,
             "Names of all parameters in the order of the derivatives: the gait's, the joints', the links', the "
             "water's.");
}

}  // namespace hypertuna
