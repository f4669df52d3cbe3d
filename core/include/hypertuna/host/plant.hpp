/// A robot's plant, loaded from columns: body, soft joints, circuits and battery; and the twin that is made of it.
#pragma once

#include <array>

#include "hypertuna/host/body.hpp"
#include "hypertuna/host/machines.hpp"
#include "hypertuna/simulation/twin6.hpp"

namespace hypertuna {

/// A plant as its columns describe it. Immutable: runs share it.
struct PlantData : BodyData {
    int joints;
    std::vector<Joint<double>> joint;
    std::vector<double> joint_numbers;     // joints x (joint_columns, and the stretch limits)
    std::array<bool, max_joints> direct;   // whether a servo moves a joint, not oil
    std::vector<double> gear;              // joints: turns of that servo per bend, 1 on the axle
    std::vector<Circuit<double>> circuit;  // 2 joints
    std::vector<double> unit_rest;         // 2 joints: m^3 of oil in the muscles of the straight, filled joint
    std::vector<Spring<double>> spring;    // springs of the hinges, then of coordinates at rest: max_coordinates
    Battery<double> battery;
    double idle;  // W drawn in addition to the pumps' servos

    /// Not inlined: GCC 12 would warn that the value of an empty optional is read.
    HYPERTUNA_NOINLINE explicit PlantData(BodyData&& body)
        : BodyData(std::move(body)), joints(0), direct{}, spring(max_coordinates), battery{}, idle(0) {}
    PlantData(PlantData&&) = default;
    PlantData(const PlantData&) = delete;
};

/// Load a plant from the columns of its body, `joint.NAME` (joints), `circuit.NAME` (2 joints, left before right),
/// `direct` where a servo moves a joint (joints: turns of the left circuit's servo per bend, 1 on the axle, 0 with
/// oil), `battery.NAME`, `idle`, and `spring.NAME` of the hinges where there are more coordinates than joints.
inline Loaded<PlantData> load_plant(const Model& model, const NamedColumns& columns) {
    ColumnReader in(columns);
    PlantData plant(read_body_data(in, model));
    plant.joints = in.whole("joints", 1, max_joints);
    if (plant.own < plant.joints) in.refuse("share: must have one coordinate per joint, and one per hinge");
    for (int j = 0; j < plant.joints && in.fault().empty(); ++j) {
        std::vector<double> row = in.row("joint", joint_columns, j);
        plant.joint.push_back(read_joint<double>(row.data()));
        const auto& [low, high, stop] = plant.joint.back().limits;
        row.insert(row.end(), {low, high, stop});
        plant.joint_numbers.insert(plant.joint_numbers.end(), row.begin(), row.end());
    }
    for (int j = 0; j < plant.joints; ++j) {
        plant.gear.push_back(in.has("direct") ? in.number("direct", std::size_t(j)) : 0.0);
        plant.direct[j] = plant.gear[j] != 0;
    }
    for (int c = 0; c < 2 * plant.joints && in.fault().empty(); ++c) {
        plant.circuit.push_back(read_circuit<double>(in.row("circuit", circuit_columns, c).data()));
        plant.unit_rest.push_back(plant.direct[c / 2] ? 0.0 : taut_load(plant.joint[c / 2], 0.0, 0.0).volume[c % 2]);
    }
    // These divide; a joint that a servo moves has zeros for its oil and for the second circuit.
    for (int c = 0; c < 2 * plant.joints && in.fault().empty(); ++c) {
        const bool direct = plant.direct[c / 2];
        if (!direct && plant.joint[c / 2].axial_viscosity == 0)
            in.refuse("joint.axial_viscosity: must be above 0 where oil bends the joint");
        if (!(direct && c % 2) && plant.circuit[c].servo.stall_torque == 0)
            in.refuse("circuit.stall_torque: must be above 0");
    }
    for (int k = 0; k < plant.own - plant.joints && in.fault().empty(); ++k) {
        plant.spring[k] = read_row<Spring<double>, double>(spring_columns, in.row("spring", spring_columns, k).data());
        if (plant.spring[k].moment != 0) in.refuse("spring.moment: must be 0 in a twin, which has no motor there");
    }
    plant.battery = read_battery<double>(in.row("battery", battery_columns).data());
    plant.idle = in.number("idle");
    return in.loaded(std::move(plant));
}

/// Structure of a plant; plants of the same structure differ only in numbers: law, flags, links, groups, coordinates,
/// joints, and which joints a servo turns.
inline std::vector<int> structure_of(const PlantData& plant) {
    std::vector<int> out{plant.model.law, int(plant.model.flags), plant.model.links, plant.model.groups, plant.own,
                         plant.joints};
    out.insert(out.end(), plant.direct.begin(), plant.direct.begin() + plant.joints);
    return out;
}

/// A plant in the plane as rows of numbers, which live as long as the plant does.
inline PlantNumbers numbers_of(const PlantData& plant, bool clamped) {
    return {&plant.model,
            plant.coordinates,
            plant.joints,
            clamped,
            plant.direct.data(),
            plant.gear.data(),
            plant.share.data(),
            plant.armature.data(),
            plant.joint_numbers.data(),
            reinterpret_cast<const double*>(plant.circuit.data()),
            plant.unit_rest.data(),
            reinterpret_cast<const double*>(plant.spring.data()),
            reinterpret_cast<const double*>(&plant.battery),
            plant.idle};
}

/// State of a plant in the plane at rest.
template <int D>
PlantState<double, D> state_at_rest(const PlantData& plant) {
    return at_rest<double, D, InPlane>(plant.joints, plant.spring.data());
}

/// Make a twin of a plant without a controller; `body` keeps the body's memory.
template <class Body>
Twin<Body> make_twin(const PlantData& plant, const Body& body, double tick, int steps) {
    Twin<Body> twin{};
    twin.plant = {body,
                  plant.joints,
                  plant.joint.data(),
                  plant.direct.data(),
                  plant.gear.data(),
                  plant.circuit.data(),
                  plant.unit_rest.data(),
                  plant.spring.data()};
    twin.battery = plant.battery;
    twin.idle = plant.idle;
    twin.step = tick / steps;
    twin.steps = steps;
    return twin;
}

}  // namespace hypertuna
