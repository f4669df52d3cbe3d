/// The memory that the core needs to swim: for beats and for long motions.
#pragma once

#include <algorithm>
#include <vector>

#include "hypertuna/host/model.hpp"
#include "hypertuna/swimming/beat.hpp"
#include "hypertuna/swimming/parameters.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

inline constexpr int block_steps = 63;  // steps of a long motion whose shapes are tabulated at a time

/// Drop the derivatives of a scalar where the scalar G of a shape has none.
template <class G, class S>
G narrow(const S& x) {
    if constexpr (std::same_as<G, S>)
        return x;
    else
        return value(x);
}

/// Flags of a model's law; for a type that can be any law, with the law's place in the list.
template <class Law>
unsigned flags_of(const Model& model) {
    if constexpr (requires { Law::flag_bits; })
        return unsigned(model.law) << Law::flag_bits | model.flags;
    else
        return model.flags;
}

/// A tank to swim in: all the memory that the core needs for one gait (or one set of lanes), kept between gaits.
///
/// The shape has scalars G: without derivatives where it does not depend on the parameters that have derivatives.
template <class S, class Law, class G = S>
struct Tank {
    std::vector<S> parameters;
    std::vector<JointShare<G>> joints;
    std::vector<Harmonic<S>> groups;
    std::vector<Swing<G>> swings;
    std::vector<Link<S>> link;
    std::vector<Link<G>> geometry;
    std::vector<typename Law::Coefficients> coefficients;
    S frequency;
    Swimmer<S, Law, G> fish;
    ShapeTable<S, G> table;
    BeatScratch<S> scratch;

    /// Memory for a beat of `steps` steps; the gait's parameters are left at zero.
    Tank(const Model& model, int steps)
        : parameters(gait_parameters(model.groups) + model.robot.size(), S(0.0)),
          groups(model.groups),
          swings(model.groups),
          link(model.links),
          geometry(model.links),
          coefficients(model.links),
          flags_(flags_of<Law>(model)),
          motion_(model.links),
          torque_(model.links),
          group_power_(model.links),
          shape_(2 * steps * model.links),
          acceleration_(2 * steps * model.links),
          mobility_(2 * steps),
          momentum_(2 * steps),
          sample_(steps) {
        for (int i = 0; i < model.links; ++i)
            joints.push_back({model.joint_group[i], G(base_t<G>(model.joint_share[i]))});
        for (std::size_t i = 0; i < model.robot.size(); ++i)
            parameters[gait_parameters(model.groups) + i] = S(base_t<S>(model.robot[i]));
        table = {model.links, 2 * steps, shape_.data(), acceleration_.data(), mobility_.data(), momentum_.data()};
        scratch = {torque_.data(), group_power_.data(), sample_.data()};
        read();
    }
    Tank(const Tank&) = delete;
    Tank& operator=(const Tank&) = delete;

    /// Read the parameters into swimmer and gait.
    void read() {
        Columns<S> in{parameters.data()};
        frequency = read_gait(static_cast<int>(groups.size()), in, groups.data());
        for (std::size_t g = 0; g < groups.size(); ++g) {
            const Swing<S> swing = response(groups[g], frequency);
            swings[g] = {narrow<G>(swing.bias), narrow<G>(swing.sine), narrow<G>(swing.cosine)};
        }
        const int links = static_cast<int>(link.size());
        const S density = read_body(links, in, link.data());
        const Law water = Law::read(links, in, link.data(), density, flags_, coefficients.data());
        for (int i = 0; i < links; ++i)
            geometry[i] = {narrow<G>(link[i].length), narrow<G>(link[i].com), narrow<G>(link[i].mass),
                           narrow<G>(link[i].inertia)};
        fish = {links, geometry.data(), water};
    }
    /// Read the parameters and tabulate the beat.
    void fill() {
        read();
        tabulate_beat(fish, joints.data(), swings.data(), narrow<G>(frequency), motion_.data(), table);
    }
    /// Read parameters that leave the tabulated shape as it is, and tabulate only mobility and momentum.
    void refill() {
        read();
        for (int k = 0; k < table.instants; ++k) weigh(fish, k, table);
    }

  private:
    unsigned flags_;
    std::vector<JointMotion<G>> motion_;
    std::vector<S> torque_, group_power_;
    std::vector<LinkShape<G>> shape_;
    std::vector<LinkAcceleration<G>> acceleration_;
    std::vector<Symmetric<S>> mobility_;
    std::vector<Momentum<S>> momentum_;
    std::vector<BeatSample<S>> sample_;
};

/// Swim a joint motion from a momentum and a pose. joints_at(k) is the joints' motion at half step k = 0 ... 2 steps,
/// and record(k, now, motion) is called at every step. The tank has memory for block_steps + 1 steps or more.
template <class S, class Law, class G, class Joints, class Record>
void swim_joints(Tank<S, Law, G>& tank, std::size_t steps, const S& step, Motion<S> motion, const Joints& joints_at,
                 const Record& record) {
    for (std::size_t first = 0;; first += block_steps) {
        const std::size_t block = std::min<std::size_t>(block_steps, steps - first);
        for (std::size_t k = 0; k <= 2 * block; ++k)
            tabulate(tank.fish, joints_at(2 * first + k), static_cast<int>(k), tank.table);
        for (std::size_t k = 0; k < block; ++k) {
            record(first + k, tank.table[2 * k], motion);
            motion = swim_step(tank.fish, tank.table, 2 * k, 1, step, motion);
        }
        if (first + block == steps) {
            record(steps, tank.table[2 * block], motion);
            return;
        }
    }
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
