/// Twins for a tail of a given size, apart from host.cpp: only here does speed count more than size.
#pragma once

#include "twin.hpp"

namespace hypertuna {

template <class Law, int D>
const Tail<double, Law, D>& body_of(const PlaneBody<Law, D>& home) {
    return home.tail;
}
template <class Law, int D>
const Body6<double, Law, D>& body_of(const SpaceBody<Law, D>& home) {
    return home.body;
}
template <class Home>
using BodyOf = std::remove_cvref_t<decltype(body_of(std::declval<const Home&>()))>;

/// A twin whose body lies in a home, in the plane or at sea; `Moment` is its complete state.
template <class Home, class Moment>
class BodyTwin : public LiveTwin {
  public:
    template <class World>
    BodyTwin(const TwinParts& parts, std::uint64_t seed, const World& world, double tick)
        : home_(parts.plant, world), twin_(make_twin(parts.plant, body_of(home_), tick, parts.steps)) {
        twin_.controller = parts.controller;
        instruments.sensors = parts.sensors;
        instruments.sensors.seed = seed;
        Columns::add(row, 1, parts.plant.own, parts.plant.joints);
    }

    std::size_t state_size() const final { return sizeof(now_); }
    void save(unsigned char* to) const final { std::memcpy(to, &now_, sizeof(now_)); }
    void restore(const unsigned char* from) override { std::memcpy(&now_, from, sizeof(now_)); }
    double time() const final { return twin_.controller.tick * double(now_.ticks); }

  protected:
    using Body = BodyOf<Home>;
    using Columns = TwinColumns<Body::coordinates, typename Body::Space>;
    static_assert(std::is_trivially_copyable_v<Moment>);

    Home home_;
    Twin<Body> twin_;
    Moment now_{};
};

/// State of a twin under a command.
template <class Body>
struct TwinMoment {
    TwinStateOf<Body> twin;
    SensorsState<double> sensing;
    std::uint64_t ticks;
};

/// A twin under a command.
template <class Home>
class CommandedTwin final : public BodyTwin<Home, TwinMoment<BodyOf<Home>>> {
  public:
    using Base = BodyTwin<Home, TwinMoment<BodyOf<Home>>>;
    template <class World>
    CommandedTwin(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world)
        : Base(parts, seed, world, start.tick) {
        now_.twin = start_of(twin_, start);
    }

    int advance(int ticks) override {
        int made = 0;
        for (bool whole = plausible(now_.twin.plant); made < ticks && whole;) {
            const auto start = now_.twin.plant;
            const auto tick =
                command_tick(twin_, now_.twin, this->command, this->instruments, now_.sensing, this->time());
            ++now_.ticks;
            whole = plausible(now_.twin.plant);
            made += whole;
            if (made == ticks || !whole) Base::Columns::write(this->row, 0, shown(now_.twin, start), tick);
        }
        return made;
    }

  private:
    using Base::now_, Base::twin_;
};

/// Recorded quantities of a flight beside those of twin and pilot.
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
class FlightTwin final : public BodyTwin<SpaceBody<Law, D>, FlightState<D>> {
  public:
    using Base = BodyTwin<SpaceBody<Law, D>, FlightState<D>>;
    FlightTwin(const TwinParts& parts, const MissionParts& mission, std::uint64_t seed, const World& world)
        : Base(parts, seed, *world.sea, parts.controller.tick),
          mission_(mission),
          world_(world),
          flight_{*parts.pilot, mission.data.mission, {}, {}, {}} {
        now_ = start_flight(twin_, flight_, world_, instruments,
                            {0, 1, parts.controller.tick, parts.steps, {}, mission.pose, mission.charge});
        pilot_at_ = add_columns(row, pilot_columns, 1, parts.plant.own, parts.plant.joints);
        flight_at_ = add_columns(row, flight_columns, 1, parts.plant.own, parts.plant.joints);
    }

    int advance(int ticks) override {
        int made = 0;
        while (made < ticks && ending() == Ending::none) {
            const PlantState<double, D, InSpace> start = now_.twin.plant;
            const double began = time();
            const PilotTick<double, D> tick = flight_tick(twin_, now_, now_.twin, flight_, world_, instruments);
            made += ending() != Ending::diverged;
            if (made < ticks && ending() == Ending::none) continue;
            Base::Columns::write(row, 0, shown(now_.twin, start), tick.tick);
            write_row(row, pilot_at_, pilot_columns, 0, tick.step);
            write_row(row, flight_at_, flight_columns, 0,
                      FlightMoment{began, 1 - now_.twin.taken / twin_.battery.charge, ending()});
        }
        return made;
    }
    void jam(int fin, double angle, bool stands) override {
        std::vector<ServoFault>& faults = flight_.servo_faults;
        const int servo = 2 * flight_.pilot.controller.joints + fin;
        std::erase_if(faults, [servo](const ServoFault& fault) { return fault.servo == servo; });
        if (stands) faults.push_back({servo, angle, time(), HUGE_VAL});
    }

  private:
    using Base::now_, Base::twin_, Base::row, Base::instruments, Base::time;

    Ending ending() const {
        const GuidanceState<double>& at = now_.pilot.guidance;
        if (!plausible(now_.twin.plant)) return Ending::diverged;
        return has_ended(at.mode) || mission_.ticks <= now_.ticks ? ending_of(at.mode, at.reasons) : Ending::none;
    }

    const MissionParts& mission_;
    World world_;
    Flight flight_;
    std::size_t pilot_at_, flight_at_;  // first columns of pilot and flight in the row
};

/// Make a twin with the home that follows from the robot's water law and its world: make<Home>(world).
template <int D, class Make>
std::unique_ptr<LiveTwin> with_home(const TwinParts& parts, const World& world, const Make& make) {
    std::unique_ptr<LiveTwin> made;
    with_law<double>(parts.plant.model.law, [&](auto law) {
        using Law = typename decltype(law)::type;
        if (world.sea)
            made = make.template operator()<SpaceBody<Law, D>>(*world.sea);
        else
            made = make.template operator()<PlaneBody<Law, D>>(false);
    });
    return made;
}

template <int D>
std::unique_ptr<LiveTwin> Twins<D>::start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                          const World& world) {
    return with_home<D>(parts, world, [&]<class Home>(const auto& place) {
        return std::make_unique<CommandedTwin<Home>>(parts, seed, start, place);
    });
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
