/// The twins of a tail's size: apart from host.cpp, since here alone speed counts more than size.
#pragma once

#include "twin.hpp"

namespace hypertuna {

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
        instruments.sensors = parts.sensors;
        instruments.sensors.seed = seed;
        now_ = {start_of(twin_, start), {}, 0};
        Columns::add(row, 1, parts.coordinates, parts.plant.joints);
    }

    int advance(int ticks) override {
        int made = 0;
        while (made < ticks && plausible(now_.twin.plant)) {
            const PlantStateOf<Body> start = now_.twin.plant;
            const TickOf<Body> tick = command_tick(twin_, now_.twin, command, instruments, now_.sensing, time());
            ++now_.ticks;
            if (++made == ticks || !plausible(now_.twin.plant)) Columns::write(row, 0, shown(now_.twin, start), tick);
        }
        return made;
    }
    std::size_t state_size() const override { return sizeof(now_); }
    void save(unsigned char* to) const override { std::memcpy(to, &now_, sizeof(now_)); }
    void restore(const unsigned char* from) override { std::memcpy(&now_, from, sizeof(now_)); }
    double time() const override { return twin_.controller.tick * double(now_.ticks); }

  private:
    using Columns = TwinColumns<Body::coordinates, typename Body::Space>;
    using Moment = TwinMoment<TwinStateOf<Body>>;
    static_assert(std::is_trivially_copyable_v<Moment>);

    Home home_;
    Twin<Body> twin_;
    Moment now_;
};

/// What is recorded of a flight beside twin and pilot.
struct FlightMoment {
    double time, charge_left;
    Ending ending;
};
#define HYPERTUNA_COLUMN(name, value) {name, Extent::one, [](const FlightMoment& at, int) -> double { return value; }}
inline constexpr auto flight_columns = std::to_array<Recorded<FlightMoment>>({
    HYPERTUNA_COLUMN("time", at.time),
    HYPERTUNA_COLUMN("charge_left", at.charge_left),
    HYPERTUNA_COLUMN("ending", double(int(at.ending))),
});
#undef HYPERTUNA_COLUMN

/// A twin on a mission.
template <class Law, int D>
class FlightTwin final : public LiveTwin {
  public:
    FlightTwin(const TwinParts& parts, const MissionParts& mission, std::uint64_t seed, const World& world)
        : home_(parts.plant, *world.sea),
          twin_(make_twin(parts.plant, home_.body, parts.controller.tick, parts.steps)),
          mission_(mission),
          world_(world),
          flight_{*parts.pilot, mission.data.mission, {}, {}},
          on_{} {
        twin_.controller = parts.controller;
        instruments.sensors = parts.sensors;
        instruments.sensors.seed = seed;
        on_ = start_flight(twin_, flight_, world_, instruments,
                           {0, 1, parts.controller.tick, parts.steps, {}, mission.pose, mission.charge});
        Columns::add(row, 1, parts.coordinates, parts.plant.joints);
        pilot_at_ = add_columns(row, pilot_columns, 1, parts.coordinates, parts.plant.joints);
        flight_at_ = add_columns(row, flight_columns, 1, parts.coordinates, parts.plant.joints);
    }

    int advance(int ticks) override {
        int made = 0;
        while (made < ticks && ending() == Ending::none) {
            const PlantState<double, D, InSpace> start = on_.twin.plant;
            const double began = time();
            const PilotTick<double, D> tick = flight_tick(twin_, on_, on_.twin, flight_, world_, instruments);
            if (++made < ticks && ending() == Ending::none) continue;
            Columns::write(row, 0, shown(on_.twin, start), tick.tick);
            write_row(row, pilot_at_, pilot_columns, 0, tick.step);
            write_row(row, flight_at_, flight_columns, 0,
                      FlightMoment{began, 1 - on_.twin.taken / twin_.battery.charge, ending()});
        }
        return made;
    }
    void jam(int fin, double angle, bool stands) override {
        std::vector<FinFault>& faults = flight_.fin_faults;
        std::erase_if(faults, [fin](const FinFault& fault) { return fault.fin == fin; });
        if (stands) faults.push_back({fin, angle, time(), HUGE_VAL});
    }
    std::size_t state_size() const override { return sizeof(on_); }
    void save(unsigned char* to) const override { std::memcpy(to, &on_, sizeof(on_)); }
    void restore(const unsigned char* from) override { std::memcpy(&on_, from, sizeof(on_)); }
    double time() const override { return twin_.controller.tick * double(on_.ticks); }

  private:
    using Columns = TwinColumns<D, InSpace>;
    static_assert(std::is_trivially_copyable_v<FlightState<D>>);

    Ending ending() const {
        const GuidanceState<double>& at = on_.pilot.guidance;
        if (!plausible(on_.twin.plant)) return Ending::diverged;
        if (at.mode == Mode::done) return Ending::done;
        if (at.mode != Mode::ended && on_.ticks < mission_.ticks) return Ending::none;
        if (at.mode == Mode::hold) return Ending::hold;
        if (at.reasons.has(Reason::adrift)) return Ending::adrift;
        return at.mode == Mode::ended ? Ending::home : Ending::given_up;
    }

    SpaceBody<Law, D> home_;
    Twin<Body6<double, Law, D>> twin_;
    const MissionParts& mission_;
    World world_;
    Flight flight_;
    FlightState<D> on_;
    std::size_t pilot_at_, flight_at_;  // places of columns
};

template <int D>
std::unique_ptr<LiveTwin> Twins<D>::start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                          const World& world) {
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

template <int D>
std::unique_ptr<LiveTwin> Twins<D>::fly(const TwinParts& parts, const MissionParts& mission, std::uint64_t seed) {
    World world = mission.world;
    const std::array<double, 2> added = mission.scatter.add(seed, world.gaps);
    for (int k = 0; k < 2; ++k) world.sea->current[k] += added[k];
    std::unique_ptr<LiveTwin> made;
    with_law<double>(parts.plant.model.law, [&](auto law) {
        made = std::make_unique<FlightTwin<typename decltype(law)::type, D>>(parts, mission, seed, world);
    });
    return made;
}

}  // namespace hypertuna
