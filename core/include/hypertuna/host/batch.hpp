/// Many twins in the plane at once: their machines side by side in lanes, each with its own sensors and controller.
///
/// The twins of a batch have the same structure and differ in numbers: robots, seeds, faults, commands. Each gives
/// the same bits as when it runs alone.
#pragma once

#include <memory>

#include "hypertuna/host/simulate.hpp"

namespace hypertuna {

/// One twin of a batch; plants are shared and must outlive it.
struct BatchMember {
    const PlantData* plant;
    bool clamped;
    Controller<double> controller;
    Instruments instruments;
    SpatialTwist<double> twist;  // twist of the head at the start
};

/// Return why members cannot be one batch, or nothing.
inline std::string check_batch(const std::vector<BatchMember>& members) {
    if (members.empty()) return "batch: must have a twin";
    for (const BatchMember& member : members) {
        const int joints = member.plant->joints;
        if (member.controller.joints != joints) return "controller: must have as many joints as the plant";
        if (member.instruments.sensors.joints != joints) return "sensors: must have as many joints as the plant";
        if (structure_of(*member.plant) != structure_of(*members[0].plant) || member.clamped != members[0].clamped)
            return "batch: all robots must have the same links, joints and water law, in the same world";
        if (member.controller.tick != members[0].controller.tick) return "batch: all must have the same control tick";
    }
    return "";
}

/// A twin in its lane.
template <int D>
struct LaneTwin {
    BatchMember member;
    TwinState<double, D> state;
    SensorsState<double> sensing;
    Tick<double, D> tick;          // the last tick
    PlantState<double, D> before;  // the plant at the last tick's start
    std::uint64_t ticks;

    explicit LaneTwin(BatchMember&& from) : member(std::move(from)) { restart(); }

    void restart() {
        const PlantData& plant = *member.plant;
        state = at_rest<double, D>(member.controller, plant.battery, plant.idle, state_at_rest<D>(plant));
        state.plant.xi = {member.twist.linear.x, member.twist.linear.y, member.twist.angular.z};
        sensing = {}, tick = {}, before = state.plant, ticks = 0;
    }
    double time() const { return member.controller.tick * double(ticks); }

    /// Run sensors and controller on the plant's output at the start of the tick.
    void decide(const Command<double>& command) {
        const auto truth = true_readings<double, D>(member.plant->joints, com(), state, tick.seen);
        tick.readings = member.instruments.read(sensing, truth, time());
        const auto next = step(member.controller, state.controller, tick.readings, command);
        state.controller = next.state;
        tick.output = next.output;
        set_targets(member.controller, tick.output, state);
    }

  private:
    double com() const {
        const Model& model = member.plant->model;
        return model.robot[com_place(model.groups, model.links)];  // center of mass of the head
    }
};

/// A group of twins, one per lane or fewer.
template <int D>
class LaneGroup {
  public:
    LaneGroup(const MachineKernel& kernel, std::vector<LaneTwin<D>*> twins, int steps)
        : kernel_(kernel), twins_(std::move(twins)), machines_(nullptr, kernel.free) {
        std::vector<PlantNumbers> numbers;
        for (const LaneTwin<D>* twin : twins_) numbers.push_back(numbers_of(*twin->member.plant, twin->member.clamped));
        std::vector<const PlantNumbers*> rows;
        for (int k = 0; k < kernel.lanes; ++k) rows.push_back(&numbers[std::min(std::size_t(k), numbers.size() - 1)]);
        machines_.reset(kernel.make(rows.data(), twins_[0]->member.controller.tick, steps));
    }

    /// Make a tick of every twin whose state is physically possible, and count the tick where the state stays so;
    /// command_of(k) is the command of twin k.
    template <class CommandOf>
    void tick(const CommandOf& command_of) {
        static_assert(std::is_standard_layout_v<MachineState<double, D>>);
        MachineState<double, D> unused{};
        MachineTick<double, D> ignored{};
        std::vector<double*>& states = states_;
        states.assign(kernel_.lanes, reinterpret_cast<double*>(&unused));
        ticks_.assign(kernel_.lanes, reinterpret_cast<double*>(&ignored));
        for (std::size_t k = 0; k < twins_.size(); ++k) {
            LaneTwin<D>& twin = *twins_[k];
            if (!plausible(twin.state.plant)) continue;
            MachineState<double, D>& state = twin.state;
            MachineTick<double, D>& tick = twin.tick;
            states[k] = reinterpret_cast<double*>(&state), ticks_[k] = reinterpret_cast<double*>(&tick);
            twin.before = twin.state.plant;
        }
        kernel_.look(machines_.get(), states.data(), ticks_.data());
        for (std::size_t k = 0; k < twins_.size(); ++k)
            if (states[k] != reinterpret_cast<double*>(&unused)) twins_[k]->decide(command_of(k));
        kernel_.follow(machines_.get(), states.data(), ticks_.data());
        for (std::size_t k = 0; k < twins_.size(); ++k)
            twins_[k]->ticks += states[k] != reinterpret_cast<double*>(&unused) && plausible(twins_[k]->state.plant);
    }

  private:
    const MachineKernel& kernel_;
    std::vector<LaneTwin<D>*> twins_;
    std::unique_ptr<void, void (*)(void*)> machines_;
    std::vector<double*> states_, ticks_;
};

// --- runs under one command each

/// Run each member under its own command; records have a row every `every` ticks.
inline std::vector<Record> simulate(const MachineKernel& kernel, std::vector<BatchMember> members,
                                    const std::vector<const GaitCommand*>& commands, const Run& run) {
    std::vector<Record> records(members.size());
    with_coordinates(members[0].plant->coordinates, [&](auto coordinates) {
        constexpr int D = coordinates.value;
        using Columns = TwinColumns<D, InPlane>;
        for (std::size_t first = 0; first < members.size(); first += std::size_t(kernel.lanes)) {
            const std::size_t count = std::min(std::size_t(kernel.lanes), members.size() - first);
            std::vector<LaneTwin<D>> twins;
            for (std::size_t k = 0; k < count; ++k) twins.emplace_back(std::move(members[first + k]));
            std::vector<LaneTwin<D>*> lanes;
            for (LaneTwin<D>& twin : twins) lanes.push_back(&twin);
            LaneGroup<D> group(kernel, lanes, run.steps);
            for (std::size_t k = 0; k < count; ++k)
                Columns::add(records[first + k], (run.ticks + run.every - 1) / run.every, lanes[k]->member.plant->own,
                             lanes[k]->member.plant->joints);
            for (std::size_t t = 0; t < run.ticks; ++t) {
                group.tick([&](std::size_t k) { return command_at(*commands[first + k], run.tick * double(t)); });
                for (std::size_t k = 0; k < count; ++k) {
                    const LaneTwin<D>& twin = *lanes[k];
                    if (twin.ticks != t + 1 && t > 0) continue;
                    Record& record = records[first + k];
                    record.ticks = twin.ticks;
                    if (t % run.every == 0)
                        Columns::write(record, t / run.every, shown(twin.state, twin.before), twin.tick);
                }
            }
        }
    });
    return records;
}

}  // namespace hypertuna
