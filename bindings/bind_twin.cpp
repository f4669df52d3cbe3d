/// Bindings of the whole robot, servo to wake.
#include "owned_twin.hpp"

namespace hypertuna {

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

/// Columns of the head's motion in the plane.
template <int D, class Space = InPlane>
static const std::vector<TwinColumn<D, Space>> head_columns = {
    HYPERTUNA_COLUMN("x", one, at.plant.pose.x),
    HYPERTUNA_COLUMN("y", one, at.plant.pose.y),
    HYPERTUNA_COLUMN("heading", one, at.plant.pose.heading),
    HYPERTUNA_COLUMN("surge", one, at.plant.xi.x),
    HYPERTUNA_COLUMN("sway", one, at.plant.xi.y),
    HYPERTUNA_COLUMN("yaw", one, at.plant.xi.z),
};

/// The twin's state at the start of a run.
template <class Body>
static TwinStateOf<Body> started(const Twin<Body>& twin, const Input<1>& twist) {
    TwinStateOf<Body> state = at_rest(twin);
    state.plant.xi = {twist.data()[0], twist.data()[1], twist.data()[2]};
    return state;
}

/// Call work with an owned twin of the input's water law and number of coordinates.
template <class Work>
static void with_twin(const PlantInput& in, double tick, int steps, const Work& work) {
    with_free_body(in.model, in.share, in.clamped, [&]<class Law, int D>(FreeBody<Law, D>& own) {
        OwnedTwin<Tail<double, Law, D>> owned(own.tail, in, tick, steps);
        work(owned.twin, std::integral_constant<int, D>());
    });
}

static NamedArrays run_plant(const Model& model, const Input<2>& share, const std::vector<Input<2>>& points,
                             const Input<2>& grid, const Input<2>& circuits, const Input<1>& hinge,
                             const Input<1>& battery, double idle, bool clamped, const Input<1>& twist,
                             const Input<2>& target, double tick, int steps) {
    const PlantInput in{model, share, points, grid, circuits, hinge, battery, idle, clamped};
    check_plant(in);
    check_extent("twist", twist.shape(0), 3);
    check_extent("target", target.shape(1), 2 * points.size());
    NamedArrays out;
    with_twin(in, tick, steps, [&](auto& twin, auto D) {
        const auto go = [&](TwinState<double, D>& state, std::size_t k) {
            return driven_tick(twin, state, target.data() + k * target.shape(1));
        };
        out = record_run(twin, target.shape(0), 1, started(twin, twist), head_columns<D>, go);
    });
    return out;
}

static NamedArrays run_twin(const Model& model, const Input<2>& share, const std::vector<Input<2>>& points,
                            const Input<2>& grid, const Input<2>& circuits, const Input<1>& hinge,
                            const Input<1>& battery, double idle, bool clamped, const Input<1>& twist,
                            const NamedColumns& controller, const NamedColumns& sensors, std::uint64_t seed,
                            const std::vector<FaultRow>& faults, double frequency, const Input<2>& command,
                            double heard, std::size_t ticks, int steps) {
    const PlantInput in{model, share, points, grid, circuits, hinge, battery, idle, clamped};
    check_plant(in);
    check_extent("twist", twist.shape(0), 3);
    const Controller<double> pilot = read_controller<double>(controller);
    const Sensors<double> senses = read_sensors<double>(sensors, seed);
    check_extent("joints", pilot.joints, points.size());
    const std::vector<Fault<double>> failing = read_faults(faults);
    Command<double> wish = read_command(frequency, command, pilot.joints);
    NamedArrays out;
    with_twin(in, pilot.tick, steps, [&](auto& twin, auto D) {
        twin.controller = pilot;
        SensorsState<double> sensing{};
        const auto go = [&](TwinState<double, D>& state, std::size_t k) {
            const double time = pilot.tick * double(k);
            wish.fresh = time < heard;
            return twin_tick(twin, state, wish, [&](const Readings<double>& truth) {
                const auto sensed = sense(senses, sensing, truth, failing.data(), int(failing.size()), time);
                sensing = sensed.state;
                return sensed.readings;
            });
        };
        out = record_run(twin, ticks, 1, started(twin, twist), head_columns<D>, go);
    });
    return out;
}

void bind_twin(nb::module_& m) {
    m.def("tail_acceleration", &tail_accelerations, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("bend"),
          nb::arg("twist"), nb::arg("moment"), nb::arg("clamped"),
          "Accelerations (states, 3 + D) of head and D coordinates, `share` (links, D) of which each joint takes, at "
          "bend (states, 2, D: angle and rate) and twist (states, 3) under moments (states, D) on the coordinates.");
    m.def("run_plant", &run_plant, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("points"),
          nb::arg("grid"), nb::arg("circuits"), nb::arg("hinge"), nb::arg("battery"), nb::arg("idle"),
          nb::arg("clamped"), nb::arg("twist"), nb::arg("target"), nb::arg("tick"), nb::arg("steps"),
          "Drive the servos to targets (ticks, 2 joints), each held for a tick: the record of a run, one row a tick.");
    m.def(
        "run_twin", &run_twin, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("points"), nb::arg("grid"),
        nb::arg("circuits"), nb::arg("hinge"), nb::arg("battery"), nb::arg("idle"), nb::arg("clamped"),
        nb::arg("twist"), nb::arg("controller"), nb::arg("sensors"), nb::arg("seed"), nb::arg("faults"),
        nb::arg("frequency"), nb::arg("command"), nb::arg("heard"), nb::arg("ticks"), nb::arg("steps"),
        "Run plant, sensors and controller under one command, rows amplitude, phase and bias (3, joints), heard until "
        "a time: the record of a run, one row a tick; `ticks` says how many were made.");
}

}  // namespace hypertuna
