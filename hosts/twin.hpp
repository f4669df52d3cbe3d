/// The twin for a host: one robot that goes on tick by tick, under a command that may change at any time.
#pragma once

#include <algorithm>
#include <memory>

#include "hypertuna/host/simulate.hpp"

namespace hypertuna {

/// Sizes of tails that there is code for. A tail of another size gets coordinates that rest, up to the next one.
inline constexpr int tail_sizes[] = {3, max_coordinates};

/// What a twin is made of; shared by all twins of a robot.
struct TwinParts {
    PlantData plant;
    Controller<double> controller;
    Sensors<double> sensors;
    int steps;        // Runge-Kutta steps of a tick
    int coordinates;  // of the robot's own
};

/// Give a plant coordinates that rest, up to the next size that there is code for: they move nothing, carry an inertia
/// of one and get no moment.
inline void pad(PlantData& plant) {
    const int own = plant.coordinates;
    const int size = *std::lower_bound(std::begin(tail_sizes), std::end(tail_sizes), own);
    std::vector<double> share;
    for (int i = 0; i < plant.model.links; ++i) {
        share.insert(share.end(), &plant.share[i * own], &plant.share[i * own] + own);
        share.insert(share.end(), size - own, 0);
    }
    plant.share = share;
    plant.armature.resize(size, 1);
    plant.coordinates = size;
}

/// A twin with a body of any kind.
class LiveTwin {
  public:
    Command<double> command{};
    Instruments instruments;
    Record row;  // of the last tick

    virtual ~LiveTwin() = default;
    virtual int advance(int ticks) = 0;
    virtual std::size_t state_size() const = 0;
    virtual void save(unsigned char* to) const = 0;
    virtual void restore(const unsigned char* from) = 0;
    virtual double time() const = 0;  // s
};

/// A twin of a robot in a world; the plant is padded, and the world has been checked against it.
std::unique_ptr<LiveTwin> make_live(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world);

}  // namespace hypertuna
