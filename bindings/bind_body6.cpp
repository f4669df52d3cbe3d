/// Bindings of the body in space.
#include "head_columns.hpp"
#include "space_body.hpp"

namespace hypertuna {

static Output accelerations(const Model& model, const Input<2>& share, const Input<2>& links, const Input<1>& fin,
                            const Input<1>& sea, double shedding, const Input<3>& bend, const Input<2>& twist,
                            const Input<2>& pose, const Input<2>& moment) {
    const SpaceInput in{links, fin, sea, shedding, 0};
    check_space(in, model);
    const std::size_t count = bend.shape(0), coordinates = share.shape(1);
    check_extent("bend", bend.shape(1), 2);
    check_extent("bend", bend.shape(2), coordinates);
    check_extent("twist", twist.shape(0), count);
    check_extent("twist", twist.shape(1), twist_numbers);
    check_extent("pose", pose.shape(0), count);
    check_extent("pose", pose.shape(1), pose_numbers);
    check_extent("moment", moment.shape(0), count);
    check_extent("moment", moment.shape(1), coordinates);
    Output out = zeros({count, twist_numbers + coordinates});
    with_free_body(model, share, false, [&]<class Law, int D>(FreeBody<Law, D>& own) {
        const SpaceBody<Law, D> space(own, in);
        for (std::size_t k = 0; k < count; ++k) {
            Bend<double, D> at;
            const double* row = bend.data() + 2 * D * k;
            std::copy(row, row + D, at.angle);
            std::copy(row + D, row + 2 * D, at.rate);
            double push[D];
            std::copy(moment.data() + D * k, moment.data() + D * (k + 1), push);
            const auto got = body6_acceleration(space.body, at, read_twist(twist.data() + twist_numbers * k),
                                                read_pose(pose.data() + pose_numbers * k), push);
            const auto& [v, w] = got.twist;
            double* to = out.data() + (twist_numbers + D) * k;
            for (double number : {v.x, v.y, v.z, w.x, w.y, w.z}) *to++ = number;
            std::copy(got.bend, got.bend + D, to);
        }
    });
    return out;
}

static NamedArrays run_twin6(const Model& model, const Input<2>& share, const std::vector<Input<2>>& points,
                             const Input<2>& grid, const Input<2>& circuits, const Input<1>& hinge,
                             const Input<1>& battery, double idle, const Input<2>& links, const Input<1>& fin,
                             const Input<1>& sea, double shedding, double antenna, const Input<1>& twist,
                             const Input<1>& pose, const NamedColumns& controller, const NamedColumns& sensors,
                             std::uint64_t seed, const std::vector<FaultRow>& faults, double frequency,
                             const Input<2>& command, const Input<2>& fin_angle, double heard, int steps,
                             std::size_t every) {
    const PlantInput in{model, share, points, grid, circuits, hinge, battery, idle, false};
    const SpaceInput space{links, fin, sea, shedding, antenna};
    check_plant(in);
    check_space(space, model);
    check_extent("twist", twist.shape(0), twist_numbers);
    check_extent("pose", pose.shape(0), pose_numbers);
    check_extent("fin_angle", fin_angle.shape(1), 2);
    if (every < 1) throw nb::value_error("every: must be one tick at least");
    const Controller<double> pilot = read_controller<double>(controller);
    const Sensors<double> senses = read_sensors<double>(sensors, seed);
    check_extent("joints", pilot.joints, points.size());
    const std::vector<Fault<double>> failing = read_faults(faults);
    Command<double> wish = read_command(frequency, command, pilot.joints);
    NamedArrays out;
    with_free_body(model, share, false, [&]<class Law, int D>(FreeBody<Law, D>& own) {
        const SpaceBody<Law, D> body(own, space);
        OwnedTwin<Body6<double, Law, D>> owned(body.body, in, pilot.tick, steps);
        owned.twin.controller = pilot;
        TwinState<double, D, InSpace> start = at_rest(owned.twin);
        start.plant.xi = read_twist(twist.data());
        start.plant.pose = read_pose(pose.data());
        SensorsState<double> sensing{};
        const auto go = [&](TwinState<double, D, InSpace>& state, std::size_t k) {
            const double time = pilot.tick * double(k);
            wish.fresh = time < heard;
            wish.fin[0] = fin_angle.data()[2 * k], wish.fin[1] = fin_angle.data()[2 * k + 1];
            return twin_tick(owned.twin, state, wish, [&](PilotReadings<double> truth) {
                const auto sensed = sense(senses, sensing, truth.robot, failing.data(), int(failing.size()), time);
                sensing = sensed.state;
                truth.robot = sensed.readings;
                return truth;
            });
        };
        out = record_run(owned.twin, fin_angle.shape(0), every, start, head_columns<D>, go);
    });
    return out;
}

template <std::size_t N>
static std::vector<std::string> names(const char* const (&columns)[N]) {
    return {columns, columns + N};
}

void bind_body6(nb::module_& m) {
    m.def("link_body_columns", [] { return names(link_body_columns); }, "Columns of a link's description in space.");
    m.def("fin_columns", [] { return names(fin_columns); }, "Numbers that describe the pectoral fins.");
    m.def("sea_columns", [] { return names(sea_columns); }, "Numbers that describe the sea.");
    m.attr("GRAVITY") = gravity;
    m.def(
        "body6_acceleration", &accelerations, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("links"),
        nb::arg("fin"), nb::arg("sea"), nb::arg("shedding"), nb::arg("bend"), nb::arg("twist"), nb::arg("pose"),
        nb::arg("moment"),
        "Accelerations (states, 6 + D) of the head (linear, then angular, in body axes) and of D coordinates, at bend "
        "(states, 2, D), twist (states, 6), pose (states, 9: position, attitude w x y z, fin angles), under moments "
        "(states, D) on the coordinates. `links`, `fin` and `sea` have the columns that the functions name.");
    m.def("run_twin6", &run_twin6, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("points"),
          nb::arg("grid"), nb::arg("circuits"), nb::arg("hinge"), nb::arg("battery"), nb::arg("idle"), nb::arg("links"),
          nb::arg("fin"), nb::arg("sea"), nb::arg("shedding"), nb::arg("antenna"), nb::arg("twist"), nb::arg("pose"),
          nb::arg("controller"), nb::arg("sensors"), nb::arg("seed"), nb::arg("faults"), nb::arg("frequency"),
          nb::arg("command"), nb::arg("fin_angle"), nb::arg("heard"), nb::arg("steps"), nb::arg("every"),
          "Run plant, sensors and controller in space from a twist and a pose under one command, rows amplitude, phase "
          "and bias (3, joints), heard until a time, and fin angles (ticks, 2): the record of a run, one row every so "
          "many ticks; `ticks` says how many were made.");
}

}  // namespace hypertuna
