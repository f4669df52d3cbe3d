/// The twin for a host: one robot, simulated tick by tick, under a command that may change at any time.
#pragma once

#include <algorithm>
#include <memory>

#include "hypertuna/host/simulate.hpp"
#include "scatter.hpp"

namespace hypertuna {

/// Number of coordinates of the shortest of the three tails for which code is compiled; the others have exact_tail and
/// max_coordinates. A tail of another size is padded to the next one by coordinates that rest.
inline constexpr int short_tail = 3;

/// A mission in its world, with the start of a flight.
struct MissionParts {
    MissionData data;
    World world;
    Scatter scatter;      // random scatter by the seed
    std::uint64_t ticks;  // number of ticks after which the flight is given up
    Pose6<double> pose;   // pose at the start
    double charge;        // C taken from the battery before the start
};

/// Parts of a twin; shared by all twins of a robot.
struct TwinParts {
    PlantData plant;
    Controller<double> controller;
    Sensors<double> sensors;
    int steps;  // Runge-Kutta steps of a tick
    std::optional<Pilot<double>> pilot;
    std::vector<MissionParts> missions;
};

/// Setpoints of a twin's pilot.
struct Steered {
    bool on;
    double depth;  // m
    Course<double> facing;
};

/// A twin with any body, under a controller, a pilot or given pulses.
class LiveTwin {
  public:
    Command<double> command{};
    Steered steered{};
    double pulse[max_servos] = {};  // s, servo pulses for the plant alone
    Instruments instruments;
    Record row;  // columns of the last tick

    virtual ~LiveTwin() = default;
    /// Make ticks; returns how many were made, without a tick whose state is physically impossible. `row` shows the
    /// last tick, or that one.
    virtual int advance(int ticks) = 0;
    /// Let a fin's servo stand at an angle [rad], or where it is if that is NaN; `false` repairs it. Only in flights.
    virtual void jam(int, double, bool) {}
    virtual void flow(const double*) {}             // set the current [m/s], at sea
    virtual bool piloted() const { return false; }  // whether a pilot can steer
    virtual std::size_t state_size() const = 0;
    virtual void save(unsigned char* to) const = 0;
    virtual void restore(const unsigned char* from) = 0;
    virtual double time() const = 0;  // s
};

/// Twins with a tail of D coordinates; the plant is padded to that number.
template <int D>
struct Twins {
    /// Make a twin of a robot in a world, which has been checked against the plant.
    static std::unique_ptr<LiveTwin> start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                           const World& world);
    /// Make a twin that flies one of the robot's missions, with the random scatter of its seed.
    static std::unique_ptr<LiveTwin> fly(const TwinParts& parts, const MissionParts& mission, std::uint64_t seed);
};
extern template struct Twins<short_tail>;
extern template struct Twins<exact_tail>;
extern template struct Twins<max_coordinates>;

/// Call work(D) for the tail of a padded plant.
template <class Work>
auto with_tail(const PlantData& plant, const Work& work) {
    switch (plant.coordinates) {
        case short_tail:
            return work(std::integral_constant<int, short_tail>());
        case exact_tail:
            return work(std::integral_constant<int, exact_tail>());
        default:
            return work(std::integral_constant<int, max_coordinates>());
    }
}

}  // namespace hypertuna
