/// Satellite receiver and weather: when fixes come, by how much they are wrong, and water that changes with time.
#include <algorithm>

#include "check.hpp"
#include "hypertuna/simulation/receiver.hpp"

using namespace hypertuna;

constexpr double tick = 0.01;

/// Seconds with satellites until a fix, after a time without.
static double wait_after(double dark, std::uint64_t seed) {
    const Receiver<double> model{};
    ReceiverState<double> state = init(model, seed);
    double time = 0;
    for (; time < dark; time += tick) CHECK(!receive(model, state, false, tick, time, seed).fixed);
    const double up = time;
    while (!receive(model, state, true, tick, time, seed).fixed) time += tick;
    return time - up;
}

/// A wave delays the next fix by its own length; a dive by one second and up to four more, the more the longer it was.
static void it_finds_the_satellites_again() {
    double sum = 0, longest = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        CHECK(wait_after(0.2, seed) < 0.25);
        const double minute = wait_after(60, seed), hour = wait_after(3600, seed);
        CHECK(1 <= minute + tick && minute < 3.1);
        CHECK(minute <= hour && hour <= 5.02);
        sum += hour, longest = std::max(longest, hour);
    }
    CHECK_NEAR(sum / 200, 1 + 4 * 0.5 * 3600 / 3660, 0.2);
    CHECK(4.5 < longest);
}

/// A first fix without an almanac takes half a minute to a minute of sky; time under water does not count.
static void a_cold_start() {
    const Receiver<double> model{true, 0, 0, true};
    double least = 1e9, most = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        ReceiverState<double> state = init(model, seed);
        double time = 0;
        while (!receive(model, state, true, tick, time, seed).fixed) time += tick;
        least = std::min(least, time), most = std::max(most, time);
    }
    CHECK(30 <= least && least < 31 && 59 < most && most < 60.1);
    ReceiverState<double> state = init(model, 1);
    const double wait = state.wait;
    for (int k = 0; k < 3000; ++k) receive(model, state, false, tick, k * tick, 1);
    CHECK(state.wait == wait);
}

/// The first fix after a long dive is off by meters, reports this, and gets better.
static void first_fixes() {
    double first = 0, reported = 0, later = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const Receiver<double> model{};
        ReceiverState<double> state = init(model, seed);
        double time = 0;
        for (; time < 300; time += tick) receive(model, state, false, tick, time, seed);
        Reception<double> got{};
        for (; !got.fixed; time += tick) got = receive(model, state, true, tick, time, seed);
        first += std::hypot(got.error[0], got.error[1]) / 200, reported += got.reported / 200;
        for (int k = 0; k < 6000; ++k, time += tick) got = receive(model, state, true, tick, time, seed);
        later += std::hypot(got.error[0], got.error[1]) / 200;
    }
    CHECK_NEAR(first, 5.0 * 300 / 360, 0.3);
    CHECK_NEAR(reported, 5.0 * 300 / 360, 0.01);
    CHECK(later < 0.1);
}

/// Jumps last 3 to 12 s, are between a third and the whole of the largest, and come as often as they should.
static void jumps() {
    for (const bool honest : {true, false}) {
        const Receiver<double> model{false, 30, 100, honest};
        ReceiverState<double> state = init(model, 7);
        int count = 0;
        double lasting = 0;
        bool before = false;
        for (int k = 0; k < 1000000; ++k) {
            const Reception<double> got = receive(model, state, true, tick, k * tick, 7);
            const double off = std::hypot(got.error[0], got.error[1]);
            const bool now = 1 < off;
            if (now)
                CHECK(9.9 < off && off < 30.1 && (honest ? std::abs(got.reported - off) < 0.1 : got.reported < 0.1));
            count += now && !before, lasting += now * tick, before = now;
        }
        CHECK_NEAR(count, 100, 1);
        CHECK_NEAR(lasting / count, 7.5, 0.7);
    }
}

/// A gust is none or all of its strength at most, changes smoothly, and leaves the deep alone; a tide swings.
static void weather_by_hand() {
    const Sea<double> still{1000, {0.1, 0}, {0, 0}, 1e300, 1e4, {0, 0.5, -0.866}, 101325, {0, 0}, 0, {}};
    const Weather<double> weather{{0, 0.2}, 40, {0.3, 0}, 2, 10};
    double least = 1, most = 0, before = wind(weather, 3, 0.0);
    for (int k = 1; k < 100000; ++k) {
        const double now = wind(weather, 3, k * tick);
        CHECK(std::abs(now - before) < 1.5 * tick / 10 + 1e-12);
        least = std::min(least, now), most = std::max(most, now), before = now;
    }
    CHECK(0 <= least && least < 0.01 && 0.9 < most && most <= 1);
    const Sea<double> now = sea_at(still, weather, 3, 10.0);
    CHECK_NEAR(current(now, -3.0).y, 0.2, 1e-6);
    CHECK_NEAR(current(now, -3.0).x, 0.1, 1e-12);
    CHECK_NEAR(current(now, 0.0).x, 0.1 + 0.3 * wind(weather, 3, 10.0), 1e-12);
    CHECK_NEAR(current(now, -1.0).x, 0.1 + 0.15 * wind(weather, 3, 10.0), 1e-12);
    CHECK_NEAR(current_rate(now, -1.0, 0.5).x, 0.5 * 0.15 * wind(weather, 3, 10.0), 1e-12);  // rising into the wind
    CHECK(current_rate(now, -3.0, 0.5).x == 0);
    CHECK_NEAR(sea_at(still, weather, 3, 0.0).current[1], 0, 1e-12);
}

int main() {
    it_finds_the_satellites_again();
    a_cold_start();
    first_fixes();
    jumps();
    weather_by_hand();
    return failures();
}
