/// Sensors: how a reading differs from the truth, and how a sensor fails.
///
/// A reading is truth + nonlinearity + offset + walk + noise, held within the sensor's range and rounded to its step.
/// All randomness is a function of seed, channel and tick: a run repeats to the last bit, and a fault in one channel
/// does not change the others' noise.
#pragma once

#include "hypertuna/pilot/readings.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Random bits that depend only on seed, channel and count: two rounds of splitmix64's finisher.
inline std::uint64_t random_bits(std::uint64_t seed, std::uint64_t channel, std::uint64_t count) {
    const auto mixed = [](std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    };
    return mixed(mixed(seed + 0x9e3779b97f4a7c15u * (channel + 1)) + 0x9e3779b97f4a7c15u * (count + 1));
}

/// Uniform number in [0, 1) from 24 of the bits.
template <class T>
T uniform(std::uint64_t bits) {
    return T(bits >> 40) * T(1.0 / 16777216.0);
}

/// Nearly normal number, mean 0 and standard deviation 1: the sum of four uniform 16-bit numbers, never beyond 3.5.
template <class T>
T normal(std::uint64_t bits) {
    T sum = T(0);
    for (int k = 0; k < 4; ++k) sum += T((bits >> 16 * k) & 0xffff);
    // Four times the mean 32767.5; the variance of each is (65536^2 - 1) / 12.
    return (sum - T(131070)) * T(2.6428950672e-05);
}

enum class FaultKind : std::uint8_t { none, stuck, open, spike, nan, drift, shift, clogged, count };
inline constexpr const char* fault_kinds[int(FaultKind::count)] = {"none", "stuck", "open",  "spike",
                                                                   "nan",  "drift", "shift", "clogged"};
inline constexpr double drift_rate = 0.05;   // 1/s: part of its range by which a drifting sensor drifts
inline constexpr double shift_height = 0.2;  // part of its range by which a shifted sensor is off

/// A fault of the channels first..last from `start` until before `end`, in s.
template <class T>
struct Fault {
    FaultKind kind;
    int first, last;
    T start, end;
};

/// Errors of a kind of sensor, in SI units of its quantity.
template <class T>
struct SensorModel {
    T low, high;     // range
    T noise;         // standard deviation
    T resolution;    // step of its quantization, 0 for none
    T drift;         // standard deviation of its random walk after 1 s
    T bias;          // standard deviation of its constant offset
    T nonlinearity;  // largest deviation from a line, as a fraction of the range
};

/// Order of the channels' random streams: those of the smallest board first, further ones after them.
struct StreamPlaces {
    int place[sensor_channels], controller, all;  // channels of a board: those that the controller reads, and all
};
inline constexpr StreamPlaces stream_places = [] {
    StreamPlaces out{};
    visit_channels([&](const auto& channel, int) {
        (channel.reader == Reader::controller ? out.controller : out.all) += channel.count(board_joints);
    });
    out.all += out.controller;
    int next = 0, after = out.all;
    visit_channels([&](const auto& channel, int first) {
        for (int k = 0; k < channel.size; ++k)
            out.place[first + k] = k < channel.count(board_joints) ? next++ : after++;
    });
    return out;
}();

/// Stream of random numbers `what` (0 to 3) of a channel. The pilot's streams follow all four of each of the
/// controller's channels, so that their number changes no run of a robot without a pilot. Nor does the largest number
/// of joints.
inline std::uint64_t stream_of(std::uint64_t what, int channel) {
    const auto& [places, controller, all] = stream_places;
    const int place = places[channel];
    const std::uint64_t first = place < controller ? 0 : place < all ? 3 * controller : 6 * controller + all;
    const std::uint64_t row = place < all ? controller : sensor_channels;
    return first + what * row + std::uint64_t(place);
}

template <class T>
struct Sensors {
    int joints;
    T root_tick;  // square root of the control tick, s^0.5
    std::uint64_t seed;
    SensorModel<T> model[channel_kinds];
    int fix_every;  // ticks between two satellite fixes

    SensorModel<T>& of(std::string_view name) { return model[channel_kind(name)]; }
};

template <class T>
struct SensorsState {
    std::uint64_t count;
    T walk[sensor_channels], held[sensor_channels];
};

/// Deviation of a sensor from a line, odd and zero at rest and at both ends of the range: 3 sqrt(3) / 2 (z - z^3) peaks
/// at 1.
template <class T>
T line_error(const SensorModel<T>& model, T truth) {
    const T z = clamp(truth / model.high, T(-1), T(1));
    return model.nonlinearity * (model.high - model.low) * T(2.598076211353316) * (z - z * z * z);
}

/// Round to the sensor's step; a step finer than that of the number type changes nothing. Adding and subtracting a
/// large number rounds by arithmetic alone.
template <class T>
T quantized(T step, T x) {
    const T large = Reduction<T>::round;
    if (!(abs(x) < large * step)) return x;
    return (x / step + large - large) * step;
}

/// Reading that a faulty sensor shows in place of `reading`. `held` is the last one before the fault, `since` the
/// fault's age, s; a bit of `side` decides to which side the sensor drifts or shifts.
template <class T>
T failed(const SensorModel<T>& model, FaultKind kind, T reading, T held, T since, std::uint64_t side,
         std::uint64_t bits) {
    const T range = model.high - model.low, way = (side & 1) != 0 ? range : -range;
    switch (kind) {
        case FaultKind::stuck:
            return held;
        case FaultKind::open:  // below the live zero, where no working sensor can be
            return model.low - T(0.125) * range;
        case FaultKind::spike: {  // every fifth reading by half to the whole of the range
            const T height = T(0.5) * range * (T(1) + uniform<T>(bits << 8));
            const T spiked = reading + ((bits & 1) != 0 ? height : -height);
            return T(0.2) <= uniform<T>(bits) ? reading : clamp(spiked, model.low, model.high);
        }
        case FaultKind::drift:
            return clamp(reading + T(drift_rate) * since * way, model.low, model.high);
        case FaultKind::shift:
            return clamp(reading + T(shift_height) * way, model.low, model.high);
        case FaultKind::clogged:  // the quantity no longer reaches the sensor, whose own noise goes on
            return quantized(model.resolution, clamp(held + model.noise * normal<T>(bits), model.low, model.high));
        case FaultKind::nan:
            return (reading - reading) / (reading - reading);
        default:
            return reading;
    }
}

/// One reading of one channel: the truth with nonlinearity, offset, walk and noise, clamped and rounded, then its
/// fault, if it has one.
template <class T>
T read_channel(const Sensors<T>& sensors, SensorsState<T>& state, const SensorModel<T>& model, int channel, T truth,
               const Fault<T>* fault, T time) {
    const auto draw = [&](std::uint64_t what, std::uint64_t count) {
        return random_bits(sensors.seed, stream_of(what, channel), count);
    };
    const T offset = model.bias * normal<T>(draw(0, 0));
    if (model.drift > T(0)) state.walk[channel] += model.drift * sensors.root_tick * normal<T>(draw(1, state.count));
    T reading = truth + line_error(model, truth) + offset + state.walk[channel];
    if (model.noise > T(0)) reading += model.noise * normal<T>(draw(2, state.count));
    reading = quantized(model.resolution, clamp(reading, model.low, model.high));
    if (fault == nullptr || state.count == 0) state.held[channel] = reading;
    return fault == nullptr ? reading
                            : failed(model, fault->kind, reading, state.held[channel], time - fault->start, draw(0, 1),
                                     draw(3, state.count));
}

/// Fault of a channel at a time, or null; the first in the list wins, and the kind `none` heals.
template <class T>
const Fault<T>* fault_of(const Fault<T>* faults, int count, int channel, T time) {
    for (int k = 0; k < count; ++k)
        if (faults[k].first <= channel && channel <= faults[k].last && faults[k].start <= time && time < faults[k].end)
            return faults[k].kind == FaultKind::none ? nullptr : faults + k;
    return nullptr;
}

template <class R, class T>
struct Sensed {
    SensorsState<T> state;
    R readings;
};

/// Read the sensors of a reader at `time`; `truth` has the true values in the places of the readings.
template <class T>
void read_channels(const Sensors<T>& sensors, SensorsState<T>& state, Reader reader, const PilotReadings<T>& truth,
                   PilotReadings<T>& readings, const Fault<T>* faults, int fault_count, T time) {
    int kind = 0;
    visit_channels([&](const auto& channel, int first) {
        const SensorModel<T>& model = sensors.model[kind++];
        if (channel.reader != reader) return;
        for (int k = 0; k < channel.count(sensors.joints); ++k)
            channel.of(readings)[k] = read_channel(sensors, state, model, first + k, channel.of(truth)[k],
                                                   fault_of(faults, fault_count, first + k, time), time);
    });
}

/// Read every sensor of the controller once, at `time`. `truth` has the true values in the places of the readings.
template <class T>
Sensed<Readings<T>, T> sense(const Sensors<T>& sensors, const SensorsState<T>& before, const Readings<T>& truth,
                             const Fault<T>* faults, int fault_count, T time) {
    SensorsState<T> state = before;
    PilotReadings<T> readings{};
    read_channels(sensors, state, Reader::controller, without_pilot(truth), readings, faults, fault_count, time);
    ++state.count;
    return {state, readings.robot};
}

/// Read every sensor of controller and pilot once, at `time`. `truth.fixed` is whether the receiver has satellites: a
/// fix comes where it has and one is due. A receiver that failed open, or shows NaN, has no fix.
template <class T>
Sensed<PilotReadings<T>, T> sense(const Sensors<T>& sensors, const SensorsState<T>& before,
                                  const PilotReadings<T>& truth, const Fault<T>* faults, int fault_count, T time) {
    SensorsState<T> state = before;
    PilotReadings<T> readings{};
    for (const Reader reader : {Reader::controller, Reader::pilot})
        read_channels(sensors, state, reader, truth, readings, faults, fault_count, time);
    const Fault<T>* fault = fault_of(faults, fault_count, first_channel("position"), time);
    const bool lost = fault != nullptr && (fault->kind == FaultKind::open || fault->kind == FaultKind::nan);
    readings.fixed = truth.fixed && state.count % std::uint64_t(sensors.fix_every) == 0 && !lost;
    readings.accuracy = truth.accuracy;
    ++state.count;
    return {state, readings};
}

/// Call visit(sensor, name, field) for every number of the models of a reader's sensors.
template <class T, class Visit>
void visit_fields(Sensors<T>& sensors, Reader reader, const Visit& visit) {
    int kind = 0;
    visit_channels([&](const auto& channel, int) {
        SensorModel<T>& s = sensors.model[kind++];
        if (channel.reader != reader) return;
        visit(channel.name, "low", s.low), visit(channel.name, "high", s.high), visit(channel.name, "noise", s.noise);
        visit(channel.name, "resolution", s.resolution), visit(channel.name, "drift", s.drift);
        visit(channel.name, "bias", s.bias), visit(channel.name, "nonlinearity", s.nonlinearity);
    });
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
