/// Read a robot in its water from named columns, laid out in the order of core parameters.hpp.
#pragma once

#include "hypertuna/host/columns.hpp"
#include "hypertuna/host/model.hpp"
#include "hypertuna/swimming/parameters.hpp"

namespace hypertuna {

/// A column of parameters: one number, or one per group or link.
struct ParameterColumn {
    const char* name;
    int count;
    bool single;
};

/// The columns of a model's parameters in order, the gait's first.
inline std::vector<ParameterColumn> parameter_columns(const Model& model) {
    std::vector<ParameterColumn> columns = {{"frequency", 1, true}};
    for (const char* name : {"amplitude", "phase", "bias", "bandwidth", "phase_offset"})
        columns.push_back({name, model.groups, false});
    for (const char* name : {"length", "com", "mass", "inertia"}) columns.push_back({name, model.links, false});
    columns.push_back({"density", 1, true});
    with_listed_law<double>(model.law, [&](auto law) {
        for (const WaterColumn& column : decltype(law)::type::columns)
            columns.push_back({column.name, column.per_link ? model.links : 1, !column.per_link});
    });
    return columns;
}

/// Number of the columns that belong to a gait, not to the robot, and stand first.
inline constexpr std::size_t gait_columns = 4;

/// Load a model from `body_length`, `joint_group` and `joint_share` (links: joint i is at the front of link i, with
/// group -1 where it is rigid), a column for each flag of the law that is not 0, and the columns of its parameters
/// after the gait's. The number of bandwidths is that of the groups.
inline Loaded<Model> load_model(const std::string& law, const NamedColumns& columns) {
    ColumnReader in(columns);
    Model model{-1, 0, 0, 0, in.number("body_length"), {}, {}, {}};
    std::string known;
    int place = 0;
    WaterLaws::each<double>([&](auto listed) {
        using Law = typename decltype(listed)::type;
        known += std::string(place ? ", " : "") + Law::name;
        if (law == Law::name) {
            model.law = place;
            for (int f = 0; Law::flags[f]; ++f)
                if (in.has(Law::flags[f]) && in.number(Law::flags[f]) != 0) model.flags |= 1u << f;
        }
        ++place;
    });
    if (model.law < 0) in.refuse("law: must be one of " + known);
    if (const NamedColumn* const group = in.find("joint_group")) model.links = int(group->rows);
    if (const NamedColumn* const bandwidth = in.find("bandwidth")) model.groups = int(bandwidth->rows);
    if (model.links < 1) in.refuse("joint_group: must have one link or more");
    model.joint_share = in.numbers("joint_share", model.links);
    for (double group : in.numbers("joint_group", model.links)) {
        if (group != std::floor(group) || group < -1 || group >= model.groups)
            in.refuse("joint_group: must be -1 or a group");
        model.joint_group.push_back(in.fault().empty() ? int(group) : -1);
    }
    if (in.fault().empty() && model.joint_group[0] != -1)
        in.refuse("joint_group: must be -1 for link 0, which has no front joint");
    const std::vector<ParameterColumn> all = parameter_columns(model);
    for (std::size_t k = gait_columns; k < all.size(); ++k)
        for (double number : in.numbers(all[k].name, all[k].count)) model.robot.push_back(number);
    return in.loaded(std::move(model));
}

}  // namespace hypertuna
