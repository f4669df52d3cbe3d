/// A tank to swim in: all the memory that the core needs for one gait (or one set of lanes), kept between gaits.
#pragma once

#include <vector>

#include "hypertuna/beat.hpp"
#include "hypertuna/parameters.hpp"
#include "kernels.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S, class Law>
struct Tank {
    std::vector<S> parameters;
    std::vector<JointShare<S>> joints;
    std::vector<Harmonic<S>> groups;
    std::vector<Swing<S>> swings;
    std::vector<Link<S>> link;
    std::vector<typename Law::Coefficients> coefficients;
    S frequency;
    Swimmer<S, Law> fish;
    ShapeTable<S> table;
    BeatScratch<S> scratch;

    /// Memory for a beat of `steps` steps; the gait's parameters are left at zero.
    Tank(const Model& model, int steps)
        : parameters(gait_parameters(model.groups) + model.body.size(), S(0.0)),
          groups(model.groups),
          swings(model.groups),
          link(model.links),
          coefficients(model.links),
          cross_flow_(model.cross_flow),
          motion_(model.links),
          torque_(model.links),
          group_power_(model.links),
          shape_(2 * steps * model.links),
          acceleration_(2 * steps * model.links),
          mobility_(2 * steps),
          momentum_(2 * steps),
          tail_(steps),
          nose_(steps) {
        for (int i = 0; i < model.links; ++i)
            joints.push_back({model.joint_group[i], S(base_t<S>(model.joint_share[i]))});
        for (int g = 0; g < model.groups; ++g) parameters[1 + 3 * model.groups + g] = S(base_t<S>(model.bandwidth[g]));
        for (std::size_t i = 0; i < model.body.size(); ++i)
            parameters[gait_parameters(model.groups) + i] = S(base_t<S>(model.body[i]));
        table = {model.links, 2 * steps, shape_.data(), acceleration_.data(), mobility_.data(), momentum_.data()};
        scratch = {torque_.data(), group_power_.data(), tail_.data(), nose_.data()};
        read();
    }
    Tank(const Tank&) = delete;
    Tank& operator=(const Tank&) = delete;

    /// Read the parameters into swimmer and gait.
    void read() {
        Columns<S> in{parameters.data()};
        frequency = read_gait(static_cast<int>(groups.size()), in, groups.data());
        for (std::size_t g = 0; g < groups.size(); ++g) swings[g] = response(groups[g], frequency);
        const int links = static_cast<int>(link.size());
        const S density = read_body(links, in, link.data());
        const Law water = read_water(links, in, link.data(), density, cross_flow_, coefficients.data());
        fish = {links, link.data(), water};
    }
    /// The same, and tabulate the beat.
    void fill() {
        read();
        tabulate_beat(fish, joints.data(), swings.data(), frequency, motion_.data(), table);
    }

  private:
    bool cross_flow_;
    std::vector<JointMotion<S>> motion_;
    std::vector<S> torque_, group_power_;
    std::vector<LinkShape<S>> shape_;
    std::vector<LinkAcceleration<S>> acceleration_;
    std::vector<Symmetric<S>> mobility_;
    std::vector<Momentum<S>> momentum_;
    std::vector<Planar<S>> tail_, nose_;
};

}  // namespace hypertuna::inline HYPERTUNA_ARCH
