/// Simulate a plant in a world: with given servo targets, under a controller with a command, or under a pilot.
///
/// `simulate(plant, command, world, ...)` has one form for each. Plant and command are shared and never changed; a call
/// keeps all state. These functions trust their input: the checks stand beside them and return sentences.
#pragma once

#include <cstring>
#include <functional>

#include "hypertuna/host/controller.hpp"
#include "hypertuna/host/plant.hpp"
#include "hypertuna/host/record.hpp"

namespace hypertuna {

/// Start and length of a run.
struct Run {
    std::size_t ticks, every;    // control ticks, and ticks from one row of the record to the next
    double tick;                 // s
    int steps;                   // Runge-Kutta steps of a tick
    SpatialTwist<double> twist;  // twist of the head at the start
    Pose6<double> pose;          // pose at the start, in space; in the plane the nose starts at the origin
    double charge;               // C taken from the battery before the start
};

/// Sensors with their errors and faults.
struct Instruments {
    Sensors<double> sensors;
    std::vector<Fault<double>> faults;

    /// Sensor readings of true values, of the robot alone or also of the pilot.
    template <class R>
    R read(SensorsState<double>& state, const R& truth, double time) const {
        const auto sensed = sense(sensors, state, truth, faults.data(), int(faults.size()), time);
        state = sensed.state;
        return sensed.readings;
    }
};

/// One tick of a twin under a command; `instruments` turn the true values into sensor readings.
template <class Body>
TickOf<Body> command_tick(const Twin<Body>& twin, TwinStateOf<Body>& state, const Command<double>& command,
                          const Instruments& instruments, SensorsState<double>& sensing, double time) {
    return twin_tick(twin, state, command, [&](auto truth) {
        if constexpr (std::is_same_v<typename Body::Space, InPlane>)
            truth = instruments.read(sensing, truth, time);
        else
            truth.robot = instruments.read(sensing, truth.robot, time);
        return truth;
    });
}

/// A command that holds from a time on.
struct TimedCommand {
    double since;  // s
    Command<double> command;
};

/// Commands to a controller, one after another.
struct GaitCommand {
    Controller<double> controller;
    std::vector<TimedCommand> commands;  // one or more, in order of time
    std::vector<double> fin;             // ticks x 2: rad; empty where there are no fins
    double lost_at;                      // s from which no command arrives
};

/// Commands from `since`, `armed` (0 or 1), `frequency`, `amplitude`, `phase` and `bias` (commands, joints), and `fin`
/// (ticks, 2) where there are fins.
inline Loaded<GaitCommand> load_command(const Controller<double>& controller, const NamedColumns& columns,
                                        double lost_at) {
    ColumnReader in(columns);
    GaitCommand out{controller, {}, {}, lost_at};
    const NamedColumn* const since = in.find("since");
    const std::size_t count = since ? since->rows : 0, joints = std::size_t(controller.joints);
    if (count == 0) in.refuse("since: must have a command");
    out.commands.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
        auto& [from, command] = out.commands[k];
        from = in.number("since", k);
        command.frequency = in.number("frequency", k);
        command.armed = in.number("armed", k) != 0;
        for (const auto& [name, to] : {std::pair("amplitude", command.amplitude), std::pair("phase", command.phase),
                                       std::pair("bias", command.bias)}) {
            const std::vector<double> values = in.numbers(name, count, joints);
            std::copy_n(values.begin() + std::ptrdiff_t(k * joints), joints, to);
        }
    }
    if (const NamedColumn* fin = in.find("fin")) out.fin = in.numbers("fin", fin->rows, 2);
    return in.loaded(std::move(out));
}

/// The command at a time.
inline Command<double> command_at(const GaitCommand& given, double time) {
    std::size_t at = 0;
    while (at + 1 < given.commands.size() && given.commands[at + 1].since <= time) ++at;
    Command<double> now = given.commands[at].command;
    now.fresh = time < given.lost_at;
    return now;
}

/// State of a twin at the start of a run: at rest, except for what the run gives.
template <class Body>
TwinStateOf<Body> start_of(const Twin<Body>& twin, const Run& run) {
    TwinStateOf<Body> state = at_rest(twin);
    if constexpr (std::is_same_v<typename Body::Space, InPlane>) {
        state.plant.xi = {run.twist.linear.x, run.twist.linear.y, run.twist.angular.z};
    } else {
        state.plant.xi = run.twist;
        state.plant.pose = run.pose;
    }
    state.taken = run.charge;
    state.battery = battery_output(twin.battery, run.charge, twin.idle);
    return state;
}

/// State for a row of the record: the plant at the tick's start, the rest after the tick.
template <class State, class PlantState>
State shown(State after, const PlantState& start) {
    after.plant = start;
    return after;
}

/// Run and record a twin, until before a tick whose state would be physically impossible; if it is the first one, it is
/// recorded, but not counted. go(state, k) makes tick k.
template <class Body, class Go>
Record record_run(const PlantData& plant, TwinStateOf<Body> state, const Run& run, const Go& go) {
    using Columns = TwinColumns<Body::coordinates, typename Body::Space>;
    Record record;
    Columns::add(record, (run.ticks + run.every - 1) / run.every, plant.own, plant.joints);
    for (bool whole = plausible(state.plant); record.ticks < run.ticks && whole; record.ticks += whole) {
        const PlantStateOf<Body> start = state.plant;
        const TickOf<Body> tick = go(state, record.ticks);
        whole = plausible(state.plant);
        if ((!whole && record.ticks > 0) || record.ticks % run.every != 0) continue;
        Columns::write(record, record.ticks / run.every, shown(state, start), tick);
    }
    return record;
}

// --- the servos alone, in the plane

/// Return why servo targets (ticks, 2 joints) cannot be simulated; empty where they can.
inline std::string check_targets(const PlantData& plant, const World& world, const Run& run, std::size_t ticks,
                                 std::size_t circuits) {
    if (world.sea) return "world: servo targets are simulated in the plane";
    if (circuits != 2 * std::size_t(plant.joints)) return "targets: must have one column per circuit";
    return ticks < run.ticks ? "targets: must have one row per tick" : "";
}

/// Drive the servos to targets (ticks, 2 joints) [rad], each held for a tick.
inline Record simulate(const PlantData& plant, const double* targets, const World& world, const Run& run) {
    Record record;
    with_body(plant, world, [&]<class Body>(const Body& body) {
        if constexpr (std::is_same_v<typename Body::Space, InPlane>) {
            const Twin<Body> twin = make_twin(plant, body, run.tick, run.steps);
            record = record_run<Body>(plant, start_of(twin, run), run, [&](TwinStateOf<Body>& state, std::size_t k) {
                return driven_tick(twin, state, targets + 2 * plant.joints * k);
            });
        }
    });
    return record;
}

// --- a controller under one command, in the plane or at sea

/// Return why a command cannot be simulated; empty where it can.
inline std::string check_command(const PlantData& plant, const GaitCommand& command, const World& world,
                                 const Instruments& instruments, const Run& run) {
    if (command.controller.joints != plant.joints) return "controller: must have as many joints as the plant";
    if (instruments.sensors.joints != plant.joints) return "sensors: must have as many joints as the plant";
    if (world.sea && command.fin.size() < 2 * run.ticks) return "fin: must have one row per tick";
    return check_world(plant, world);
}

/// Run plant, sensors and controller under one command.
inline Record simulate(const PlantData& plant, const GaitCommand& command, const World& world,
                       const Instruments& instruments, const Run& run) {
    Record record;
    with_body(plant, world, [&]<class Body>(const Body& body) {
        Twin<Body> twin = make_twin(plant, body, run.tick, run.steps);
        twin.controller = command.controller;
        SensorsState<double> sensing{};
        const auto go = [&](TwinStateOf<Body>& state, std::size_t k) {
            const double time = run.tick * double(k);
            Command<double> now = command_at(command, time);
            for (std::size_t f = 0; f < 2 && !command.fin.empty(); ++f) now.fin[f] = command.fin[2 * k + f];
            return command_tick(twin, state, now, instruments, sensing, time);
        };
        record = record_run<Body>(plant, start_of(twin, run), run, go);
    });
    return record;
}

// --- a pilot on its mission, at sea

/// A servo, by its place among the pulses, that does not move from `start` to `end`; it stays where it is if no angle
/// is given.
struct ServoFault {
    int servo;
    double angle;       // rad or NaN
    double start, end;  // s
};

/// A circuit with a hole, through which its units lose oil to the water and draw water, from `start` to `end`.
struct OilLoss {
    int circuit;
    double start, end;  // s
};
inline constexpr double hole =
    2e-10;  // m^3/(s Pa), flow through the hole: a filled circuit loses its pressure in some tenths of a second

/// A board in the pilot's place: readings and the height of its antenna above the surface [m] in, servo pulses [s] out.
using Board = std::function<void(const PilotReadings<double>&, double antenna, double* pulse)>;

/// A pilot with its mission, faults, and a board in the pilot's place where there is one.
struct Flight {
    const Pilot<double>& pilot;
    const Mission<double>& mission;
    std::vector<ServoFault> servo_faults;
    std::vector<OilLoss> oil_losses;
    Board board;
};

/// Complete state of a flight, from which it can continue.
template <int D>
struct FlightState {
    TwinState<double, D, InSpace> twin;
    PilotState<double> pilot;
    SensorsState<double> sensing;
    ReceiverState<double> receiver;
    double servo[2 * D + 2];  // rad at which a faulty servo stands
    double spilled[2 * D];    // m^3 of oil that each circuit has lost
    Vector<double> snagged;   // m: place where a line caught the nose
    std::uint64_t ticks;
};

/// Return why a flight cannot be simulated, from its start or from a saved state of `size` bytes; empty where it can.
inline std::string check_flight(const PlantData& plant, const Flight& flight, const World& world,
                                const Instruments& instruments, std::size_t size) {
    if (!world.sea) return "world: a pilot needs a sea";
    if (flight.pilot.controller.joints != plant.joints) return "controller: must have as many joints as the plant";
    if (instruments.sensors.joints != plant.joints) return "sensors: must have as many joints as the plant";
    for (const ServoFault& fault : flight.servo_faults)
        if (fault.servo < 0 || servos_of(plant.joints) <= fault.servo) return "servo_faults: must be of a servo";
    for (const OilLoss& loss : flight.oil_losses)
        if (loss.circuit < 0 || 2 * plant.joints <= loss.circuit || plant.direct[std::size_t(loss.circuit / 2)])
            return "oil_losses: must be of a circuit with oil";
    bool fits = size == 0;
    with_coordinates(plant.coordinates, [&](auto d) { fits = fits || size == sizeof(FlightState<d.value>); });
    return fits ? check_world(plant, world) : "state: must be one of this mission's";
}

/// Fix of the satellite receiver in a tick; `dry` is whether the antenna is out of the water.
inline Reception<double> receive(const World& world, ReceiverState<double>& state, bool dry, double time, double tick,
                                 std::uint64_t seed) {
    for (const double reset : world.resets)
        if (reset <= time && time < reset + tick) state = switched_on(world.receiver, seed, state.losses + 1);
    bool sky = dry;
    for (std::size_t k = 0; k + 1 < world.gaps.size(); k += 2)
        sky = sky && !(world.gaps[k] <= time && time < world.gaps[k + 1]);
    return receive(world.receiver, state, sky, tick, time, seed);
}

/// A flight at its start.
template <class Law, int D>
FlightState<D> start_flight(const Twin<Body6<double, Law, D>>& twin, const Flight& flight, const World& world,
                            const Instruments& instruments, const Run& run) {
    FlightState<D> on{};
    static_assert(std::is_trivially_copyable_v<FlightState<D>>);
    on.twin = start_of(twin, run);
    on.pilot = init(flight.pilot, flight.mission);
    // A robot that begins under water was switched on at the surface.
    if (on.twin.plant.pose.position.z < 0) keep_zero(on.pilot.estimator, depth_shown(*world.sea, 0.0));
    on.receiver = init(world.receiver, instruments.sensors.seed);
    return on;
}

/// Apply the lines that hold the nose, each at the place where the nose was when the line caught it.
template <int D>
void snag(Sea<double>& sea, FlightState<D>& on, const Vector<double>& nose, const World& world, double time,
          double tick) {
    for (std::size_t k = 0; k + 2 < world.snags.size(); k += 3) {
        const double *line = &world.snags[k], start = line[0];
        if (time < start || line[1] <= time) continue;
        if (time < start + tick) on.snagged = nose;
        sea.snag = {snag_stiffness, line[2], on.snagged};
    }
}

/// A plant's circuits without the oil that they have lost.
inline std::vector<Circuit<double>> filled(const PlantData& plant, const double* spilled) {
    std::vector<Circuit<double>> circuits = plant.circuit;
    for (std::size_t c = 0; c < circuits.size(); ++c) circuits[c].oil_unit -= spilled[c];
    return circuits;
}

/// Let oil flow through the holes of the units' side for a tick, at the pressures of its start.
template <class Plant, class State>
void spill(Circuit<double>* circuits, const Plant& plant, const State& at, const Flight& flight, double* spilled,
           double time, double tick) {
    for (const auto& [c, start, end] : flight.oil_losses) {
        Circuit<double>& circuit = circuits[c];
        if (start <= time && time < end) {
            const int j = c / 2;
            const JointOil<double> oil{plant.circuit + 2 * j, at.circuit + 2 * j, plant.unit_rest + 2 * j};
            const auto load = joint_load(plant.joint[j], at.bend.angle[j], at.strain[j], oil);
            const double pressure =
                unit_pressure(circuit, at.circuit[c], load.volume[c % 2] - plant.unit_rest[c]).pressure;
            const double flow = hole * pressure * tick;
            circuit.oil_unit -= flow, spilled[c] += flow;
        }
    }
}

/// One tick of a flight; `circuits` are the plant's, from which oil is lost.
template <class Law, int D>
PilotTick<double, D> flight_tick(Twin<Body6<double, Law, D>>& twin, FlightState<D>& on,
                                 TwinState<double, D, InSpace>& state, const Flight& flight, const World& world,
                                 const Instruments& instruments, Circuit<double>* circuits = nullptr) {
    const Controller<double>& controller = flight.pilot.controller;
    const double time = controller.tick * double(on.ticks);
    PilotTick<double, D> out{};
    const std::uint64_t seed = instruments.sensors.seed;
    const bool held = time < world.released;
    const PlantState<double, D, InSpace> start = state.plant;
    twin.plant.body.sea = sea_at(*world.sea, world.weather, seed, time);
    snag(twin.plant.body.sea, on, state.plant.pose.position, world, time, controller.tick);
    spill(circuits, twin.plant, state.plant, flight, on.spilled, time, controller.tick);
    const double antenna = antenna_height(twin.plant.body, state.plant.pose);
    const auto read = [&](PilotReadings<double> truth) {
        const Reception<double> got = receive(world, on.receiver, truth.fixed, time, controller.tick, seed);
        truth.fixed = got.fixed;
        const double noise = instruments.sensors.model[channel_kind("position")].noise;
        // Not std::hypot, which libraries round differently.
        truth.accuracy = sqrt(noise * noise + got.reported * got.reported);
        for (int k = 0; k < 2; ++k) truth.fix[k] += got.error[k];
        if (held) {  // the IMU shows only gravity
            const Vector<double> up = gravity * rotation(start.pose.attitude).up;
            truth.robot.acceleration[0] = up.x, truth.robot.acceleration[1] = up.y, truth.robot.acceleration[2] = up.z;
        }
        return instruments.read(on.sensing, truth, time);
    };
    const auto decide = [&](const PilotReadings<double>& readings) {
        if (flight.board)
            flight.board(readings, antenna, out.step.output.pulse);
        else
            out.step = fly(flight.pilot, on.pilot, readings, flight.mission);
        on.pilot = out.step.state;
        ControllerOutput<double> sent = out.step.output;
        for (const auto& [servo, angle, start, end] : flight.servo_faults) {
            if (time < start || end <= time) continue;
            const int fin = servo - 2 * controller.joints;
            const double present = 0 <= fin ? state.plant.pose.fin[fin] : state.plant.circuit[servo].angle;
            if (time < start + 1.5 * controller.tick) on.servo[servo] = std::isnan(angle) ? present : angle;
            sent.pulse[servo] = controller.pulse_center + controller.pulse_per_rad * on.servo[servo];
        }
        return sent;
    };
    out.tick = decided_tick(twin, state, read, decide);
    if (held) state.plant.xi = start.xi, state.plant.pose = start.pose;
    ++on.ticks;
    return out;
}

/// Fly a mission from its start where `saved` is empty, else from the saved state, which then becomes that of the end.
inline Record simulate(const PlantData& plant, const Flight& flight, const World& world, const Instruments& instruments,
                       const Run& run, std::vector<char>& saved) {
    Record record, piloted;
    with_body(plant, world, [&]<class Body>(const Body& body) {
        if constexpr (std::is_same_v<typename Body::Space, InSpace>) {
            constexpr int D = Body::coordinates;
            Twin<Body> twin = make_twin(plant, body, run.tick, run.steps);
            twin.controller = flight.pilot.controller;
            FlightState<D> on = start_flight(twin, flight, world, instruments, run);
            if (!saved.empty()) std::memcpy(&on, saved.data(), sizeof(on));
            std::vector<Circuit<double>> circuits = filled(plant, on.spilled);
            twin.plant.circuit = circuits.data();
            add_columns(piloted, pilot_columns, (run.ticks + run.every - 1) / run.every, plant.own, plant.joints);
            record = record_run<Body>(plant, on.twin, run, [&](TwinStateOf<Body>& state, std::size_t k) {
                const PilotTick<double, D> tick =
                    flight_tick(twin, on, state, flight, world, instruments, circuits.data());
                if (k % run.every == 0) write_row(piloted, 0, pilot_columns, k / run.every, tick.step);
                on.twin = state;
                return tick.tick;
            });
            saved.resize(sizeof(on));
            std::memcpy(saved.data(), &on, sizeof(on));
        }
    });
    for (RecordColumn& column : piloted.columns) record.columns.push_back(std::move(column));
    return record;
}

}  // namespace hypertuna
