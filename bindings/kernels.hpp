/// What the kernels do, without saying for which processor: plain numbers in, plain numbers out.
#pragma once

#include <vector>

namespace hypertuna {

enum class WaterLaw { lumped, strip };

/// A robot in its water, as the core wants it: see core parameters.hpp for the order of the parameters.
struct Model {
    WaterLaw law;
    bool cross_flow;
    int links, groups;
    double length;                    // m, of the whole body
    std::vector<int> joint_group;     // links: group that bends the link's front joint, or -1
    std::vector<double> joint_share;  // links: part of the group's angle
    std::vector<double> bandwidth;    // groups, Hz
    std::vector<double> body;         // links' and water's parameters
};

/// Gaits side by side; each array is row-major, gaits x groups.
struct GaitBatch {
    const double *frequency, *amplitude, *phase, *bias;
};

struct SettleOptions {
    int steps;       // per beat, a multiple of 4
    int wait;        // integrate so many beats from rest instead of Newton's method; negative for Newton
    int most_beats;  // of each of the stages of Newton's method
};

/// One row of results for each gait.
namespace column {
enum Column {
    displacement_x,
    displacement_y,
    turn,
    power,
    power_positive,
    loss,
    excursion,
    arc,
    radius,
    advance,
    residual,
    distance,
    beats,
    twist,                     // 3: u, v, r at the start of the beat
    momentum = twist + 3,      // 3
    monodromy = momentum + 3,  // 9, row-major, of the momentum
    count = monodromy + 9
};
inline constexpr const char* names[count] = {"displacement_x",
                                             "displacement_y",
                                             "turn",
                                             "power",
                                             "power_positive",
                                             "loss",
                                             "excursion",
                                             "arc",
                                             "radius",
                                             "advance",
                                             "residual",
                                             "distance",
                                             "beats",
                                             "u",
                                             "v",
                                             "r",
                                             "p_x",
                                             "p_y",
                                             "l",
                                             "m_00",
                                             "m_01",
                                             "m_02",
                                             "m_10",
                                             "m_11",
                                             "m_12",
                                             "m_20",
                                             "m_21",
                                             "m_22"};
}  // namespace column

/// Outputs that have derivatives, in this order.
namespace output {
enum Output { arc, power, power_positive, loss, end_x, end_y, end_z, count };
inline constexpr const char* names[count] = {"arc", "power", "power_positive", "loss", "end_p_x", "end_p_y", "end_l"};
}  // namespace output

struct Kernel {
    const char* name;
    int lanes;
    double settled_distance;  // what is nearer to settled than this part of its stride counts as settled
    /// Settled beats of gaits [begin, end) into rows of column::count.
    void (*settle)(const Model&, const GaitBatch&, const SettleOptions&, int begin, int end, double* rows);
    /// Derivatives of one beat that starts at `momentum`: output::count rows of 3 + parameters directions,
    /// first by the momentum at the start, then by the parameters.
    void (*gradient)(const Model&, const GaitBatch&, int gait, const double* momentum, int steps, double* rows);
};

int parameter_count(const Model& model);

}  // namespace hypertuna
