/// A body whose joints are moved by moments, and the memory that it needs.
#pragma once

#include "hypertuna/host/tank.hpp"
#include "hypertuna/simulation/tail.hpp"
#include "model.hpp"

namespace hypertuna {

/// Most coordinates of a tail: the controller's joints and a hinge.
inline constexpr int most_coordinates = 5;

/// A body in its water with D free coordinates, and its memory.
template <class Law, int D>
struct FreeBody {
    Tank<double, Law> tank;
    std::vector<JointMotion<double>> joint;
    std::vector<LinkShape<double>> shape;
    std::vector<LinkAcceleration<double>> acceleration;
    Tail<double, Law, D> tail;

    FreeBody(const Model& model, const double* share, bool clamped)
        : tank(model, 4), joint(model.links), shape(model.links), acceleration(model.links) {
        tail = {tank.fish,          reinterpret_cast<const double (*)[D]>(share), clamped, joint.data(), shape.data(),
                acceleration.data()};
    }
    FreeBody(const FreeBody&) = delete;
    FreeBody& operator=(const FreeBody&) = delete;
};

/// Call work with a free body of the model's water law and so many coordinates.
template <int D = 1, class Work>
void with_free_body(const Model& model, const Input<2>& share, bool clamped, const Work& work) {
    check_extent("share", share.shape(0), model.links);
    if constexpr (D > most_coordinates)
        throw nb::value_error("share: a tail has 1 to 5 coordinates");
    else if (share.shape(1) != D)
        with_free_body<D + 1>(model, share, clamped, work);
    else
        with_law<double>(model.law, [&](auto law) {
            FreeBody<typename decltype(law)::type, D> body(model, share.data(), clamped);
            work(body);
        });
}

}  // namespace hypertuna
