/// Weather: changes of the current over a run, by a tide and by gusts of wind.
///
/// Water that speeds up carries a robot of its own density along, so the velocity through the water does not change
/// with the weather. The accelerometer does not show this common acceleration: 0.02 m/s^2 for a gust of 0.2 m/s within
/// 10 s.
#pragma once

#include "hypertuna/simulation/sea.hpp"
#include "hypertuna/simulation/sensors.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct Weather {
    T tide[2],
        tide_period;  // m/s toward east and north, s: amplitude and period of a current that swings; none at the start
    T gust[2];        // m/s: current that the strongest wind adds at the surface
    T gust_depth,
        gust_time;  // m: depth at which nothing of the gust is left; s from one strength of the wind to the next
};

/// Order of the weather's numbers in a row from Python.
inline constexpr const char* weather_columns[] = {"tide_east",  "tide_north", "tide_period", "gust_east",
                                                  "gust_north", "gust_depth", "gust_time"};

template <class T>
Weather<T> read_weather(const T* row) {
    return {{row[0], row[1]}, row[2], {row[3], row[4]}, row[5], row[6]};
}

/// Streams of random numbers beyond those of the sensors' channels.
enum class Stream : std::uint64_t { gust = 65536, receiver, jump };
template <class T>
T uniform_of(std::uint64_t seed, Stream stream, std::uint64_t count) {
    return uniform<T>(random_bits(seed, std::uint64_t(stream), count));
}

/// Strength of the wind, 0 to 1: random at equal intervals, smooth between; weak more often than strong.
template <class T>
T wind(const Weather<T>& weather, std::uint64_t seed, T time) {
    const T place = time / weather.gust_time;
    const std::uint64_t before = std::uint64_t(place);
    const T part = place - T(before), smooth = part * part * (T(3) - T(2) * part);
    const auto strength = [&](std::uint64_t k) {
        const T u = uniform_of<T>(seed, Stream::gust, k);
        return u * u;
    };
    return strength(before) + smooth * (strength(before + 1) - strength(before));
}

/// The sea with the weather at a time [s].
template <class T>
Sea<T> sea_at(const Sea<T>& sea, const Weather<T>& weather, std::uint64_t seed, T time) {
    Sea<T> now = sea;
    const T swing = sincos(T(2 * pi) * time / weather.tide_period).sin, blow = wind(weather, seed, time);
    for (int k = 0; k < 2; ++k) now.current[k] += swing * weather.tide[k], now.gust[k] = blow * weather.gust[k];
    now.gust_fade = T(1) / weather.gust_depth;
    return now;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
