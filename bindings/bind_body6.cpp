/// Bindings of the body in space.
#include "free_body.hpp"
#include "hypertuna/body6.hpp"

namespace hypertuna {

/// What a body has in space beyond its model, as Python hands it over.
struct SpaceInput {
    const Input<2>& links;  // links, columns of LinkBody
    const Input<1>& fin;    // columns of fin.hpp
    const Input<1>& sea;    // columns of sea.hpp
};

static void check_space(const SpaceInput& in, const Model& model) {
    check_extent("links", in.links.shape(0), model.links);
    check_extent("links", in.links.shape(1), link_body_column_count);
    check_extent("fin", in.fin.shape(0), fin_column_count);
    check_extent("sea", in.sea.shape(0), sea_column_count);
}

/// A body in space that owns its memory.
template <class Law, int D>
struct SpaceBody {
    FreeBody<Law, D>& free;
    std::vector<LinkSpace<double>> space;
    Body6<double, Law, D> body;

    SpaceBody(FreeBody<Law, D>& own, const SpaceInput& in) : free(own) {
        const Sea<double> sea = read_sea<double>(in.sea.data());
        const Swimmer<double, Law>& fish = free.tank.fish;
        double length = 0, height = 0;
        for (int i = 0; i < fish.links; ++i) {
            const LinkBody<double> link = read_link_body<double>(in.links.data() + link_body_column_count * i);
            space.push_back(make_link_space(link, fish.link[i], fish.water.inertia(i), sea.density));
            length += fish.link[i].length;
            height = std::max(height, std::abs(link.center_height) + link.height);
        }
        body = {free.tail, space.data(), length + height, read_fin<double>(in.fin.data()), sea};
    }
    SpaceBody(const SpaceBody&) = delete;
    SpaceBody& operator=(const SpaceBody&) = delete;
};

/// A twist as a row: linear, then angular.
static SpatialTwist<double> read_twist(const double* row) {
    return {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
}
/// A pose as a row: position, attitude w x y z, fins.
static Pose6<double> read_pose(const double* row) {
    return {{row[0], row[1], row[2]}, normalized(Quaternion<double>{row[3], row[4], row[5], row[6]}), {row[7], row[8]}};
}
inline constexpr std::size_t twist_numbers = 6, pose_numbers = 9;

static Output accelerations(const Model& model, const Input<2>& share, const Input<2>& links, const Input<1>& fin,
                            const Input<1>& sea, const Input<3>& bend, const Input<2>& twist, const Input<2>& pose,
                            const Input<2>& moment) {
    const SpaceInput in{links, fin, sea};
    check_space(in, model);
    const std::size_t count = bend.shape(0), coordinates = share.shape(1);
    check_extent("bend", bend.shape(1), 2);
    check_extent("bend", bend.shape(2), coordinates);
    check_extent("twist", twist.shape(0), count);
    check_extent("twist", twist.shape(1), twist_numbers);
    check_extent("pose", pose.shape(0), count);
    check_extent("pose", pose.shape(1), pose_numbers);
    check_extent("moment", moment.shape(0), count);
    check_extent("moment", moment.shape(1), coordinates);
    Output out = zeros({count, twist_numbers + coordinates});
    with_free_body(model, share, false, [&]<class Law, int D>(FreeBody<Law, D>& own) {
        const SpaceBody<Law, D> space(own, in);
        for (std::size_t k = 0; k < count; ++k) {
            Bend<double, D> at;
            const double* row = bend.data() + 2 * D * k;
            std::copy(row, row + D, at.angle);
            std::copy(row + D, row + 2 * D, at.rate);
            double push[D];
            std::copy(moment.data() + D * k, moment.data() + D * (k + 1), push);
            const auto got = body6_acceleration(space.body, at, read_twist(twist.data() + twist_numbers * k),
                                                read_pose(pose.data() + pose_numbers * k), push);
            const auto& [v, w] = got.twist;
            double* to = out.data() + (twist_numbers + D) * k;
            for (double number : {v.x, v.y, v.z, w.x, w.y, w.z}) *to++ = number;
            std::copy(got.bend, got.bend + D, to);
        }
    });
    return out;
}

template <std::size_t N>
static std::vector<std::string> names(const char* const (&columns)[N]) {
    return {columns, columns + N};
}

void bind_body6(nb::module_& m) {
    m.def("link_body_columns", [] { return names(link_body_columns); }, "Columns of a link's description in space.");
    m.def("fin_columns", [] { return names(fin_columns); }, "Numbers that describe the pectoral fins.");
    m.def("sea_columns", [] { return names(sea_columns); }, "Numbers that describe the sea.");
    m.attr("GRAVITY") = gravity;
    m.def(
        "body6_acceleration", &accelerations, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("links"),
        nb::arg("fin"), nb::arg("sea"), nb::arg("bend"), nb::arg("twist"), nb::arg("pose"), nb::arg("moment"),
        "Accelerations (states, 6 + D) of the head (linear, then angular, in body axes) and of D coordinates, at bend "
        "(states, 2, D), twist (states, 6), pose (states, 9: position, attitude w x y z, fin angles), under moments "
        "(states, D) on the coordinates. `links`, `fin` and `sea` have the columns that the functions name.");
}

}  // namespace hypertuna
