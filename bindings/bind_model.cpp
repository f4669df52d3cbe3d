#include "model.hpp"

namespace hypertuna {

std::vector<ParameterColumn> parameter_columns(WaterLaw law) {
    using enum ParameterColumn::Extent;
    std::vector<ParameterColumn> columns = {{"frequency", one}, {"amplitude", groups}, {"phase", groups},
                                            {"bias", groups},   {"bandwidth", groups}, {"phase_offset", groups},
                                            {"length", links},  {"com", links},        {"mass", links},
                                            {"inertia", links}, {"density", one}};
    const std::vector<ParameterColumn> lumped = {
        {"added_mass", links}, {"friction", links}, {"drag", links}, {"friction_area", links}, {"drag_area", links}};
    const std::vector<ParameterColumn> strip = {{"lateral_area", links},      {"wetted_area", links},
                                                {"added_mass_normal", links}, {"added_mass_tangential", links},
                                                {"added_inertia", links},     {"drag_normal", links},
                                                {"drag_tangential", links},   {"linear_normal", links},
                                                {"linear_tangential", links}, {"tail_shedding", one}};
    const auto& water = law == WaterLaw::lumped ? lumped : strip;
    columns.insert(columns.end(), water.begin(), water.end());
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
    for (const ParameterColumn& column : parameter_columns(model.law)) count += extent(model, column);
    return count;
}

/// Columns that belong to a gait, not to the robot, and stand first.
static constexpr int gait_columns = 4;

static Model make_model(const std::string& law, bool cross_flow, double length, std::vector<int> joint_group,
                        std::vector<double> joint_share, const std::map<std::string, std::vector<double>>& columns) {
    if (law != "lumped" && law != "strip") throw nb::value_error("law must be 'lumped' or 'strip'");
    const auto groups = columns.find("bandwidth");
    Model model{law == "lumped" ? WaterLaw::lumped : WaterLaw::strip,
                cross_flow,
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
    const std::vector<ParameterColumn> all = parameter_columns(model.law);
    for (std::size_t i = gait_columns; i < all.size(); ++i) {
        const auto found = columns.find(all[i].name);
        if (found == columns.end()) throw nb::value_error((std::string("columns: lacks ") + all[i].name).c_str());
        check_extent(all[i].name, found->second.size(), extent(model, all[i]));
        model.robot.insert(model.robot.end(), found->second.begin(), found->second.end());
    }
    return model;
}

static std::vector<std::string> parameter_names(const Model& model) {
    std::vector<std::string> names;
    for (const ParameterColumn& column : parameter_columns(model.law)) {
        if (column.extent == ParameterColumn::Extent::one)
            names.push_back(column.name);
        else
            for (int k = 0; k < extent(model, column); ++k)
                names.push_back(std::string(column.name) + "[" + std::to_string(k) + "]");
    }
    return names;
}

void bind_model(nb::module_& m) {
    nb::class_<Model>(m, "Model", "A robot in its water, ready for the core. Immutable.")
        .def(
            "__init__",
            [](Model* self, const std::string& law, bool cross_flow, double length, std::vector<int> joint_group,
               std::vector<double> joint_share, const std::map<std::string, std::vector<double>>& columns) {
                new (self)
                    Model(make_model(law, cross_flow, length, std::move(joint_group), std::move(joint_share), columns));
            },
            nb::kw_only(), nb::arg("law"), nb::arg("cross_flow"), nb::arg("length"), nb::arg("joint_group"),
            nb::arg("joint_share"), nb::arg("columns"),
            "Joint i sits at the front of link i; its group is -1 where it is rigid. `columns` holds the parameters "
            "after the gait's, by the names of `parameter_names`; there are as many groups as bandwidths.")
        .def_ro("links", &Model::links, "Number of links.")
        .def_ro("groups", &Model::groups, "Number of joint groups.")
        .def("parameter_names", &parameter_names,
             "Names of all parameters in the order of the derivatives: the gait's, the joints', the links', the "
             "water's.");
}

}  // namespace hypertuna
