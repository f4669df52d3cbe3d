/// Bindings of body, plant, world and simulation.
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "controller.hpp"
#include "plant6.hpp"
#include "records.hpp"

namespace hypertuna {

static std::vector<std::tuple<std::string, std::string, std::string>> loss_table() {
#define HYPERTUNA_EACH(name, from, sentence) {#name, from, sentence},
    return {HYPERTUNA_LOSSES(HYPERTUNA_EACH)};
#undef HYPERTUNA_EACH
}

/// Accelerations of head and coordinates at given states.
static Output accelerations(const BodyData& data, const World& world, const Input<3>& bend, const Input<2>& twist,
                            const Input<2>& pose, const Input<2>& moment) {
    const std::size_t count = bend.shape(0), coordinates = std::size_t(data.own);
    check(check_world(data, world));
    check_extent("bend", bend.shape(1), 2);
    check_extent("bend", bend.shape(2), coordinates);
    check_extent("twist", twist.shape(0), count);
    check_extent("twist", twist.shape(1), twist_numbers);
    check_extent("pose", pose.shape(0), count);
    check_extent("pose", pose.shape(1), pose_numbers);
    check_extent("moment", moment.shape(0), count);
    check_extent("moment", moment.shape(1), coordinates);
    Output out = zeros({count, twist_numbers + coordinates});
    with_body(data, world, [&]<class Body>(const Body& body) {
        constexpr int D = Body::coordinates;
        for (std::size_t k = 0; k < count; ++k) {
            Bend<double, D> at{};
            double push[D] = {};
            for (std::size_t d = 0; d < coordinates; ++d) {
                at.angle[d] = bend.data()[2 * coordinates * k + d];
                at.rate[d] = bend.data()[2 * coordinates * k + coordinates + d];
                push[d] = moment.data()[coordinates * k + d];
            }
            const SpatialTwist<double> xi = read_twist(twist.data() + twist_numbers * k);
            double* to = out.data() + (twist_numbers + coordinates) * k;
            if constexpr (std::is_same_v<typename Body::Space, InPlane>) {
                const auto got = tail_acceleration(body, at, in_plane(xi), push);
                to[0] = got.twist.x, to[1] = got.twist.y, to[5] = got.twist.z;
                std::copy_n(got.bend, coordinates, to + twist_numbers);
            } else {
                const auto got = body6_acceleration(body, at, xi, read_pose(pose.data() + pose_numbers * k), push);
                const auto& [v, w] = got.twist;
                for (double number : {v.x, v.y, v.z, w.x, w.y, w.z}) *to++ = number;
                std::copy_n(got.bend, coordinates, to);
            }
        }
    });
    return out;
}

static NamedArrays simulate_targets(const PlantData& plant, const Input<2>& targets, const World& world,
                                    const Input<1>& twist, double tick, int steps) {
    const Run run = run_of(targets.shape(0), 1, tick, steps, twist, std::nullopt, 0);
    check(check_targets(plant, world, run, targets.shape(0), targets.shape(1)));
    Record record;
    {
        const nb::gil_scoped_release unlocked;
        record = simulate(plant, targets.data(), world, run);
    }
    return arrays_of(std::move(record));
}

static NamedArrays simulate_command(const PlantData& plant, const GaitCommand& command, const World& world,
                                    const LiveSensors& sensors, const std::vector<FaultRow>& faults,
                                    const Input<1>& twist, const std::optional<Input<1>>& pose, std::size_t ticks,
                                    int steps, std::size_t every) {
    const Run run = run_of(ticks, every, command.controller.tick, steps, twist, pose, 0);
    const Instruments instruments{sensors.model, read_faults(faults)};
    check(check_command(plant, command, world, instruments, run));
    Record record;
    {
        const nb::gil_scoped_release unlocked;
        record = simulate(plant, command, world, instruments, run);
    }
    return arrays_of(std::move(record));
}

/// A board in the pilot's place: what the sensors show goes in, servo pulses come out.
using BoardCall = nb::typed<nb::callable, std::vector<double>(std::vector<double>, double)>;

/// Readings for a board: every channel that has counts, then east, north and accuracy of a fix where one came.
static std::vector<double> shown(const PilotReadings<double>& readings, int joints) {
    std::vector<double> out;
    visit_channels([&](const auto& channel, int) {
        const double* first = channel.of(readings);
        if (channel.converter != Converter::none) out.insert(out.end(), first, first + channel.count(joints));
    });
    if (readings.fixed) out.insert(out.end(), {readings.fix[0], readings.fix[1], readings.accuracy});
    return out;
}

using ServoFaultRow = std::tuple<int, double, double, double>;  // servo, rad or NaN, s, s
using OilLossRow = std::tuple<int, double, double>;             // circuit, s, s

static std::pair<NamedArrays, nb::bytes> simulate_pilot(
    const PlantData& plant, const LivePilot& pilot, const World& world, const LiveSensors& sensors,
    const std::vector<FaultRow>& faults, const std::vector<ServoFaultRow>& servo_faults,
    const std::vector<OilLossRow>& oil_losses, const Input<1>& twist, const Input<1>& pose, double charge,
    std::size_t ticks, int steps, std::size_t every, const std::optional<nb::bytes>& state,
    const std::optional<BoardCall>& board) {
    const int joints = pilot.model.controller.joints;
    Flight flight{pilot.model, pilot.mission.mission, {}, {}, {}};
    for (const auto& [servo, angle, start, end] : servo_faults)
        flight.servo_faults.push_back({servo, angle, start, end});
    for (const auto& [circuit, start, end] : oil_losses) flight.oil_losses.push_back({circuit, start, end});
    if (board)
        flight.board = [&](const PilotReadings<double>& readings, double antenna, double* pulse) {
            const nb::gil_scoped_acquire locked;
            const auto sent = nb::cast<std::vector<double>>((*board)(shown(readings, joints), antenna));
            check_extent("pulses", sent.size(), std::size_t(servos_of(joints)));
            std::copy(sent.begin(), sent.end(), pulse);
        };
    const Run run = run_of(ticks, every, pilot.model.controller.tick, steps, twist, pose, charge);
    const Instruments instruments{sensors.model, read_faults(faults)};
    std::vector<char> saved;
    if (state) saved.assign(state->c_str(), state->c_str() + state->size());
    check(check_flight(plant, flight, world, instruments, saved.size()));
    Record record;
    {
        const nb::gil_scoped_release unlocked;
        record = simulate(plant, flight, world, instruments, run, saved);
    }
    return {arrays_of(std::move(record)), nb::bytes(saved.data(), saved.size())};
}

void bind_simulation(nb::module_& m) {
    m.attr("GRAVITY") = gravity;
    nb::class_<World>(m, "World", "A bench, the plane of still water, or a sea. Immutable.")
        .def(
            "__init__",
            [](World* self, const Mapping& columns) {
                new (self) World(take(load_world(MappedColumns(columns).columns)));
            },
            nb::arg("columns"),
            "From `clamped` (0 or 1: the head is held still), `gaps` (n, 2: times without satellites [s]), `resets` "
            "(n: "
            "times at which the receiver restarts [s]), `released` (s until which someone holds the robot at its "
            "start), and the columns `sea.NAME`, `weather.NAME` and "
            "`receiver.NAME`, each of which may be left out: without a sea the plane of still water.");
    nb::class_<BodyData>(m, "Body", "What of a robot moves in the water. Immutable.")
        .def(
            "__init__",
            [](BodyData* self, const Model& model, const Mapping& columns) {
                new (self) BodyData(take(load_body(model, MappedColumns(columns).columns)));
            },
            nb::arg("model"), nb::arg("columns"),
            "From `share` (links, D) of which each front joint takes of D coordinates; to be at sea, too, `link.NAME` "
            "(links), `fin.NAME`, `shedding` and `antenna`.")
        .def("accelerations", &accelerations, nb::arg("world"), nb::kw_only(), nb::arg("bend"), nb::arg("twist"),
             nb::arg("pose"), nb::arg("moment"),
             "Accelerations (states, 6 + D) of the head (linear, then angular, in body axes) and of D coordinates, at "
             "bend (states, 2, D: angle and rate), twist (states, 6) and pose (states, 9: position, attitude w x y z, "
             "fin angles), under moments (states, D) on the coordinates.");
    nb::class_<PlantData, BodyData>(m, "Plant", "All of a robot that obeys physics alone. Immutable.")
        .def(
            "__init__",
            [](PlantData* self, const Model& model, const Mapping& columns) {
                new (self) PlantData(take(load_plant(model, MappedColumns(columns).columns)));
            },
            nb::arg("model"), nb::arg("columns"),
            "From the columns of Body, `joints`, `joint.NAME` "
            "(joints), `circuit.NAME` (2 joints), `battery.NAME`, `idle` [W], and `spring.NAME` of the hinges.")
        .def_prop_ro("structure", &structure_of, "Plants with the same one differ in numbers alone.");
    nb::class_<GaitCommand>(m, "GaitCommand", "A command to a controller. Immutable.")
        .def(
            "__init__",
            [](GaitCommand* self, const LiveController& controller, const Mapping& columns, double lost_at) {
                new (self) GaitCommand(take(load_command(controller.model, MappedColumns(columns).columns, lost_at)));
            },
            nb::arg("controller"), nb::arg("columns"), nb::kw_only(), nb::arg("lost_at"),
            "From `frequency`, `amplitude`, `phase` and `bias` (joints), and `fin` (ticks, 2) at sea, until the "
            "command "
            "is lost [s].")
        .def_prop_ro("tick", [](const GaitCommand& self) { return self.controller.tick; }, "Control tick [s].");
    m.def("loss_table", &loss_table,
          "Losses of a twin in the order of the power's way to the water: name, what it is taken from, sentence.");
    m.def("simulate", &simulate_targets, nb::arg("plant"), nb::arg("command"), nb::arg("world"), nb::kw_only(),
          nb::arg("twist"), nb::arg("tick"), nb::arg("steps"),
          "Drive the servos to targets (ticks, 2 joints), each held for a tick, from a twist (6): the record of a run, "
          "one row per tick; `ticks` has how many were made.");
    m.def("simulate", &simulate_command, nb::arg("plant"), nb::arg("command"), nb::arg("world"), nb::kw_only(),
          nb::arg("sensors"), nb::arg("faults"), nb::arg("twist"), nb::arg("pose") = nb::none(), nb::arg("ticks"),
          nb::arg("steps"), nb::arg("every") = 1,
          "Run plant, sensors and controller under one command from a twist (6) and, at sea, a pose (9): the record, "
          "one row every `every` ticks. Faults are (kind, first channel, last channel, start, end) [s].");
    m.def(
        "simulate", &simulate_pilot, nb::arg("plant"), nb::arg("command"), nb::arg("world"), nb::kw_only(),
        nb::arg("sensors"), nb::arg("faults"), nb::arg("servo_faults"), nb::arg("oil_losses"), nb::arg("twist"),
        nb::arg("pose"), nb::arg("charge"), nb::arg("ticks"), nb::arg("steps"), nb::arg("every"),
        nb::arg("state") = nb::none(), nb::arg("board") = nb::none(),
        "Fly a pilot's mission from its start (twist (6), pose (9), charge taken [C]) or from a state that an earlier "
        "part left: the record and the state at the end. `servo_faults` are servos that stand, (servo in the order "
        "of the pulses, angle [rad] or NaN for where it is, from, to [s]), `oil_losses` circuits with a hole, "
        "(circuit, "
        "from, to [s]). `board` takes the pilot's place: a function of what the sensors show (bends, "
        "pressures, currents, rates, accelerations, battery, depth, field, and a fix where one came) and of the height "
        "of its antenna above the surface [m] that returns the servo pulses [s].");
}

}  // namespace hypertuna
