/// A robot in its water as rows of numbers: what a swimmer, a tank and a twin are built from.
#pragma once

#include <vector>

namespace hypertuna {

/// A robot in its water in the form that the core reads; core parameters.hpp has the order of the parameters.
struct Model {
    int law;         // place in WaterLaws, laws.hpp
    unsigned flags;  // flags of the law, a bit each
    int links, groups;
    double length;                    // m, of the whole body
    std::vector<int> joint_group;     // links: group that bends the link's front joint, or -1
    std::vector<double> joint_share;  // links: part of the group's angle
    std::vector<double> robot;        // parameters after the gait's: joints, links, water
};

}  // namespace hypertuna
