#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "hypertuna/swimming/parameters.hpp"
#include "model.hpp"

namespace hypertuna {

std::vector<ParameterColumn> parameter_columns(const Model& model) {
    using enum ParameterColumn::Extent;
    std::vector<ParameterColumn> columns = {{"frequency", one}, {"amplitude", groups}, {"phase", groups},
                                            {"bias", groups},   {"bandwidth", groups}, {"phase_offset", groups},
                                            {"length", links},  {"com", links},        {"mass", links},
                                            {"inertia", links}, {"density", one}};
    with_law<double>(model.law, [&](auto law) {
        for (const WaterColumn& column : decltype(law)::type::columns)
            columns.push_back({column.name, column.per_link ? links : one});
    });
    return columns;
}

static int extent(const Model& model, const ParameterColumn& column) {
    switch (column.extent) {
        case ParameterColumn::Extent::groups:
            return model.groups;
        case ParameterColumn::Extent::links:
            return model.links;
        default:
            return 1;
    }
}

int parameter_count(const Model& model) {
    int count = 0;
    for (const ParameterColumn& column : parameter_columns(model)) count += extent(model, column);
    return count;
}

/// Columns that belong to a gait, not to the robot, and stand first.
static constexpr int gait_columns = 4;

/// Place of a law in WaterLaws, and the bits of its flags that are set.
static std::pair<int, unsigned> find_law(const std::string& name, const std::map<std::string, bool>& flags) {
    int place = -1, k = 0;
    unsigned bits = 0;
    std::string known;
    WaterLaws::each<double>([&](auto law) {
        using Law = typename decltype(law)::type;
        known += std::string(k ? ", " : "") + Law::name;
        if (name == Law::name) {
            place = k;
            for (int f = 0; Law::flags[f]; ++f)
                if (const auto flag = flags.find(Law::flags[f]); flag != flags.end() && flag->second) bits |= 1u << f;
        }
        ++k;
    });
    if (place < 0) throw nb::value_error(("law must be one of " + known).c_str());
    return {place, bits};
}

static Model make_model(const std::string& law, const std::map<std::string, bool>& flags, double length,
                        std::vector<int> joint_group, std::vector<double> joint_share,
                        const std::map<std::string, std::vector<double>>& columns) {
    const auto [place, bits] = find_law(law, flags);
    const auto groups = columns.find("bandwidth");
    Model model{place,
                bits,
                static_cast<int>(joint_group.size()),
                groups == columns.end() ? 0 : static_cast<int>(groups->second.size()),
                length,
                std::move(joint_group),
                std::move(joint_share),
                {}};
    if (model.links < 1) throw nb::value_error("joint_group: a robot has one link at least");
    check_extent("joint_share", model.joint_share.size(), model.links);
    if (model.joint_group[0] != -1)
        throw nb::value_error("joint_group: link 0 has no front joint, its group must be -1");
    for (int group : model.joint_group)
        if (group < -1 || group >= model.groups) throw nb::value_error("joint_group: no such group");
    const std::vector<ParameterColumn> all = parameter_columns(model);
    for (std::size_t i = gait_columns; i < all.size(); ++i) {
        const auto column = columns.find(all[i].name);
        if (column == columns.end()) throw nb::value_error((std::string("columns: lacks ") + all[i].name).c_str());
        check_extent(all[i].name, column->second.size(), extent(model, all[i]));
        model.robot.insert(model.robot.end(), column->second.begin(), column->second.end());
    }
    return model;
}

static std::vector<std::string> parameter_names(const Model& model) {
    std::vector<std::string> names;
    for (const ParameterColumn& column : parameter_columns(model)) {
        if (column.extent == ParameterColumn::Extent::one)
            names.push_back(column.name);
        else
            for (int k = 0; k < extent(model, column); ++k)
                names.push_back(std::string(column.name) + "[" + std::to_string(k) + "]");
    }
    return names;
}

/// Columns of every water law, in the order of WaterLaws: name, unit, whether there is one value per link.
static std::vector<std::pair<std::string, std::vector<std::tuple<std::string, std::string, bool>>>> water_laws() {
    std::vector<std::pair<std::string, std::vector<std::tuple<std::string, std::string, bool>>>> laws;
    WaterLaws::each<double>([&](auto law) {
        using Law = typename decltype(law)::type;
        auto& [name, columns] = laws.emplace_back(Law::name, 0);
        for (const WaterColumn& column : Law::columns) columns.emplace_back(column.name, column.unit, column.per_link);
    });
    return laws;
}

void bind_model(nb::module_& m) {
    nb::set_leak_warnings(false);  // a robot that is alive at exit keeps its model
    m.def("water_laws", &water_laws,
          "The water laws, each with the columns of its coefficients: name, unit, whether one value per link.");
    nb::class_<Model>(m, "Model", "A robot in its water, ready for the core. Immutable.")
        .def(
            "__init__",
            [](Model* self, const std::string& law, const std::map<std::string, bool>& flags, double length,
               std::vector<int> joint_group, std::vector<double> joint_share,
               const std::map<std::string, std::vector<double>>& columns) {
                new (self)
                    Model(make_model(law, flags, length, std::move(joint_group), std::move(joint_share), columns));
            },
            nb::kw_only(), nb::arg("law"), nb::arg("flags"), nb::arg("length"), nb::arg("joint_group"),
            nb::arg("joint_share"), nb::arg("columns"),
            "Joint i sits at the front of link i; its group is -1 where it is rigid. `law` and `flags` as named by "
            "`water_laws`; `columns` holds the parameters after the gait's, by the names of `parameter_names`; there "
            "are as many groups as bandwidths.")
        .def_ro("links", &Model::links, "Number of links.")
        .def_ro("groups", &Model::groups, "Number of joint groups.")
        .def("parameter_names", &parameter_names,
             "Names of all parameters in the order of the derivatives: the gait's, the joints', the links', the "
             "water's.");
}

}  // namespace hypertuna
