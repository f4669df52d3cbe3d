/// A body in space, and the memory that it needs.
#pragma once

#include "free_body.hpp"
#include "hypertuna/simulation/body6.hpp"

namespace hypertuna {

/// What a body has in space beyond its model, as Python hands it over.
struct SpaceInput {
    const Input<2>& links;  // links, columns of LinkBody
    const Input<1>& fin;    // columns of fin.hpp
    const Input<1>& sea;    // columns of sea.hpp
    double shedding;        // part of the vertical added mass per length that the tail end leaves behind
    double antenna;         // m, height above the plane of the joints
};

inline void check_space(const SpaceInput& in, const Model& model) {
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
        double length = 0, height = 0, added = 0;
        for (int i = 0; i < fish.links; ++i) {
            const LinkBody<double> link = read_link_body<double>(in.links.data() + link_body_column_count * i);
            space.push_back(make_link_space(link, fish.link[i], fish.water.inertia(i), sea.density));
            added = std::max(added, (space.back().heave - fish.link[i].mass) / fish.link[i].length);
            length += fish.link[i].length;
            height = std::max(height, std::abs(link.center_height) + link.height);
        }
        body = {
            free.tail, space.data(), in.shedding * added, length + height, in.antenna, read_fin<double>(in.fin.data()),
            sea};
    }
    SpaceBody(const SpaceBody&) = delete;
    SpaceBody& operator=(const SpaceBody&) = delete;
};

/// A twist as a row: linear, then angular.
inline SpatialTwist<double> read_twist(const double* row) {
    return {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
}
/// A pose as a row: position, attitude w x y z, fins.
inline Pose6<double> read_pose(const double* row) {
    return {{row[0], row[1], row[2]}, normalized(Quaternion<double>{row[3], row[4], row[5], row[6]}), {row[7], row[8]}};
}
inline constexpr std::size_t twist_numbers = 6, pose_numbers = 9;

}  // namespace hypertuna
