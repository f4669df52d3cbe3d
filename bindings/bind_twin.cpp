/// Bindings of the whole robot, servo to wake.
#include "hypertuna/tail.hpp"
#include "model.hpp"
#include "tank.hpp"

namespace hypertuna {

/// Most coordinates of a tail: the controller's joints and a hinge.
static constexpr int most_coordinates = 5;

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
static void with_free_body(const Model& model, const Input<2>& share, bool clamped, const Work& work) {
    check_extent("share", share.shape(0), model.links);
    if constexpr (D > most_coordinates)
        throw nb::value_error("share: a tail has 1 to 5 coordinates");
    else if (share.shape(1) != D)
        with_free_body<D + 1>(model, share, clamped, work);
    else if (model.law == WaterLaw::lumped) {
        FreeBody<Lumped<double>, D> body(model, share.data(), clamped);
        work(body);
    } else {
        FreeBody<Strip<double>, D> body(model, share.data(), clamped);
        work(body);
    }
}

template <class Law, int D>
static void accelerate(FreeBody<Law, D>& body, const Input<3>& bend, const Input<2>& twist, const Input<2>& moment,
                       double* out) {
    for (std::size_t k = 0; k < bend.shape(0); ++k) {
        Bend<double, D> at;
        std::copy(bend.data() + 2 * D * k, bend.data() + 2 * D * k + D, at.angle);
        std::copy(bend.data() + 2 * D * k + D, bend.data() + 2 * D * (k + 1), at.rate);
        double push[D];
        std::copy(moment.data() + D * k, moment.data() + D * (k + 1), push);
        const double* xi = twist.data() + 3 * k;
        const TailAcceleration<double, D> got = tail_acceleration(body.tail, at, {xi[0], xi[1], xi[2]}, push);
        double* row = out + (3 + D) * k;
        row[0] = got.twist.x, row[1] = got.twist.y, row[2] = got.twist.z;
        std::copy(got.bend, got.bend + D, row + 3);
    }
}

static Output tail_accelerations(const Model& model, const Input<2>& share, const Input<3>& bend, const Input<2>& twist,
                                 const Input<2>& moment, bool clamped) {
    const std::size_t count = bend.shape(0), coordinates = share.shape(1);
    check_extent("bend", bend.shape(1), 2);
    check_extent("bend", bend.shape(2), coordinates);
    check_extent("twist", twist.shape(0), count);
    check_extent("twist", twist.shape(1), 3);
    check_extent("moment", moment.shape(0), count);
    check_extent("moment", moment.shape(1), coordinates);
    Output out = zeros({count, 3 + coordinates});
    with_free_body(model, share, clamped, [&](auto& body) { accelerate(body, bend, twist, moment, out.data()); });
    return out;
}

void bind_twin(nb::module_& m) {
    m.def("tail_acceleration", &tail_accelerations, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("bend"),
          nb::arg("twist"), nb::arg("moment"), nb::arg("clamped"),
          "Accelerations (states, 3 + D) of head and D coordinates, `share` (links, D) of which each joint takes, at "
          "bend (states, 2, D: angle and rate) and twist (states, 3) under moments (states, D) on the coordinates.");
}

}  // namespace hypertuna
