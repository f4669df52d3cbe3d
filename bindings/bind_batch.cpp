/// Bindings of many twins at once.
#include <nanobind/stl/tuple.h>

#include <atomic>
#include <thread>

#include "hypertuna/host/batch.hpp"
#include "records.hpp"

namespace hypertuna {

/// Plant, command, world, sensors, faults and twist (6) of a run.
using RunRow =
    std::tuple<const PlantData*, const GaitCommand*, const World*, const LiveSensors*, std::vector<FaultRow>, Input<1>>;

static BatchMember member_of(const PlantData& plant, const Controller<double>& controller, bool clamped,
                             const LiveSensors& sensors, std::vector<Fault<double>> faults,
                             const SpatialTwist<double>& twist) {
    return {&plant, clamped, controller, {sensors.model, std::move(faults)}, twist};
}

static std::vector<NamedArrays> simulate_batch(const std::vector<RunRow>& rows, std::size_t ticks, int steps) {
    std::vector<BatchMember> members;
    std::vector<const GaitCommand*> commands;
    for (const auto& [plant, command, world, sensors, faults, twist] : rows) {
        check_extent("twist", twist.shape(0), twist_numbers);
        if (world->sea) throw nb::value_error("world: a batch moves in the plane");
        members.push_back(member_of(*plant, command->controller, world->clamped, *sensors, read_faults(faults),
                                    read_twist(twist.data())));
        commands.push_back(command);
    }
    check(check_batch(members));
    if (steps < 1) throw nb::value_error("steps: must be one or more");
    const Run run{ticks, 1, members[0].controller.tick, steps, {}, {}, 0};
    std::vector<Record> records;
    {
        const nb::gil_scoped_release unlocked;
        records = simulate(*kernel().machines, std::move(members), commands, run);
    }
    std::vector<NamedArrays> out;
    for (Record& record : records) out.push_back(arrays_of(std::move(record)));
    return out;
}

/// Twins that are simulated together, under commands that may change at any time.
class Batch {
  public:
    std::vector<Command<double>> commands;  // command of each twin
    Record now;                             // one row per twin: its state, and its last tick
    std::vector<double> energy;             // J, electrical energy that each twin has drawn since its start
    std::vector<double> lost;               // 1 where the state is physically impossible: that twin stands still

    virtual ~Batch() = default;
    /// Return a batch that continues from the same state.
    virtual std::unique_ptr<Batch> copy() const = 0;
    virtual std::size_t groups() const = 0;
    /// Make ticks of the twins of a group; groups may be advanced by several threads.
    virtual void advance(std::size_t group, int ticks) = 0;
    /// Start a twin anew, perhaps of another robot; it rests with its tail straight.
    virtual void restart(std::size_t twin, BatchMember&& member) = 0;
    /// Write `now`, `energy` and `lost`.
    virtual void look() = 0;
};

template <int D>
class BatchOf final : public Batch {
  public:
    BatchOf(const MachineKernel& kernel, std::vector<BatchMember>&& members, int steps)
        : kernel_(kernel), steps_(steps) {
        const std::size_t count = members.size(), lanes = std::size_t(kernel.lanes);
        for (BatchMember& member : members) twins_.emplace_back(std::move(member));
        commands.resize(count), energy.resize(count), lost.resize(count);
        Columns::add(now, count, twins_[0].member.plant->own, twins_[0].member.plant->joints);
        groups_.resize((count + lanes - 1) / lanes);
    }
    /// Groups point to their twins, so a copy makes its own.
    BatchOf(const BatchOf& other)
        : Batch(other),
          kernel_(other.kernel_),
          steps_(other.steps_),
          twins_(other.twins_),
          groups_(other.groups_.size()) {}
    std::unique_ptr<Batch> copy() const override { return std::make_unique<BatchOf>(*this); }
    std::size_t groups() const override { return groups_.size(); }
    void advance(std::size_t group, int ticks) override {
        const std::size_t first = group * std::size_t(kernel_.lanes);
        std::optional<LaneGroup<D>>& lanes = groups_[group];
        if (!lanes) {
            std::vector<LaneTwin<D>*> twins;
            for (std::size_t k = first; k < std::min(first + std::size_t(kernel_.lanes), twins_.size()); ++k)
                twins.push_back(&twins_[k]);
            lanes.emplace(kernel_, std::move(twins), steps_);
        }
        for (int t = 0; t < ticks; ++t) lanes->tick([&](std::size_t k) { return commands[first + k]; });
    }
    void restart(std::size_t twin, BatchMember&& member) override {
        if (member.plant != twins_[twin].member.plant) groups_[twin / std::size_t(kernel_.lanes)].reset();
        twins_[twin].member = std::move(member);
        twins_[twin].restart();
        commands[twin] = {};
    }
    void look() override {
        for (std::size_t k = 0; k < twins_.size(); ++k) {
            const LaneTwin<D>& twin = twins_[k];
            Columns::write(now, k, twin.state, twin.tick);
            energy[k] = twin.member.plant->idle * twin.time();
            for (double drawn : twin.state.plant.energy) energy[k] += drawn;
            lost[k] = !plausible(twin.state.plant);
        }
    }

  private:
    using Columns = TwinColumns<D, InPlane>;

    const MachineKernel& kernel_;
    int steps_;
    std::vector<LaneTwin<D>> twins_;
    std::vector<std::optional<LaneGroup<D>>> groups_;
};

/// Make a batch of members that have the same structure.
static std::unique_ptr<Batch> make_batch(const MachineKernel& kernel, std::vector<BatchMember>&& members, int steps) {
    std::unique_ptr<Batch> made;
    with_coordinates(members[0].plant->coordinates, [&](auto coordinates) {
        made = std::make_unique<BatchOf<coordinates.value>>(kernel, std::move(members), steps);
    });
    return made;
}

/// Twins in the plane that are simulated together; this object keeps their plants, whose memory is Python's.
struct LiveBatch {
    std::unique_ptr<Batch> batch;
    std::vector<nb::object> plants;
    std::vector<int> structure;
    double tick;  // s
};

/// Plant, controller, sensors and speed ahead [m/s] of a twin at its start.
using StartRow = std::tuple<nb::object, const LiveController*, const LiveSensors*, double>;

static BatchMember start_of_row(const StartRow& row) {
    const auto& [plant, controller, sensors, speed] = row;
    return member_of(nb::cast<const PlantData&>(plant), controller->model, false, *sensors, {},
                     {{-speed, 0, 0}, {0, 0, 0}});
}

static void make_live_batch(LiveBatch* self, const std::vector<StartRow>& rows, int steps) {
    std::vector<BatchMember> members;
    std::vector<nb::object> plants;
    for (const StartRow& row : rows) {
        members.push_back(start_of_row(row));
        plants.push_back(std::get<0>(row));
    }
    check(check_batch(members));
    if (steps < 1) throw nb::value_error("steps: must be one or more");
    const std::vector<int> structure = structure_of(*members[0].plant);
    const double tick = members[0].controller.tick;
    new (self) LiveBatch{make_batch(*kernel().machines, std::move(members), steps), std::move(plants), structure, tick};
}

static void restart(LiveBatch& self, std::size_t twin, const StartRow& row) {
    BatchMember member = start_of_row(row);
    if (twin >= self.plants.size()) throw nb::index_error("twin: is not one of the batch");
    check(check_batch({member}));
    if (structure_of(*member.plant) != self.structure || member.controller.tick != self.tick)
        throw nb::value_error("batch: all robots must have the same links, joints, water law and control tick");
    self.batch->restart(twin, std::move(member));
    self.plants[twin] = std::get<0>(row);
}

static void command(LiveBatch& self, const Input<1>& frequency, const Input<2>& amplitude, const Input<2>& phase,
                    const Input<2>& bias) {
    const std::size_t count = self.plants.size(), joints = nb::cast<const PlantData&>(self.plants[0]).joints;
    check_extent("frequency", frequency.shape(0), count);
    for (const auto& [name, rows] :
         {std::pair("amplitude", &amplitude), std::pair("phase", &phase), std::pair("bias", &bias)}) {
        check_extent(name, rows->shape(0), count);
        check_extent(name, rows->shape(1), joints);
    }
    for (std::size_t k = 0; k < count; ++k) {
        Command<double>& to = self.batch->commands[k];
        to.frequency = frequency.data()[k];
        std::copy_n(amplitude.data() + k * joints, joints, to.amplitude);
        std::copy_n(phase.data() + k * joints, joints, to.phase);
        std::copy_n(bias.data() + k * joints, joints, to.bias);
        to.fresh = to.armed = true;
    }
}

static void advance_batch(LiveBatch& self, int ticks, int threads) {
    const nb::gil_scoped_release unlocked;
    std::atomic<std::size_t> next{0};
    const auto take = [&] {
        for (std::size_t g = next++; g < self.batch->groups(); g = next++) self.batch->advance(g, ticks);
    };
    std::vector<std::jthread> others;
    for (int t = 1; t < std::min(threads, int(self.batch->groups())); ++t) others.emplace_back(take);
    take();
}

/// Columns of all twins at present, by name.
static NamedArrays columns_now(LiveBatch& self) {
    self.batch->look();
    NamedArrays out = arrays_of(Record(self.batch->now));
    for (const auto& [name, from] : {std::pair("energy", &self.batch->energy), std::pair("lost", &self.batch->lost)}) {
        Output column = zeros({from->size()});
        std::copy(from->begin(), from->end(), column.data());
        out[name] = column;
    }
    return out;
}

void bind_batch(nb::module_& m) {
    m.def("simulate_batch", &simulate_batch, nb::arg("runs"), nb::kw_only(), nb::arg("ticks"), nb::arg("steps"),
          "Run twins in the plane side by side: (plant, command, world, sensors, faults, twist (6)) each, of robots of "
          "the same structure. Records as `simulate` gives them, to the same bits.");
    m.def("twin_lanes", [] { return kernel().machines->lanes; }, "Twins that one instruction serves.");
    nb::class_<LiveBatch>(m, "Batch", "Twins in the plane that go on together under commands that may change.")
        .def("__init__", &make_live_batch, nb::arg("twins"), nb::kw_only(), nb::arg("steps"),
             "From (plant, controller, sensors, speed [m/s]) each, of robots of the same structure, at rest.")
        .def(
            "__deepcopy__",
            [](const LiveBatch& self, nb::handle) {
                return LiveBatch{self.batch->copy(), self.plants, self.structure, self.tick};
            },
            nb::arg("memo"), "A batch that goes on from the same state.")
        .def("restart", &restart, nb::arg("twin"), nb::arg("start"), "Begin one anew, perhaps of another robot.")
        .def("command", &command, nb::arg("frequency"), nb::arg("amplitude"), nb::arg("phase"), nb::arg("bias"),
             "From now on, of each twin: frequency [Hz]; amplitudes, phases and biases (twins, joints) [rad].")
        .def("advance", &advance_batch, nb::arg("ticks"), nb::arg("threads") = 1, "Make control ticks.")
        .def("columns", &columns_now,
             "State now and last tick by the names of `simulate`, one row per twin; `energy`, electrical, drawn since "
             "the start [J]; and `lost`, 1 where the state is none that a robot can have.");
}

}  // namespace hypertuna
