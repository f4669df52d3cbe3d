/// Machines side by side in lanes, compiled once for each instruction set, which HYPERTUNA_ARCH names.
#include "hypertuna/host/machines.hpp"

#include "hypertuna/host/real.hpp"
#include "hypertuna/host/tank.hpp"
#include "hypertuna/simulation/twin.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

using Rows = const PlantNumbers* const*;

/// Copy numbers from one place per lane into lanes, or back.
static void load(const double* const* from, std::size_t count, Real* to) {
    for (int k = 0; k < lanes; ++k)
        for (std::size_t i = 0; i < count; ++i) set_lane(to[i], k, from[k][i]);
}
static void store(const Real* from, std::size_t count, double* const* to) {
    for (int k = 0; k < lanes; ++k)
        for (std::size_t i = 0; i < count; ++i) to[k][i] = lane(from[i], k);
}
/// Copy structs that consist of numbers, lane by lane.
template <class Numbers>
void load(const double* const* from, Numbers& to) {
    load(from, sizeof(Numbers) / sizeof(Real), reinterpret_cast<Real*>(&to));
}
template <class Numbers>
void store(const Numbers& from, double* const* to) {
    store(reinterpret_cast<const Real*>(&from), sizeof(Numbers) / sizeof(Real), to);
}

/// One row of numbers of all robots, a robot per lane.
static std::vector<Real> load_row(Rows robots, const double* PlantNumbers::* row, std::size_t count) {
    const double* from[lanes];
    for (int k = 0; k < lanes; ++k) from[k] = robots[k]->*row;
    std::vector<Real> to(count);
    load(from, count, to.data());
    return to;
}

/// Machines of any water law and number of coordinates.
struct AnyMachines {
    virtual ~AnyMachines() = default;
    virtual void look(const double* const* states, double* const* ticks) = 0;
    virtual void follow(double* const* states, double* const* ticks) = 0;
};

template <class Law, int D>
class Machines final : public AnyMachines {
  public:
    Machines(Rows robots, double tick, int steps)
        : tank_(*robots[0]->model, 4),
          share_(load_row(robots, &PlantNumbers::share, robots[0]->model->links * D)),
          armature_(load_row(robots, &PlantNumbers::armature, D)),
          unit_rest_(load_row(robots, &PlantNumbers::unit_rest, 2 * robots[0]->joints)),
          gear_(load_row(robots, &PlantNumbers::gear, robots[0]->joints)),
          motion_(robots[0]->model->links),
          shape_(robots[0]->model->links),
          acceleration_(robots[0]->model->links) {
        const int joints = robots[0]->joints;
        constexpr int width = joint_column_count + 3;
        const std::vector<Real> joint = load_row(robots, &PlantNumbers::joint, joints * width),
                                circuit = load_row(robots, &PlantNumbers::circuit, 2 * joints * circuit_column_count),
                                battery = load_row(robots, &PlantNumbers::battery, battery_column_count),
                                spring = load_row(robots, &PlantNumbers::spring, D * spring_numbers);
        for (int j = 0; j < joints; ++j) {
            const Real *const row = joint.data() + j * width, *const limits = row + joint_column_count;
            joint_.push_back(read_joint(row, StretchLimits<Real>{limits[0], limits[1], limits[2]}));
            direct_[j] = robots[0]->direct[j];
        }
        for (int c = 0; c < 2 * joints; ++c)
            circuit_.push_back(read_circuit<Real>(circuit.data() + c * circuit_column_count));
        for (int d = 0; d < D; ++d)
            spring_.push_back(read_row<Spring<Real>, Real>(spring_columns, spring.data() + d * spring_numbers));
        for (int k = 0; k < lanes; ++k) {
            const std::vector<double>& numbers = robots[k]->model->robot;
            for (std::size_t i = 0; i < numbers.size(); ++i)
                set_lane(tank_.parameters[tank_.parameters.size() - numbers.size() + i], k, numbers[i]);
            set_lane(machine_.idle, k, robots[k]->idle);
        }
        tank_.read();
        const Tail<Real, Law, D> tail{tank_.fish,          reinterpret_cast<const Real(*)[D]>(share_.data()),
                                      robots[0]->clamped,  armature_.data(),
                                      motion_.data(),      shape_.data(),
                                      acceleration_.data()};
        machine_.plant = {tail,         joints,          joint_.data(),     direct_,
                          gear_.data(), circuit_.data(), unit_rest_.data(), spring_.data()};
        machine_.battery = read_battery<Real>(battery.data());
        machine_.step = Real(tick / steps);
        machine_.steps = steps;
    }
    Machines(const Machines&) = delete;
    Machines& operator=(const Machines&) = delete;

    void look(const double* const* states, double* const* ticks) override {
        load(states, state_);
        plant_rate(machine_.plant, state_.plant, state_.targets, &tick_.seen);
        store(tick_.seen, ticks);
    }
    void follow(double* const* states, double* const* ticks) override {
        load(states, state_);
        follow_targets(machine_, state_, tick_);
        store(state_, states);
        store(tick_, ticks);
    }

  private:
    Tank<Real, Law> tank_;
    std::vector<Real> share_, armature_, unit_rest_, gear_;
    std::vector<JointMotion<Real>> motion_;
    std::vector<LinkShape<Real>> shape_;
    std::vector<LinkAcceleration<Real>> acceleration_;
    std::vector<Joint<Real>> joint_;
    std::vector<Circuit<Real>> circuit_;
    std::vector<Spring<Real>> spring_;
    bool direct_[D] = {};
    Machine<Tail<Real, Law, D>> machine_{};
    MachineState<Real, D> state_{};
    MachineTick<Real, D> tick_{};
};

static void* make(Rows robots, double tick, int steps) {
    AnyMachines* made = nullptr;
    with_coordinates(robots[0]->coordinates, [&](auto coordinates) {
        with_law<Real>(robots[0]->model->law, [&](auto law) {
            made = new Machines<typename decltype(law)::type, coordinates.value>(robots, tick, steps);
        });
    });
    return made;
}
static void free(void* machines) { delete static_cast<AnyMachines*>(machines); }
static void look(void* machines, const double* const* states, double* const* ticks) {
    static_cast<AnyMachines*>(machines)->look(states, ticks);
}
static void follow(void* machines, double* const* states, double* const* ticks) {
    static_cast<AnyMachines*>(machines)->follow(states, ticks);
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH

#define HYPERTUNA_JOIN(a, b) a##b
#define HYPERTUNA_SYMBOL(a, b) HYPERTUNA_JOIN(a, b)

namespace hypertuna {
extern const MachineKernel HYPERTUNA_SYMBOL(machines_, HYPERTUNA_ARCH);
const MachineKernel HYPERTUNA_SYMBOL(machines_, HYPERTUNA_ARCH) = {
    .lanes = HYPERTUNA_ARCH::lanes,
    .make = HYPERTUNA_ARCH::make,
    .free = HYPERTUNA_ARCH::free,
    .look = HYPERTUNA_ARCH::look,
    .follow = HYPERTUNA_ARCH::follow,
};
}  // namespace hypertuna
