#include "hypertuna/host/tank.hpp"
#include "model.hpp"

namespace hypertuna {

/// Call work with a tank of the model's water law.
template <class Work>
static void in_tank(const Model& model, int steps, const Work& work) {
    with_law<double>(model.law, [&](auto law) {
        Tank<double, typename decltype(law)::type> tank(model, steps);
        work(tank);
    });
}

static const JointMotion<double>* joints_at(const Input<3>& joints, std::size_t instant) {
    static_assert(sizeof(JointMotion<double>) == 3 * sizeof(double));
    return reinterpret_cast<const JointMotion<double>*>(joints.data()) + instant * joints.shape(1);
}

static Output joint_motion_at(const Model& model, double frequency, const std::vector<double>& amplitude,
                              const std::vector<double>& phase, const std::vector<double>& bias,
                              const Input<1>& clock) {
    const std::size_t groups = model.groups;
    check_extent("amplitude", amplitude.size(), groups);
    check_extent("phase", phase.size(), groups);
    check_extent("bias", bias.size(), groups);
    std::vector<Swing<double>> swings;
    for (std::size_t g = 0; g < groups; ++g)
        swings.push_back(response(
            Harmonic<double>{amplitude[g], phase[g], bias[g], model.robot[g], model.robot[groups + g]}, frequency));
    std::vector<JointShare<double>> joints;
    for (int i = 0; i < model.links; ++i) joints.push_back({model.joint_group[i], model.joint_share[i]});
    Output out = zeros({clock.shape(0), joints.size(), 3});
    auto* motion = reinterpret_cast<JointMotion<double>*>(out.data());
    for (std::size_t k = 0; k < clock.shape(0); ++k)
        joint_motion(model.links, joints.data(), swings.data(), frequency, sincos(clock.data()[k]),
                     motion + k * joints.size());
    return out;
}

static void put(double* out, const Planar<double>& a) { out[0] = a.x, out[1] = a.y, out[2] = a.z; }

static NamedArrays dynamics(const Model& model, const Input<3>& joints, const Input<2>& twists) {
    const std::size_t count = joints.shape(0), links = model.links;
    check_extent("joints", joints.shape(1), links);
    check_extent("joints", joints.shape(2), 3);
    check_extent("twist", twists.shape(0), count);
    check_extent("twist", twists.shape(1), 3);
    Output inertia = zeros({count, 3, 3}), momentum = zeros({count, 3}), acceleration_out = zeros({count, 3}),
           torque = zeros({count, links}), wrench = zeros({count, 3}), loss = zeros({count}), energy = zeros({count});
    in_tank(model, 4, [&](auto& tank) {
        const nb::gil_scoped_release unlocked;
        for (std::size_t k = 0; k < count; ++k) {
            tabulate(tank.fish, joints_at(joints, k), 0, tank.table);
            const Instant<double> now = tank.table[0];
            const Twist<double> xi{twists.data()[3 * k], twists.data()[3 * k + 1], twists.data()[3 * k + 2]};
            const auto [m, b] = composite(tank.fish, now.shape);
            const double full[9] = {m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz};
            std::copy(full, full + 9, inertia.data() + 9 * k);
            put(momentum.data() + 3 * k, m * xi + b);
            put(acceleration_out.data() + 3 * k, acceleration(tank.fish, now, xi));
            put(wrench.data() + 3 * k, water_wrench(tank.fish, now.shape, xi));
            joint_torques(tank.fish, now, xi, torque.data() + links * k);
            loss.data()[k] = water_loss(tank.fish, now.shape, xi);
            energy.data()[k] = kinetic_energy(tank.fish, now.shape, xi);
        }
    });
    NamedArrays out;
    out["inertia"] = inertia;
    out["momentum"] = momentum;
    out["acceleration"] = acceleration_out;
    out["wrench"] = wrench;
    out["torque"] = torque;
    out["loss"] = loss;
    out["energy"] = energy;
    return out;
}

static NamedArrays advance(const Model& model, const Input<3>& joints, double step, const Input<1>& twist0,
                           const Input<1>& pose0) {
    const std::size_t links = model.links, steps = joints.shape(0) / 2;
    if (joints.shape(0) % 2 != 1) throw nb::value_error("joints: needs two instants a step and one more");
    check_extent("joints", joints.shape(1), links);
    check_extent("joints", joints.shape(2), 3);
    check_extent("twist", twist0.shape(0), 3);
    check_extent("pose", pose0.shape(0), 3);
    Output twists = zeros({steps + 1, 3}), poses = zeros({steps + 1, 3}), torque = zeros({steps + 1, links}),
           loss = zeros({steps + 1}), energy = zeros({steps + 1});
    in_tank(model, block_steps + 1, [&](auto& tank) {
        const nb::gil_scoped_release unlocked;
        const auto at = [&](std::size_t k) { return joints_at(joints, k); };
        tabulate(tank.fish, at(0), 0, tank.table);
        const auto [m, b] = composite(tank.fish, tank.table.shape);
        const Momentum<double> P = m * Twist<double>{twist0.data()[0], twist0.data()[1], twist0.data()[2]} + b;
        const Motion<double> start{P, {pose0.data()[0], pose0.data()[1], pose0.data()[2]}};
        swim_joints(tank, steps, step, start, at,
                    [&](std::size_t k, const Instant<double>& now, const Motion<double>& motion) {
                        const Twist<double> xi = twist(now, motion.momentum);
                        put(twists.data() + 3 * k, xi);
                        put(poses.data() + 3 * k, {motion.pose.x, motion.pose.y, motion.pose.heading});
                        joint_torques(tank.fish, now, xi, torque.data() + links * k);
                        loss.data()[k] = water_loss(tank.fish, now.shape, xi);
                        energy.data()[k] = kinetic_energy(tank.fish, now.shape, xi);
                    });
    });
    NamedArrays out;
    out["twist"] = twists;
    out["pose"] = poses;
    out["torque"] = torque;
    out["loss"] = loss;
    out["energy"] = energy;
    return out;
}

void bind_swimmer(nb::module_& m) {
    m.def("joint_motion", &joint_motion_at, nb::arg("model"), nb::kw_only(), nb::arg("frequency"), nb::arg("amplitude"),
          nb::arg("phase"), nb::arg("bias"), nb::arg("clock"),
          "Angle, rate and acceleration of every joint (instants, links, 3) where 2 pi f t is `clock`.");
    m.def("dynamics", &dynamics, nb::arg("model"), nb::arg("joints"), nb::arg("twist"),
          "The equations of swimming at given states, joints (states, links, 3) and twist (states, 3): inertia (3, 3), "
          "momentum, acceleration, wrench of the water, joint torque, loss to the water and kinetic energy.");
    m.def(
        "advance", &advance, nb::arg("model"), nb::arg("joints"), nb::kw_only(), nb::arg("step"), nb::arg("twist"),
        nb::arg("pose"),
        "Swim a joint motion, given at every half step (2 steps + 1, links, 3), from a twist and a pose: twist, pose, "
        "joint torque, loss to the water and kinetic energy at every step.");
}

}  // namespace hypertuna
