/// Satellite receiver: when it has a fix, the fix' error, and the error that the receiver reports.
///
/// Water stops the satellites' waves within millimeters: a receiver under water loses them, and finds them again after
/// the antenna has dried, in a second after a wave and in up to five after a long dive. Switched on without an almanac
/// it takes half a minute to a minute (NEO-M8 data sheet: hot start 1 s, cold start 26 s under open sky). Its first
/// fixes are off by meters. Near walls, cliffs and hulls a reflected signal shifts all fixes of some seconds.
#pragma once

#include "hypertuna/simulation/weather.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct Receiver {
    bool cold;     // switched on without an almanac
    T jump;        // m, largest jump by reflected signals
    T jump_every;  // s, mean time between two, 0 for none
    bool honest;   // the receiver reports the error of a jump
};

/// Order of a receiver's numbers in a row from Python.
inline constexpr const char* receiver_columns[] = {"cold", "jump", "jump_every", "honest"};

template <class T>
Receiver<T> read_receiver(const T* row) {
    return {row[0] != T(0), row[1], row[2], row[3] != T(0)};
}

inline constexpr double cold_start[2] = {30, 60};  // s, shortest and longest time to the first fix after a cold start
inline constexpr double first_error =
    5;  // m, error of the first fix after a dive of a minute or more; twice that after a cold start
inline constexpr double settling = 8;  // s in which the error of the first fix halves

template <class T>
struct ReceiverState {
    T dark;      // s without satellites, 0 with them
    T wait;      // s with satellites until the first fix
    T since;     // s since the first fix
    T error;     // m, error of the first fix
    int losses;  // number of times that the satellites were lost
};

/// State of a receiver that is switched on, with or without an almanac.
template <class T>
ReceiverState<T> switched_on(const Receiver<T>& model, std::uint64_t seed, int losses) {
    const T u = uniform_of<T>(seed, Stream::receiver, std::uint64_t(3 * losses));
    const T wait = model.cold ? T(cold_start[0]) + T(cold_start[1] - cold_start[0]) * u : T(1) + T(4) * u;
    return {T(0), wait, T(0), T(first_error) * (model.cold ? T(2) : T(1)), losses};
}
template <class T>
ReceiverState<T> init(const Receiver<T>& model, std::uint64_t seed) {
    return model.cold ? switched_on(model, seed, 0) : ReceiverState<T>{T(0), T(0), T(1e6), T(0), 0};
}

/// Time until the receiver has a fix again after a time `dark` without satellites, s.
template <class T>
T reacquisition(T dark, T u) {
    return min(T(1), dark) + T(4) * u * dark / (dark + T(60));
}

/// What a receiver adds to the true position in a tick.
template <class T>
struct Reception {
    bool fixed;
    T error[2];  // m east and north
    T reported;  // m, standard deviation that the receiver reports in addition to its noise
};

/// Add the jump of a time, which reflected signals cause. Time is cut into pieces with one jump of 3 to 12 s each.
template <class T>
void add_jump(const Receiver<T>& model, std::uint64_t seed, T time, Reception<T>& out) {
    if (!(T(0) < model.jump_every)) return;
    const std::uint64_t piece = std::uint64_t(time / model.jump_every);
    const auto u = [&](std::uint64_t k) { return uniform_of<T>(seed, Stream::jump, 4 * piece + k); };
    const T length = min(T(3) + T(9) * u(0), model.jump_every);
    const T since = time - T(piece) * model.jump_every - u(1) * (model.jump_every - length);
    if (since < T(0) || length <= since) return;
    const T far = model.jump * (T(1) + T(2) * u(2)) / T(3);
    const auto direction = sincos(T(2 * pi) * u(3));
    out.error[0] += far * direction.sin, out.error[1] += far * direction.cos;
    if (model.honest) out.reported += far;
}

/// One tick of length dt. `sky` is whether the antenna is dry and satellites stand above it.
template <class T>
Reception<T> receive(const Receiver<T>& model, ReceiverState<T>& state, bool sky, T dt, T time, std::uint64_t seed) {
    const auto u = [&](int k) { return uniform_of<T>(seed, Stream::receiver, std::uint64_t(3 * state.losses + k)); };
    if (!sky) {
        if (state.dark == T(0)) ++state.losses;
        state.dark += dt;
        const T again = reacquisition(state.dark, u(0));
        if (state.wait <= again) state.wait = again, state.error = T(first_error) * state.dark / (state.dark + T(60));
        state.since = T(0);
        return {};
    }
    state.dark = T(0);
    if (T(0) < state.wait) {
        state.wait -= dt;
        return {};
    }
    state.since += dt;
    Reception<T> out{true, {}, T(0)};
    const T part = T(1) / (T(1) + state.since * state.since / T(settling * settling));
    const auto direction = sincos(T(2 * pi) * u(1));
    const T off = state.error * part * (T(0.5) + u(2));
    out.error[0] = off * direction.sin, out.error[1] = off * direction.cos;
    out.reported = state.error * part;
    add_jump(model, seed, time, out);
    return out;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
