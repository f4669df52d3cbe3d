/// The twins of device.h, with a body of any kind.
#pragma once

#include "live.hpp"

namespace hypertuna {

/// State and outputs of a device. The plant's readings are those of the present instant, for a controller outside.
template <class Body>
struct DeviceMoment {
    TwinStateOf<Body> twin;
    PilotState<double> pilot;  // state of pilot and controller, for a twin that has a pilot
    TickOf<Body> tick;
    SensorsState<double> sensing;
    std::uint64_t ticks;
};

/// A twin in step with other simulators: under a command, which its pilot may steer, or the plant alone.
template <class Home>
class Device final : public BodyTwin<Home, DeviceMoment<BodyOf<Home>>> {
  public:
    using Base = BodyTwin<Home, DeviceMoment<BodyOf<Home>>>;
    template <class World>
    Device(const TwinParts& parts, std::uint64_t seed, const Run& start, const World& world, bool plant)
        : Base(parts, seed, world, start.tick), plant_(plant), pilot_(at_sea && parts.pilot ? &*parts.pilot : nullptr) {
        now_.twin = start_of(twin_, start);
        if (piloted()) start_pilot();
        std::fill_n(pulse, max_servos, parts.controller.pulse_center);
        std::copy(pulse, pulse + max_servos, now_.tick.output.pulse);
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
        for (bool whole = plausible(now_.twin.plant); made < ticks && whole; made += whole) {
            now_.tick = plant_ ? plant_tick() : twin_tick();
            ++now_.ticks;
            whole = plausible(now_.twin.plant);
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
    void restore(const unsigned char* from) override {
        Base::restore(from);
        show();
    }

  private:
    using Body = BodyOf<Home>;
    using Base::now_, Base::twin_, Base::row, Base::instruments, Base::time, Base::command, Base::steered, Base::pulse;
    static constexpr bool at_sea = std::is_same_v<typename Body::Space, InSpace>;

    /// Start the pilot; a robot that begins under water was switched on at the surface.
    void start_pilot() {
        now_.pilot = init(*pilot_, Mission<double>{});
        if constexpr (at_sea)
            if (now_.twin.plant.pose.position.z < 0)
                keep_zero(now_.pilot.estimator, depth_shown(twin_.plant.body.sea, 0.0));
    }
    /// One tick of the robot under its command. The pilot also follows its sensors' readings while it does not steer.
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

    /// One tick of the plant under the given pulses; the sensors have been read before.
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
    /// Compute the plant's outputs at the present instant.
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
        Base::Columns::write(row, 0, now_.twin, now_.tick);
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

    bool plant_;                  // the plant alone, without a controller
    const Pilot<double>* pilot_;  // null in the plane, and where the robot has no pilot
};

/// Devices with a tail of D coordinates; the plant is padded to that number.
template <int D>
struct Devices {
    static std::unique_ptr<LiveTwin> start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                           const World& world, bool plant);
};
extern template struct Devices<short_tail>;
extern template struct Devices<exact_tail>;
extern template struct Devices<max_coordinates>;

template <int D>
std::unique_ptr<LiveTwin> Devices<D>::start(const TwinParts& parts, std::uint64_t seed, const Run& start,
                                            const World& world, bool plant) {
    return with_home<D>(parts, world, [&]<class Home>(const auto& place) {
        return std::make_unique<Device<Home>>(parts, seed, start, place, plant);
    });
}

}  // namespace hypertuna
