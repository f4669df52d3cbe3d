/// The twin for a host: one robot that goes on tick by tick, under a command that may change at any time.
#pragma once

#include <memory>

#include "hypertuna/host/simulate.hpp"

namespace hypertuna {

/// What a twin is made of; shared by all twins of a robot.
struct TwinParts {
    PlantData plant;
    Controller<double> controller;
    Sensors<double> sensors;
    int steps;  // Runge-Kutta steps of a tick
};

/// A twin with a body of any kind.
class LiveTwin {
  public:
    Command<double> command{};
    std::vector<Fault<double>> faults;
    Record row;  // of the last tick

    virtual ~LiveTwin() = default;
    virtual int advance(int ticks) = 0;
    virtual std::size_t state_size() const = 0;
    virtual void save(unsigned char* to) const = 0;
    virtual void restore(const unsigned char* from) = 0;
    virtual double time() const = 0;  // s
};

/// All that a twin goes on from.
template <class State>
struct TwinMoment {
    State twin;
    SensorsState<double> sensing;
    std::uint64_t ticks;
};

/// A twin with a body in the plane or at sea: `Home` owns its memory.
template <class Home, class Body>
class BodyTwin final : public LiveTwin {
  public:
    template <class World>
    BodyTwin(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world, const Body Home::* body)
        : home_(parts.plant, world), twin_(make_twin(parts.plant, home_.*body, start.tick, parts.steps)) {
        twin_.controller = parts.controller;
        sensors_ = parts.sensors;
        sensors_.seed = seed;
        now_ = {start_of(twin_, start), {}, 0};
        Columns::add(row, 1, parts.plant.joints);
    }

    int advance(int ticks) override {
        using Space = typename Body::Space;
        for (int made = 0; made < ticks; ++made, ++now_.ticks) {
            if (!plausible(now_.twin.plant)) return made;
            TwinStateOf<Body> shown = now_.twin;
            const TickOf<Body> tick = twin_tick(twin_, now_.twin, command, [&](auto truth) {
                if constexpr (std::is_same_v<Space, InPlane>)
                    truth = read(truth);
                else
                    truth.robot = read(truth.robot);
                return truth;
            });
            if (made + 1 < ticks) continue;
            const PlantStateOf<Body> start = shown.plant;
            shown = now_.twin;
            shown.plant = start;
            Columns::write(row, 0, shown, tick);
        }
        return ticks;
    }
    std::size_t state_size() const override { return sizeof(now_); }
    void save(unsigned char* to) const override { std::memcpy(to, &now_, sizeof(now_)); }
    void restore(const unsigned char* from) override { std::memcpy(&now_, from, sizeof(now_)); }
    double time() const override { return twin_.controller.tick * double(now_.ticks); }

  private:
    using Columns = TwinColumns<Body::coordinates, typename Body::Space>;
    using Moment = TwinMoment<TwinStateOf<Body>>;
    static_assert(std::is_trivially_copyable_v<Moment>);

    Readings<double> read(const Readings<double>& truth) {
        const auto sensed = sense(sensors_, now_.sensing, truth, faults.data(), int(faults.size()), time());
        now_.sensing = sensed.state;
        return sensed.readings;
    }

    Home home_;
    Twin<Body> twin_;
    Sensors<double> sensors_;
    Moment now_;
};

/// A twin of a robot in a world; the world has been checked against the plant.
template <int D = 1>
std::unique_ptr<LiveTwin> make_live(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world) {
    if constexpr (D < max_coordinates)
        if (parts.plant.coordinates != D) return make_live<D + 1>(parts, seed, start, world);
    std::unique_ptr<LiveTwin> made;
    with_law<double>(parts.plant.model.law, [&](auto law) {
        using Law = typename decltype(law)::type;
        if (world.sea)
            made = std::make_unique<BodyTwin<SpaceBody<Law, D>, Body6<double, Law, D>>>(parts, seed, start, *world.sea,
                                                                                        &SpaceBody<Law, D>::body);
        else
            made = std::make_unique<BodyTwin<PlaneBody<Law, D>, Tail<double, Law, D>>>(parts, seed, start, false,
                                                                                       &PlaneBody<Law, D>::tail);
    });
    return made;
}

}  // namespace hypertuna
