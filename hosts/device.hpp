/// The twins of device.h, with a body of any kind.
#pragma once

#include "twin.hpp"

namespace hypertuna {

class Device {
  public:
    Command<double> command{};
    double pulse[max_servos] = {};  // s, of the plant alone
    Instruments instruments;
    Record row;  // of now

    virtual ~Device() = default;
    virtual int advance(int ticks) = 0;
    virtual void flow(const double* current) = 0;
    virtual std::size_t state_size() const = 0;
    virtual void save(unsigned char* to) const = 0;
    virtual void restore(const unsigned char* from) = 0;
};

/// All that a device goes on from and shows. The plant's readings are of now, for a controller outside.
template <class Body>
struct DeviceMoment {
    TwinStateOf<Body> twin;
    TickOf<Body> tick;
    SensorsState<double> sensing;
    std::uint64_t ticks;
};

/// A device with a body in the plane or at sea: `Home` owns its memory.
template <class Home, class Body>
class BodyDevice final : public Device {
  public:
    template <class World>
    BodyDevice(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world, bool plant,
               Body Home::* body)
        : home_(parts.plant, world),
          twin_(make_twin(parts.plant, home_.*body, start.tick, parts.steps)),
          plant_(plant),
          piloted_(parts.pilot.has_value()) {
        twin_.controller = parts.controller;
        instruments.sensors = parts.sensors;
        instruments.sensors.seed = seed;
        now_ = {start_of(twin_, start), {}, {}, 0};
        std::fill_n(pulse, max_servos, parts.controller.pulse_center);
        std::copy(pulse, pulse + max_servos, now_.tick.output.pulse);
        Columns::add(row, 1, parts.coordinates, parts.plant.joints);
        visit_channels([&](const auto& channel, int) {
            const std::size_t width = channel.count(parts.plant.joints);
            row.columns.push_back({channel.column, width, width == 1, std::vector<double>(width)});
        });
        add_column(row, "fixed", Extent::one, 1, 0, 0);
        add_column(row, "angles", Extent::three, 1, 0, 0);
        look();
        if (plant_) sense();
        show();
    }

    int advance(int ticks) override {
        int made = 0;
        for (; made < ticks && plausible(now_.twin.plant); ++made) {
            now_.tick =
                plant_ ? plant_tick() : command_tick(twin_, now_.twin, command, instruments, now_.sensing, time());
            ++now_.ticks;
            if (plant_) look(), sense();
        }
        if (!plant_) look();
        show();
        return made;
    }
    void flow(const double* current) override {
        if constexpr (std::is_same_v<typename Body::Space, InSpace>)
            std::copy(current, current + 2, twin_.plant.body.sea.current);
    }
    std::size_t state_size() const override { return sizeof(now_); }
    void save(unsigned char* to) const override { std::memcpy(to, &now_, sizeof(now_)); }
    void restore(const unsigned char* from) override {
        std::memcpy(&now_, from, sizeof(now_));
        show();
    }

  private:
    using Columns = TwinColumns<Body::coordinates, typename Body::Space>;
    static_assert(std::is_trivially_copyable_v<DeviceMoment<Body>>);

    double time() const { return twin_.controller.tick * double(now_.ticks); }

    /// One tick from the pulses; the sensors have been read.
    TickOf<Body> plant_tick() {
        const auto read = now_.tick.readings;
        return decided_tick(
            twin_, now_.twin, [&](const auto&) { return read; },
            [&](const auto&) {
                ControllerOutput<double> sent{};
                std::copy(pulse, pulse + max_servos, sent.pulse);
                return sent;
            });
    }
    /// The plant as it is now.
    void look() { plant_rate(twin_.plant, now_.twin.plant, now_.twin.targets, &now_.tick.seen); }
    /// What the sensors read now; the plant has been looked at.
    void sense() {
        auto& readings = now_.tick.readings;
        readings = true_readings(twin_, now_.twin, now_.tick.seen);
        if constexpr (std::is_same_v<typename Body::Space, InSpace>)
            if (!piloted_) {
                readings.robot = instruments.read(now_.sensing, readings.robot, time());
                return;
            }
        readings = instruments.read(now_.sensing, readings, time());
    }
    void show() {
        Columns::write(row, 0, now_.twin, now_.tick);
        PilotReadings<double> readings{};
        if constexpr (std::is_same_v<typename Body::Space, InSpace>)
            readings = now_.tick.readings;
        else
            readings = without_pilot(now_.tick.readings);
        std::size_t at = row.columns.size() - channel_kinds - 2;
        visit_channels([&](const auto& channel, int) {
            std::vector<double>& values = row.columns[at++].values;
            std::copy_n(channel.of(readings), values.size(), values.begin());
        });
        row.columns[at].values[0] = readings.fixed;
        if constexpr (std::is_same_v<typename Body::Space, InSpace>) row.columns[at + 1].values = angles();
    }

    /// Roll, pitch and heading of the head; its axes are aft, starboard, up.
    std::vector<double> angles() const {
        const Rotation<double> r = rotation(now_.twin.plant.pose.attitude);
        const double heading = std::atan2(-r.east.x, -r.north.x);
        return {std::atan2(-r.up.y, r.up.z), -std::asin(clamp(r.up.x, -1.0, 1.0)),
                heading + (heading < 0 ? 2 * pi : 0)};
    }

    Home home_;
    Twin<Body> twin_;
    bool plant_, piloted_;  // without a controller; with the sensors of a pilot
    DeviceMoment<Body> now_;
};

/// The devices with a tail of D coordinates; the plant is padded to them.
template <int D>
struct Devices {
    static std::unique_ptr<Device> start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                         const World& world, bool plant);
};
extern template struct Devices<short_tail>;
extern template struct Devices<max_coordinates>;

template <int D>
std::unique_ptr<Device> Devices<D>::start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                          const World& world, bool plant) {
    std::unique_ptr<Device> made;
    with_law<double>(parts.plant.model.law, [&](auto law) {
        using Law = typename decltype(law)::type;
        using Space = SpaceBody<Law, D>;
        using Plane = PlaneBody<Law, D>;
        if (world.sea)
            made = std::make_unique<BodyDevice<Space, Body6<double, Law, D>>>(parts, seed, start, *world.sea, plant,
                                                                              &Space::body);
        else
            made = std::make_unique<BodyDevice<Plane, Tail<double, Law, D>>>(parts, seed, start, false, plant,
                                                                             &Plane::tail);
    });
    return made;
}

}  // namespace hypertuna
