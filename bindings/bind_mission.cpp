/// Bindings of a mission: the twin in space under its pilot, part by part.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include <cstring>
#include <optional>
#include <type_traits>

#include "head_columns.hpp"
#include "pilot.hpp"
#include "space_body.hpp"

namespace hypertuna {

/// Everything that a mission goes on from.
template <int D>
struct Underway {
    TwinState<double, D, InSpace> twin;
    PilotState<double> pilot;
    SensorsState<double> sensing;
    double fin[2];  // rad at which a fin's servo stuck
    std::uint64_t ticks;
};

/// What the pilot makes of a tick.
struct PilotColumn {
    const char* name;
    Extent extent;
    double (*of)(const PilotStep<double>&, int);
};
#define HYPERTUNA_PILOT_COLUMN(name, extent, value)                                \
    PilotColumn {                                                                  \
        name, Extent::extent, [](const PilotStep<double>& step, int i) -> double { \
            const Estimate<double>& at = step.estimate;                            \
            return (void)at, (void)step, (void)i, value;                           \
        }                                                                          \
    }
static const PilotColumn pilot_columns[] = {
    HYPERTUNA_PILOT_COLUMN("attitude_estimated", four, number(at.q, i)),
    HYPERTUNA_PILOT_COLUMN("position_estimated", two, i == 0 ? at.x : at.y),
    HYPERTUNA_PILOT_COLUMN("depth_estimated", one, at.depth),
    HYPERTUNA_PILOT_COLUMN("speed_estimated", one, at.speed),
    HYPERTUNA_PILOT_COLUMN("current_estimated", two, at.current[i]),
    HYPERTUNA_PILOT_COLUMN("factor_estimated", one, at.factor),
    HYPERTUNA_PILOT_COLUMN("position_error", one, at.position_error),
    HYPERTUNA_PILOT_COLUMN("frequency_commanded", one, step.command.frequency),
    HYPERTUNA_PILOT_COLUMN("bias_commanded", joints, step.command.bias[i]),
    HYPERTUNA_PILOT_COLUMN("fin_commanded", two, step.command.fin[i]),
    HYPERTUNA_PILOT_COLUMN("mode", one, double(int(step.mode))),
    HYPERTUNA_PILOT_COLUMN("reasons", one, double(step.reasons.flags)),
    HYPERTUNA_PILOT_COLUMN("leg", one, double(step.state.guidance.leg)),
};
#undef HYPERTUNA_PILOT_COLUMN

/// A fin's servo that stands from a time until before another; at its own angle where none is given.
using FinFault = std::tuple<int, double, double, double>;  // fin, rad or NaN, s, s

/// A board in the pilot's place: what the sensors show goes in, servo pulses come out.
using BoardCall = nb::typed<nb::callable, std::vector<double>(std::vector<double>)>;

/// What a mission is flown with.
struct Flight {
    const Pilot<double>& pilot;
    const Mission<double>& mission;
    const Sensors<double>& senses;
    const std::vector<Fault<double>>& faults;
    const std::vector<FinFault>& fins;
    const Input<2>& gaps;
    const std::optional<BoardCall>& board;  // in place of the pilot
};

/// What the sensors show, for a board: every channel that has counts, then east and north of a fix where one came.
static std::vector<double> shown(const PilotReadings<double>& readings, int joints) {
    std::vector<double> out;
    visit_channels([&](const auto& channel, int) {
        const double* first = channel.of(readings);
        if (channel.converter != Converter::none) out.insert(out.end(), first, first + channel.count(joints));
    });
    if (readings.fixed) out.insert(out.end(), readings.fix, readings.fix + 2);
    return out;
}

/// A tick of firmware on a board: it sends pulses, and nothing else is known of it here.
static PilotStep<double> boarded(const Flight& with, const PilotReadings<double>& readings) {
    const nb::gil_scoped_acquire locked;
    const int joints = with.pilot.controller.joints;
    const auto pulse = nb::cast<std::vector<double>>((*with.board)(shown(readings, joints)));
    check_extent("pulses", pulse.size(), std::size_t(2 * joints + 2));
    PilotStep<double> step{};
    std::copy(pulse.begin(), pulse.end(), step.output.pulse);
    return step;
}

/// One tick of a mission.
template <class Law, int D>
static PilotTick<double, D> flown(const Twin<Body6<double, Law, D>>& twin, Underway<D>& on,
                                  TwinState<double, D, InSpace>& state, const Flight& with) {
    const double time = with.pilot.controller.tick * double(on.ticks);
    PilotTick<double, D> out{};
    const auto hear = [&](PilotReadings<double> truth) {
        for (std::size_t k = 0; k < with.gaps.shape(0); ++k)
            if (with.gaps.data()[2 * k] <= time && time < with.gaps.data()[2 * k + 1]) truth.fixed = false;
        const auto sensed = sense(with.senses, on.sensing, truth, with.faults.data(), int(with.faults.size()), time);
        on.sensing = sensed.state;
        return sensed.readings;
    };
    const auto decide = [&](const PilotReadings<double>& readings) {
        out.step = with.board ? boarded(with, readings) : fly(with.pilot, on.pilot, readings, with.mission);
        on.pilot = out.step.state;
        ControllerOutput<double> sent = out.step.output;
        for (const auto& [fin, angle, start, end] : with.fins) {
            if (time < start || end <= time) continue;
            if (time < start + 1.5 * with.pilot.controller.tick)
                on.fin[fin] = std::isnan(angle) ? state.plant.pose.fin[fin] : angle;
            sent.pulse[2 * with.pilot.controller.joints + fin] =
                with.pilot.controller.pulse_center + with.pilot.controller.pulse_per_rad * on.fin[fin];
        }
        return sent;
    };
    out.tick = decided_tick(twin, state, hear, decide);
    ++on.ticks;
    return out;
}

/// Record what the pilot made of a tick in a row.
static void note(std::vector<Output>& record, const PilotStep<double>& step, std::size_t row, std::size_t joints) {
    std::size_t c = 0;
    for (const PilotColumn& column : pilot_columns) {
        const std::size_t extent = extent_of(column.extent, 0, joints);
        for (std::size_t i = 0; i < extent; ++i) record[c].data()[extent * row + i] = column.of(step, int(i));
        ++c;
    }
}

template <class Law, int D>
static NamedArrays fly_on(const Twin<Body6<double, Law, D>>& twin, Underway<D>& on, const Flight& with,
                          std::size_t ticks, std::size_t every) {
    const std::size_t joints = twin.plant.joints, rows = (ticks + every - 1) / every;
    std::vector<Output> record;
    for (const PilotColumn& column : pilot_columns) {
        const std::size_t extent = extent_of(column.extent, D, joints);
        record.push_back(column.extent == Extent::one ? zeros({rows}) : zeros({rows, extent}));
    }
    const auto go = [&](TwinState<double, D, InSpace>& state, std::size_t k) {
        const PilotTick<double, D> tick = flown(twin, on, state, with);
        if (k % every == 0) note(record, tick.step, k / every, joints);
        on.twin = state;
        return tick.tick;
    };
    NamedArrays out = record_run(twin, ticks, every, on.twin, head_columns<D>, go);
    std::size_t c = 0;
    for (const PilotColumn& column : pilot_columns) out[column.name] = record[c++];
    return out;
}

template <int D>
static Underway<D> restored(const nb::bytes& saved) {
    static_assert(std::is_trivially_copyable_v<Underway<D>>);
    if (saved.size() != sizeof(Underway<D>)) throw nb::value_error("state: is none of this mission's");
    Underway<D> on;
    std::memcpy(&on, saved.c_str(), sizeof(on));
    return on;
}

static std::pair<NamedArrays, nb::bytes> run_mission(
    const Model& model, const Input<2>& share, const std::vector<Input<2>>& points, const Input<2>& grid,
    const Input<2>& circuits, const Input<1>& hinge, const Input<1>& battery, double idle, const Input<2>& links,
    const Input<1>& fin, const Input<1>& sea, double shedding, double antenna, const Input<1>& twist,
    const Input<1>& pose, double taken, const NamedColumns& controller, const NamedColumns& pilot,
    const NamedColumns& mission, const Input<2>& waypoints, const Input<2>& fence, const NamedColumns& sensors,
    std::uint64_t seed, const std::vector<FaultRow>& faults, const std::vector<FinFault>& fins, const Input<2>& gaps,
    std::size_t ticks, int steps, std::size_t every, const std::optional<nb::bytes>& state,
    const std::optional<BoardCall>& board) {
    const PlantInput in{model, share, points, grid, circuits, hinge, battery, idle, false};
    const SpaceInput space{links, fin, sea, shedding, antenna};
    check_plant(in);
    check_space(space, model);
    check_extent("twist", twist.shape(0), twist_numbers);
    check_extent("pose", pose.shape(0), pose_numbers);
    check_extent("gaps", gaps.shape(1), 2);
    if (every < 1) throw nb::value_error("every: must be one tick at least");
    for (const FinFault& fault : fins)
        if (std::get<0>(fault) < 0 || std::get<0>(fault) > 1) throw nb::value_error("fins: must be fin 0 or 1");
    const Pilot<double> flying = read_pilot<double>(controller, pilot);
    const OwnedMission<double> plan(mission, waypoints, fence);
    const Sensors<double> senses = read_sensors<double>(sensors, seed, Reader::pilot);
    check_extent("joints", flying.controller.joints, points.size());
    const std::vector<Fault<double>> failing = read_faults(faults);
    const Flight with{flying, plan.mission, senses, failing, fins, gaps, board};
    std::pair<NamedArrays, nb::bytes> out{NamedArrays(), nb::bytes("", 0)};
    with_free_body(model, share, false, [&]<class Law, int D>(FreeBody<Law, D>& own) {
        const SpaceBody<Law, D> body(own, space);
        OwnedTwin<Body6<double, Law, D>> owned(body.body, in, flying.controller.tick, steps);
        owned.twin.controller = flying.controller;
        Underway<D> on{};
        if (state) {
            on = restored<D>(*state);
        } else {
            on.twin = at_rest(owned.twin);
            on.twin.taken = taken;
            on.twin.battery = battery_output(owned.twin.battery, taken, owned.twin.idle);
            on.twin.plant.xi = read_twist(twist.data());
            on.twin.plant.pose = read_pose(pose.data());
            on.pilot = init(flying, plan.mission);
        }
        NamedArrays record = fly_on(owned.twin, on, with, ticks, every);
        out = {record, nb::bytes(reinterpret_cast<const char*>(&on), sizeof(on))};
    });
    return out;
}

void bind_mission(nb::module_& m) {
    m.def(
        "run_mission", &run_mission, nb::arg("model"), nb::arg("share"), nb::kw_only(), nb::arg("points"),
        nb::arg("grid"), nb::arg("circuits"), nb::arg("hinge"), nb::arg("battery"), nb::arg("idle"), nb::arg("links"),
        nb::arg("fin"), nb::arg("sea"), nb::arg("shedding"), nb::arg("antenna"), nb::arg("twist"), nb::arg("pose"),
        nb::arg("taken"), nb::arg("controller"), nb::arg("pilot"), nb::arg("mission"), nb::arg("waypoints"),
        nb::arg("fence"), nb::arg("sensors"), nb::arg("seed"), nb::arg("faults"), nb::arg("fins"), nb::arg("gaps"),
        nb::arg("ticks"), nb::arg("steps"), nb::arg("every"), nb::arg("state") = nb::none(),
        nb::arg("board") = nb::none(),
        "Fly a mission for so many ticks, from its start (twist (6), pose (9), charge taken [C]) or from a state that "
        "an earlier part left: the record, one row every so many ticks, and the state at the end. `fins` are servos "
        "that stand, (fin, angle [rad] or NaN for where it is, from, to [s]); `gaps` (n, 2) times without satellites. "
        "`board` takes the pilot's place: a function of what the sensors show (bends, pressures, currents, rates, "
        "accelerations, battery, depth, field, and a fix where one came) that returns the servo pulses [s].");
}

}  // namespace hypertuna
