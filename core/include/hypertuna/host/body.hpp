/// A robot's body: the part of a robot that moves in the water, in the plane or in space, and the memory that its
/// dynamics need.
#pragma once

#include "hypertuna/host/machines.hpp"
#include "hypertuna/host/tank.hpp"
#include "hypertuna/host/world.hpp"
#include "hypertuna/simulation/body6.hpp"

namespace hypertuna {

/// A body as its columns describe it. Immutable: runs share it.
struct BodyData {
    /// Description of the body in space beyond that in the plane.
    struct Space {
        std::vector<LinkBody<double>> link;
        Fin<double> fin;
        double shedding;  // part of the vertical added mass per length that the tail end leaves behind
        double antenna;   // m, height above the plane of the joints
    };

    Model model;
    int own, coordinates;  // coordinates of the robot; of the tail for which code is compiled, where further ones rest
    std::vector<double> share;     // links x coordinates: part of each coordinate that a link's front joint takes
    std::vector<double> armature;  // coordinates: kg m^2 that turn with each in addition to the links
    std::optional<Space> space;
};

/// Add coordinates that rest: they move nothing, have an inertia of one and get no moment.
inline void pad(BodyData& body, int size) {
    std::vector<double> share;
    for (int i = 0; i < body.model.links; ++i) {
        const double* const row = &body.share[std::size_t(i * body.coordinates)];
        share.insert(share.end(), row, row + body.own);
        share.insert(share.end(), std::size_t(size - body.own), 0);
    }
    body.share = std::move(share);
    body.armature.resize(std::size_t(size), 1);
    body.coordinates = size;
}

/// Read a body: `share` (links, coordinates), `armature` (coordinates) where rotors turn with it; for a body in space,
/// also `link.NAME` (links), `fin.NAME`, `shedding` and `antenna`.
inline BodyData read_body_data(ColumnReader& in, const Model& model) {
    BodyData body{model, 1, 1, {}, {}, {}};
    if (const NamedColumn* share = in.find("share")) body.own = int(share->width);
    if (body.own < 1 || body.own > max_coordinates) {
        in.refuse("share: must have from 1 to " + std::to_string(max_coordinates) + " coordinates, but has " +
                  std::to_string(body.own));
        body.own = 1;
    }
    body.coordinates = body.own;
    body.share = in.numbers("share", model.links, body.own);
    body.armature = in.has("armature") ? in.numbers("armature", body.own) : std::vector<double>(body.own);
    pad(body, tail_size(body.own));
    if (!in.has("shedding")) return body;
    BodyData::Space& space = body.space.emplace();
    for (int i = 0; i < model.links; ++i)
        space.link.push_back(read_link_body<double>(in.row("link", link_body_columns, i).data()));
    space.fin = read_fin<double>(in.row("fin", fin_columns).data());
    space.shedding = in.number("shedding");
    space.antenna = in.number("antenna");
    return body;
}

inline Loaded<BodyData> load_body(const Model& model, const NamedColumns& columns) {
    ColumnReader in(columns);
    return in.loaded(read_body_data(in, model));
}

/// Return why a body cannot be in a world; empty where it can.
inline std::string check_world(const BodyData& body, const World& world) {
    return world.sea && !body.space ? "columns: a body at sea needs shedding, antenna, link.* and fin.*" : "";
}

/// A body in the plane and its memory.
template <class Law, int D>
struct PlaneBody {
    Tank<double, Law> tank;
    std::vector<JointMotion<double>> joint;
    std::vector<LinkShape<double>> shape;
    std::vector<LinkAcceleration<double>> acceleration;
    Tail<double, Law, D> tail;

    PlaneBody(const BodyData& data, bool clamped)
        : tank(data.model, 4), joint(data.model.links), shape(data.model.links), acceleration(data.model.links) {
        tail = {tank.fish,
                reinterpret_cast<const double (*)[D]>(data.share.data()),
                clamped,
                data.armature.data(),
                joint.data(),
                shape.data(),
                acceleration.data()};
    }
    PlaneBody(const PlaneBody&) = delete;
    PlaneBody& operator=(const PlaneBody&) = delete;
};

/// The links of a body in space, and the body's size and shed mass that follow from them.
template <class Law>
struct SpaceLinks {
    std::vector<LinkSpace<double>> link;
    double size = 0;      // m: the body is within a ball of this radius
    double shedding = 0;  // kg/m, vertical added mass that the tail end leaves behind

    SpaceLinks(const BodyData::Space& space, const Swimmer<double, Law>& fish, double density) {
        double height = 0;
        for (int i = 0; i < fish.links; ++i) {
            const LinkBody<double>& body = space.link[i];
            link.push_back(make_link_space(body, fish.link[i], fish.water.inertia(i), density));
            shedding = std::max(shedding, (link.back().heave - fish.link[i].mass) / fish.link[i].length);
            size += fish.link[i].length;
            height = std::max(height, std::abs(body.center_height) + body.height);
        }
        shedding *= space.shedding;
        size += height;
    }
};

/// A body in space and its memory.
template <class Law, int D>
struct SpaceBody {
    PlaneBody<Law, D> plane;
    SpaceLinks<Law> links;
    Body6<double, Law, D> body;

    SpaceBody(const BodyData& data, const Sea<double>& sea)
        : plane(data, false), links(*data.space, plane.tank.fish, sea.density) {
        body = {plane.tail, links.link.data(), links.shedding, links.size, data.space->antenna, data.space->fin, sea};
    }
    SpaceBody(const SpaceBody&) = delete;
    SpaceBody& operator=(const SpaceBody&) = delete;
};

/// Call work(body) with the body as the core's dynamics take it: a Tail in the plane, a Body6 at sea.
template <class Work>
void with_body(const BodyData& data, const World& world, const Work& work) {
    with_coordinates(data.coordinates, [&](auto coordinates) {
        with_law<double>(data.model.law, [&](auto law) {
            using Law = typename decltype(law)::type;
            if (world.sea)
                work(SpaceBody<Law, coordinates.value>(data, *world.sea).body);
            else
                work(PlaneBody<Law, coordinates.value>(data, world.clamped).tail);
        });
    });
}

}  // namespace hypertuna
