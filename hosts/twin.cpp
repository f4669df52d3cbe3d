/// The twins of all sizes and bodies: apart from host.cpp, since here alone speed counts more than size.
#include "twin.hpp"

namespace hypertuna {
namespace {

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
        for (int made = 0; made < ticks; ++made, ++now_.ticks) {
            if (!plausible(now_.twin.plant)) return made;
            const PlantStateOf<Body> start = now_.twin.plant;
            const TickOf<Body> tick = command_tick(twin_, now_.twin, command, instruments, now_.sensing, time());
            if (made + 1 == ticks) Columns::write(row, 0, shown(now_.twin, start), tick);
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

    Home home_;
    Twin<Body> twin_;
    Moment now_;
};

template <std::size_t size>
std::unique_ptr<LiveTwin> make_sized(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world) {
    constexpr int D = tail_sizes[size];
    if constexpr (D < max_coordinates)
        if (parts.plant.coordinates != D) return make_sized<size + 1>(parts, seed, start, world);
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

}  // namespace

std::unique_ptr<LiveTwin> make_live(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world) {
    return make_sized<0>(parts, seed, start, world);
}

}  // namespace hypertuna
