/// Bindings of muscles and soft joints.
#include <nanobind/stl/pair.h>

#include <vector>

#include "hypertuna/actuation/joint_table.hpp"
#include "model.hpp"

namespace hypertuna {

/// A soft joint that owns its segments.
struct OwnedJoint {
    SoftJoint<double> joint;
    std::vector<Segment<double>> segments;

    SoftJoint<double> view() const {
        SoftJoint<double> out = joint;
        out.segment = segments.data();
        return out;
    }
};

static DriveUnit<double> make_unit(double outer, double inner, double tan2, double sleeve,
                                   const std::pair<double, double>& hose, const std::pair<double, double>& matrix,
                                   double friction) {
    return {outer, inner, tan2, sleeve, {hose.first, hose.second}, {matrix.first, matrix.second}, friction};
}

static OwnedJoint make_joint(const DriveUnit<double>& unit, double units, const std::pair<double, double>& lever,
                             const std::vector<double>& length, const std::vector<double>& stiffness) {
    check_extent("stiffness", stiffness.size(), length.size());
    if (length.empty()) throw nb::value_error("length: a joint has one segment at least");
    OwnedJoint out{{unit,
                    units,
                    {lever.first, lever.second},
                    static_cast<int>(length.size()),
                    nullptr,
                    {false, {false, false}, true}},
                   {}};
    for (std::size_t i = 0; i < length.size(); ++i) out.segments.push_back({length[i], stiffness[i]});
    return out;
}

static OwnedJoint with_law(OwnedJoint joint, bool printed, bool nominal_stress, bool inner_balance, bool passive) {
    joint.joint.law = {printed, {nominal_stress, inner_balance}, passive};
    return joint;
}

/// What a muscle does at every stretch.
static NamedArrays muscle(const DriveUnit<double>& unit, const Input<1>& stretch, double pressure) {
    const std::size_t n = stretch.shape(0);
    Output energy_out = zeros({n}), wall_out = zeros({n}), lumen_out = zeros({n}), slope_out = zeros({n}),
           pull_out = zeros({n}), printed_out = zeros({n}), carried_out = zeros({n}), contact_out = zeros({n});
    for (std::size_t k = 0; k < n; ++k) {
        const double l = stretch.data()[k];
        energy_out.data()[k] = energy(unit, l);
        wall_out.data()[k] = energy_slope(unit, l);
        lumen_out.data()[k] = lumen(unit, l);
        slope_out.data()[k] = lumen_slope(unit, l);
        pull_out.data()[k] = pull(unit, pressure, l);
        printed_out.data()[k] = printed_pull(unit, pressure, l, {true, true});
        carried_out.data()[k] = carried(unit, l);
        contact_out.data()[k] = contact(unit, l);
    }
    NamedArrays out;
    out["energy"] = energy_out;
    out["energy_slope"] = wall_out;
    out["lumen"] = lumen_out;
    out["lumen_slope"] = slope_out;
    out["pull"] = pull_out;
    out["printed_pull"] = printed_out;
    out["carried"] = carried_out;
    out["contact"] = contact_out;
    return out;
}

static Output bend(const OwnedJoint& owned, const Input<2>& pressure) {
    check_extent("pressure", pressure.shape(1), 2);
    const SoftJoint<double> joint = owned.view();
    const std::size_t n = pressure.shape(0), segments = owned.segments.size();
    Output out = zeros({n, segments});
    for (std::size_t i = 0; i < segments; ++i) {
        double angle = 0;
        for (std::size_t k = 0; k < n; ++k) {
            angle = follow(joint, static_cast<int>(i), pressure.data() + 2 * k, angle);
            out.data()[k * segments + i] = angle;
        }
    }
    return out;
}

static constexpr std::size_t point_columns = sizeof(JointPoint<double>) / sizeof(double);

static Output joint_table(const OwnedJoint& owned, double reach, int points) {
    if (points < 3 || points % 2 == 0) throw nb::value_error("points: must be odd, and 3 at least");
    Output out = zeros({static_cast<std::size_t>(points), point_columns});
    const nb::gil_scoped_release unlocked;
    tabulate(owned.view(), reach, points, reinterpret_cast<JointPoint<double>*>(out.data()));
    return out;
}

static NamedArrays joint_loads(const Input<2>& points, double first, double step, double stop, const Input<1>& angle) {
    check_extent("points", points.shape(1), point_columns);
    if (points.shape(0) < 2) throw nb::value_error("points: a table has two points at least");
    const JointTable<double> table{reinterpret_cast<const JointPoint<double>*>(points.data()),
                                   static_cast<int>(points.shape(0)),
                                   first,
                                   step,
                                   0.0,
                                   stop};
    const std::size_t n = angle.shape(0);
    Output elastic = zeros({n}), energy_out = zeros({n}), volume = zeros({n, 2}), slope = zeros({n, 2}),
           friction = zeros({n, 2}), carried_out = zeros({n, 2});
    for (std::size_t k = 0; k < n; ++k) {
        const JointLoad<double> load = joint_load(table, angle.data()[k]);
        elastic.data()[k] = load.elastic;
        energy_out.data()[k] = load.energy;
        std::copy(load.volume, load.volume + 2, volume.data() + 2 * k);
        std::copy(load.slope, load.slope + 2, slope.data() + 2 * k);
        std::copy(load.friction, load.friction + 2, friction.data() + 2 * k);
        std::copy(load.carried, load.carried + 2, carried_out.data() + 2 * k);
    }
    NamedArrays out;
    out["elastic"] = elastic;
    out["energy"] = energy_out;
    out["volume"] = volume;
    out["slope"] = slope;
    out["friction"] = friction;
    out["carried"] = carried_out;
    return out;
}

void bind_actuator(nb::module_& m) {
    nb::class_<DriveUnit<double>>(m, "DriveUnit", "A McKibben muscle. Immutable.")
        .def(
            "__init__",
            [](DriveUnit<double>* self, double outer, double inner, double tan2, double sleeve,
               const std::pair<double, double>& hose, const std::pair<double, double>& matrix, double friction) {
                new (self) DriveUnit<double>(make_unit(outer, inner, tan2, sleeve, hose, matrix, friction));
            },
            nb::kw_only(), nb::arg("outer"), nb::arg("inner"), nb::arg("tan2"), nb::arg("sleeve"), nb::arg("hose"),
            nb::arg("matrix"), nb::arg("friction"),
            "Diameters at rest, squared tangent of the braid's angle, sleeve, C1 and C2 of hose and matrix.")
        .def("at", &muscle, nb::arg("stretch"), nb::kw_only(), nb::arg("pressure"),
             "Energy and lumen per length at rest with their slopes, pull, pull by the printed equations, pressure "
             "that the walls carry and contact area, at every stretch.")
        .def(
            "closing_stretch", [](const DriveUnit<double>& unit, double left) { return closing_stretch(unit, left); },
            nb::arg("left"), "Stretch at which this part of the lumen at rest is left.");
    nb::class_<OwnedJoint>(m, "SoftJoint", "A soft joint: muscles on both sides of segments of matrix. Immutable.")
        .def(
            "__init__",
            [](OwnedJoint* self, const DriveUnit<double>& unit, double units, const std::pair<double, double>& lever,
               const std::vector<double>& length, const std::vector<double>& stiffness) {
                new (self) OwnedJoint(make_joint(unit, units, lever, length, stiffness));
            },
            nb::arg("unit"), nb::kw_only(), nb::arg("units"), nb::arg("lever"), nb::arg("length"), nb::arg("stiffness"),
            "Muscles a side, lever of each side, length and E I of each segment.")
        .def("with_law", &with_law, nb::kw_only(), nb::arg("printed"), nb::arg("nominal_stress"),
             nb::arg("inner_balance"), nb::arg("passive"), "The same joint by other equations.")
        .def("bend", &bend, nb::arg("pressure"),
             "Angle of each segment (times, segments) along a path of the two sides' pressures (times, 2) from rest.")
        .def(
            "reach",
            [](const OwnedJoint& owned, int side, double left, double highest) {
                if (side != 0 && side != 1) throw nb::value_error("side must be 0 or 1");
                return joint_reach(owned.view(), side, left, highest);
            },
            nb::arg("side"), nb::kw_only(), nb::arg("left"), nb::arg("highest"),
            "Largest angle toward a side, up to the highest pressure, whose segments keep this part of every lumen.")
        .def(
            "stiffness",
            [](const OwnedJoint& owned) {
                const JointStiffness<double> found = stiffness_at_rest(owned.view());
                return std::pair(found.matrix, found.walls);
            },
            "Stiffness at rest against the joint's angle: of the matrix, and of the walls.")
        .def("table", &joint_table, nb::kw_only(), nb::arg("reach"), nb::arg("points"),
             "The joint's table from -reach to reach (points, columns).");
    m.def("joint_load", &joint_loads, nb::arg("points"), nb::kw_only(), nb::arg("first"), nb::arg("step"),
          nb::arg("stop"), nb::arg("angle"), "What a joint's table says at every angle.");
}

}  // namespace hypertuna
