/// A plate to test the water laws with.
#pragma once

#include "hypertuna/swimming/strip.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// A link 2 m long and 2 m high, center of mass 0.5 m behind its front, in water of 4/pi kg/m^3: added mass 4 kg/m.
struct Plate {
    static constexpr double density = 4 / pi, drag = 3, friction = 5;
    struct Given {
        bool cross_flow = false;
        double linear_normal = 0, linear_tangential = 0, beating = 0, blunt_area = 0, tail_shedding = 0.5,
               added_mass = 1, edge_height = 0, edge_aspect = 0, edge_added_mass = 1, edge_lift = 1, edge_suction = 0;
    };
    Link<double> link;
    Strip<double>::Coefficients k;
    Strip<double> water;

    Plate() : Plate(Given{}) {}
    explicit Plate(const Given& given) {
        const double row[] = {2,
                              0.5,
                              3,
                              7,
                              density,
                              4,
                              8,
                              given.added_mass,
                              0.25,
                              1,
                              2 * drag / (4 * density),
                              2 * friction / (8 * density),
                              given.linear_normal,
                              given.linear_tangential,
                              given.tail_shedding,
                              2 * given.beating / (4 * density),
                              given.blunt_area,
                              given.edge_height,
                              given.edge_aspect,
                              given.edge_added_mass,
                              given.edge_lift,
                              given.edge_suction};
        Columns<double> in{row};
        const double rho = read_body(1, in, &link);
        water = Strip<double>::read(1, in, &link, rho, given.cross_flow, &k);
    }
    Plate(const Plate&) = delete;

    Along<double> towed(const Along<double>& v) const { return water.drag(0, v, Along<double>{0, 0, 0}); }
};

/// Power that the wake takes, at a velocity of the center of mass.
template <class Law>
double wake_power(const Law& water, const Along<double>& v) {
    const Along<double> f = water.shed(v);
    return -(f.t * v.t + f.n * v.n + f.w * v.w);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
