/// Tests of the sensor models: random numbers, errors and faults; noise depends on the seed and differs between
/// channels.
#include <limits>

#include "check.hpp"
#include "hypertuna/simulation/sensors.hpp"

using namespace hypertuna;

static Sensors<double> perfect() {
    Sensors<double> s{};
    s.joints = 2, s.root_tick = 0.1, s.seed = 7;
    s.of("bend") = {-1.5, 1.5, 0, 0, 0, 0, 0};
    s.of("pressure") = {-1e5, 5e5, 0, 0, 0, 0, 0};
    s.of("current") = {-5, 5, 0, 0, 0, 0, 0};
    s.of("rate") = {-35, 35, 0, 0, 0, 0, 0};
    s.of("acceleration") = {-157, 157, 0, 0, 0, 0, 0};
    s.of("voltage") = {0, 10, 0, 0, 0, 0, 0};
    return s;
}

static Readings<double> truth() {
    Readings<double> r{};
    r.bend[0] = 0.1, r.bend[1] = -0.3;
    for (int c = 0; c < 4; ++c) r.pressure[c] = 6e4 + 1e4 * c, r.current[c] = 0.3;
    r.acceleration[2] = 9.8, r.voltage = 7.4;
    return r;
}

/// Mean 0, deviation 1, and the kurtosis of four uniform numbers, 3 - 6 / (5 * 4), which is nearly the normal one's 3.
static void normal_numbers() {
    const int n = 100000;
    double sum = 0, square = 0, fourth = 0, product = 0, before = 0, largest = 0;
    for (int i = 0; i < n; ++i) {
        const double x = normal<double>(random_bits(1, 5, std::uint64_t(i)));
        sum += x, square += x * x, fourth += x * x * x * x, product += x * before, before = x;
        largest = std::fmax(largest, std::fabs(x));
    }
    const double deviation = 1 / std::sqrt(n);
    CHECK_NEAR(sum / n, 0, 4 * deviation);
    CHECK_NEAR(square / n, 1, 4 * 1.3 * deviation);
    CHECK_NEAR(fourth / n, 2.7, 4 * 6 * deviation);
    CHECK_NEAR(product / n, 0, 4 * deviation);  // neighboring numbers are uncorrelated
    CHECK(largest < 2 * std::sqrt(3.0) + 1e-4);
    // One bit of the seed or of the channel changes all numbers.
    CHECK(random_bits(1, 5, 3) != random_bits(3, 5, 3) && random_bits(1, 5, 3) != random_bits(1, 7, 3));
}

static void a_perfect_sensor_tells_the_truth() {
    const auto [state, readings] = sense(perfect(), SensorsState<double>{}, truth(), (Fault<double>*)nullptr, 0, 0.0);
    CHECK(readings.bend[1] == -0.3 && readings.pressure[3] == 9e4 && readings.acceleration[2] == 9.8);
    CHECK(readings.voltage == 7.4 && state.count == 1);
}

static void errors_by_hand() {
    Sensors<double> s = perfect();
    s.of("bend").nonlinearity = 0.01;  // fraction of the range of 3 rad
    const double top = 1.5 / std::sqrt(3.0);
    CHECK_NEAR(line_error(s.of("bend"), top), 0.03, 1e-15);
    CHECK_NEAR(line_error(s.of("bend"), -top), -0.03, 1e-15);
    CHECK_NEAR(line_error(s.of("bend"), 1.5), 0, 1e-15);
    CHECK(line_error(s.of("bend"), top * 0.9) < 0.03 && line_error(s.of("bend"), top * 1.1) < 0.03);
    CHECK_NEAR(quantized(0.1, 0.26), 0.3, 1e-15);
    CHECK_NEAR(quantized(0.1, -0.24), -0.2, 1e-15);
    CHECK_NEAR(quantized(0.1f, -0.24f), -0.2, 1e-7);
    CHECK(quantized(0.0, 3.7) == 3.7 && quantized(5e-324, 3.7) == 3.7 && quantized(1e-40f, 3.7f) == 3.7f);
    // Beyond its range it shows the end of its range.
    Readings<double> far = truth();
    far.pressure[0] = 7e5;
    CHECK(sense(perfect(), {}, far, (Fault<double>*)nullptr, 0, 0.0).readings.pressure[0] == 5e5);
}

/// Noise, offset and walk have the deviations that they are given; the walk's grows with the root of time.
static void deviations() {
    double noise = 0, walk = 0, offset = 0;
    const int runs = 2000, ticks = 100;  // 1 s
    for (int run = 0; run < runs; ++run) {
        Sensors<double> s = perfect();
        s.seed = std::uint64_t(run);
        s.of("bend").noise = 0.01, s.of("pressure").drift = 100, s.of("current").bias = 0.05;
        SensorsState<double> state{};
        Readings<double> r{};
        for (int i = 0; i < ticks; ++i) {
            const auto next = sense(s, state, truth(), (Fault<double>*)nullptr, 0, 0.01 * i);
            state = next.state, r = next.readings;
        }
        noise += (r.bend[0] - 0.1) * (r.bend[0] - 0.1);
        walk += (r.pressure[0] - 6e4) * (r.pressure[0] - 6e4);
        offset += (r.current[0] - 0.3) * (r.current[0] - 0.3);
    }
    const double tolerance =
        4 / std::sqrt(2.0 * runs);  // four standard errors of a deviation that is estimated from that many runs
    CHECK_NEAR(std::sqrt(noise / runs) / 0.01, 1, tolerance);
    CHECK_NEAR(std::sqrt(walk / runs) / 100, 1, tolerance);
    CHECK_NEAR(std::sqrt(offset / runs) / 0.05, 1, tolerance);
}

/// The readings of each fault from its start on; the other channels do not change.
static void faults_by_hand() {
    Sensors<double> s = perfect();
    s.of("bend").noise = 0.01;
    const Fault<double> faults[] = {
        {FaultKind::stuck, first_channel("bend"), first_channel("bend"), 0.05, 0.1},
        {FaultKind::open, first_channel("pressure") + 1, first_channel("pressure") + 1, 0.05, 1},
        {FaultKind::nan, first_channel("rate"), first_channel("acceleration") + 2, 0.05, 1},
        {FaultKind::spike, first_channel("voltage"), first_channel("voltage"), 0.0, 100}};
    SensorsState<double> sound{}, faulty{};
    double held = 0;
    int spikes = 0;
    for (int i = 0; i < 1000; ++i) {
        const double time = 0.01 * i;
        const auto a = sense(s, sound, truth(), (Fault<double>*)nullptr, 0, time);
        const auto b = sense(s, faulty, truth(), faults, 4, time);
        sound = a.state, faulty = b.state;
        if (time < 0.05) held = a.readings.bend[0];
        const bool stuck = 0.05 <= time && time < 0.1, late = 0.05 <= time && time < 1;
        CHECK(b.readings.bend[0] == (stuck ? held : a.readings.bend[0]));
        CHECK(b.readings.bend[1] == a.readings.bend[1] && b.readings.pressure[0] == a.readings.pressure[0]);
        CHECK(b.readings.pressure[1] == (late ? -1e5 - 0.125 * 6e5 : 7e4));
        CHECK(std::isnan(b.readings.rate[1]) == late && std::isnan(b.readings.acceleration[2]) == late);
        CHECK(0 <= b.readings.voltage && b.readings.voltage <= 10);
        spikes += std::fabs(b.readings.voltage - 7.4) > 2.4;
    }
    CHECK(150 < spikes && spikes < 250);  // every fifth
}

/// By hand: 5 % of the range per second of drift, 20 % of it in a shift, always to one side; a clogged sensor keeps its
/// value and its noise.
static void wrong_by_degrees() {
    Sensors<double> s = perfect();
    const SensorModel<double>& model = s.of("pressure");
    const double range = model.high - model.low;
    const int first = first_channel("pressure");
    const Fault<double> faults[] = {{FaultKind::drift, first, first, 1, 100},
                                    {FaultKind::shift, first + 1, first + 1, 1, 100},
                                    {FaultKind::clogged, first + 2, first + 2, 1, 100}};
    s.of("pressure").noise = 100;
    SensorsState<double> sound{}, faulty{};
    double sum = 0, squares = 0;
    for (int i = 0; i < 1100; ++i) {
        const double time = 0.01 * i;
        Readings<double> rising = truth();
        rising.pressure[2] += 10.0 * i;
        const auto a = sense(s, sound, rising, (Fault<double>*)nullptr, 0, time);
        const auto b = sense(s, faulty, rising, faults, 3, time);
        sound = a.state, faulty = b.state;
        if (time < 1) continue;
        const double drifted = std::fabs(b.readings.pressure[0] - a.readings.pressure[0]);
        CHECK(drifted <= 0.05 * range * (time - 1) + 1e-6);
        if (time < 2) CHECK_NEAR(drifted, 0.05 * range * (time - 1), 1e-6);
        CHECK_NEAR(std::fabs(b.readings.pressure[1] - a.readings.pressure[1]), 0.2 * range, 1e-6);
        const double off = b.readings.pressure[2] - (truth().pressure[2] + 10.0 * 99);
        sum += off, squares += off * off;
    }
    CHECK(std::fabs(sum / 1000) < 400);  // the last reading before the fault had noise of its own
    CHECK_NEAR(std::sqrt(squares / 1000 - sum * sum / 1e6), 100, 15);
}

int main() {
    normal_numbers();
    a_perfect_sensor_tells_the_truth();
    errors_by_hand();
    deviations();
    faults_by_hand();
    wrong_by_degrees();
    return failures();
}
