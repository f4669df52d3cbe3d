/// The twins of device.h, with a body of any kind.
#pragma once

#include "twin.hpp"

namespace hypertuna {

/// Setpoints of a twin's pilot.
struct Steered {
    bool on;
    double depth;  // m
    Course<double> facing;
};

class Device {
  public:
    Command<double> command{};
    Steered steered{};
    double pulse[max_servos] = {};  // s, of the plant alone
    Instruments instruments;
    Record row;  // of now

    virtual ~Device() = default;
    virtual int advance(int ticks) = 0;
    virtual void flow(const double* current) = 0;
    virtual bool piloted() const = 0;  // whether a pilot can steer
    virtual std::size_t state_size() const = 0;
    virtual void save(unsigned char* to) const = 0;
    virtual void restore(const unsigned char* from) = 0;
};

/// State and outputs of a device. The plant's readings are those of now, for a controller outside.
template <class Body>
struct DeviceMoment {
    TwinStateOf<Body> twin;
    PilotState<double> pilot;  // with the controller's, of a twin that has one
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
          pilot_(at_sea && parts.pilot ? &*parts.pilot : nullptr) {
        twin_.controller = parts.controller;
        instruments.sensors = parts.sensors;
        instruments.sensors.seed = seed;
        now_ = {start_of(twin_, start), {}, {}, {}, 0};
        if (piloted()) start_pilot();
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
            now_.tick = plant_ ? plant_tick() : twin_tick();
            ++now_.ticks;
            if (plant_) look(), sense();
        }
        if (!plant_) look();
        show();
        return made;
    }
    void flow(const double* current) override {
        if constexpr (at_sea) std::copy(current, current + 2, twin_.plant.body.sea.current);
    }
    bool piloted() const override { return pilot_ && !plant_; }
    std::size_t state_size() const override { return sizeof(now_); }
    void save(unsigned char* to) const override { std::memcpy(to, &now_, sizeof(now_)); }
    void restore(const unsigned char* from) override {
        std::memcpy(&now_, from, sizeof(now_));
        show();
    }

  private:
    using Columns = TwinColumns<Body::coordinates, typename Body::Space>;
    static constexpr bool at_sea = std::is_same_v<typename Body::Space, InSpace>;
    static_assert(std::is_trivially_copyable_v<DeviceMoment<Body>>);

    double time() const { return twin_.controller.tick * double(now_.ticks); }

    /// Start the pilot; a robot that begins under water was switched on at the surface.
    void start_pilot() {
        now_.pilot = init(*pilot_, Mission<double>{});
        if constexpr (at_sea)
            if (now_.twin.plant.pose.position.z < 0)
                keep_zero(now_.pilot.estimator, depth_shown(twin_.plant.body.sea, 0.0));
    }
    /// One tick of the robot under its command. The pilot follows what its sensors read also while it does not steer.
    TickOf<Body> twin_tick() {
        if constexpr (at_sea)
            if (piloted())
                return decided_tick(
                    twin_, now_.twin, [&](const auto& truth) { return instruments.read(now_.sensing, truth, time()); },
                    [&](const auto& readings) { return piloted_output(readings); });
        return command_tick(twin_, now_.twin, command, instruments, now_.sensing, time());
    }
    ControllerOutput<double> piloted_output(const PilotReadings<double>& readings) {
        PilotState<double>& on = now_.pilot;
        const Estimate<double> at = perceive(*pilot_, on, readings, declination());
        const bool now = due(*pilot_, on);
        if (!steered.on)
            on.command = command, on.guidance.steering.turn_sum = on.guidance.steering.climb_sum = 0;
        else if (now)
            steer(*pilot_, on, at, command, steered.facing, steered.depth);
        ControllerOutput<double> output{};
        act(*pilot_, on, at, readings.robot, output);
        return output;
    }
    /// Declination of the magnetic field, which the pilot knows [rad].
    double declination() const {
        if constexpr (at_sea) return std::atan2(twin_.plant.body.sea.field.x, twin_.plant.body.sea.field.y);
        return 0;
    }

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
    /// Compute the plant's outputs of now.
    void look() { plant_rate(twin_.plant, now_.twin.plant, now_.twin.targets, &now_.tick.seen); }
    /// Read the sensors; `look` comes before.
    void sense() {
        auto& readings = now_.tick.readings;
        readings = true_readings(twin_, now_.twin, now_.tick.seen);
        if constexpr (at_sea)
            if (!pilot_) {
                readings.robot = instruments.read(now_.sensing, readings.robot, time());
                return;
            }
        readings = instruments.read(now_.sensing, readings, time());
    }
    void show() {
        Columns::write(row, 0, now_.twin, now_.tick);
        PilotReadings<double> readings{};
        if constexpr (at_sea)
            readings = now_.tick.readings;
        else
            readings = without_pilot(now_.tick.readings);
        std::size_t at = row.columns.size() - channel_kinds - 2;
        visit_channels([&](const auto& channel, int) {
            std::vector<double>& values = row.columns[at++].values;
            std::copy_n(channel.of(readings), values.size(), values.begin());
        });
        row.columns[at].values[0] = readings.fixed;
        if constexpr (at_sea) row.columns[at + 1].values = angles();
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
    bool plant_;                  // without a controller
    const Pilot<double>* pilot_;  // at sea, of a robot that has one
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
