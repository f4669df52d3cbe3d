/// Posture: least squares of a beat, the law that learns from beat to beat, and the closed loop over a plant's gains.
#include "check.hpp"
#include "pilot.hpp"

using namespace hypertuna;

/// Sums over `count` ticks of b + A sin(phase + lag) beside an oscillator that turns by `turns` of a beat per tick.
template <class Noise>
static BeatSums<double> beat_of(double turns, int count, double A, double lag, double b, const Noise& noise) {
    BeatSums<double> beat{};
    for (int i = 0; i < count; ++i) {
        const double phase = 2 * pi * turns * i, e = noise(i);
        if (std::isnan(e)) continue;  // a gap
        const double bend = b + A * std::sin(phase);
        add_reading(beat, std::sin(phase), -std::cos(phase), bend, b + A * std::sin(phase + lag) + e);
    }
    return beat;
}

/// A beat need not be a whole number of ticks, nor have all its readings.
static void a_sine_is_fitted_exactly() {
    for (double frequency : {1.0, 3.0, 6.0, 7.7})
        for (int gap : {1000, 4}) {
            const double turns = 0.01 * frequency;
            const auto noise = [&](int i) { return i % gap == gap - 1 ? std::nan("") : 0.0; };
            const BeatSums<double> beat = beat_of(turns, int(std::lround(1 / turns)), 0.3, -0.8, 0.1, noise);
            const BeatShape<double> sent = fit(beat, beat.sent), seen = fit(beat, beat.seen);
            CHECK_NEAR(sent.amplitude, 0.3, 1e-12);
            CHECK_NEAR(sent.bias, 0.1, 1e-12);
            CHECK_NEAR(seen.amplitude, 0.3, 1e-12);
            CHECK_NEAR(seen.bias, 0.1, 1e-12);
        }
}

/// White noise s in each of n readings: variance 2 s^2 / n of the amplitude and s^2 / n of the middle. The standard
/// error of a variance of 20,000 beats is 1 %.
static void noise_passes_by_the_formula() {
    const double sigma = 0.0035;
    const int n = 20, beats = 20000;
    double amplitude = 0, bias = 0;
    for (int k = 0; k < beats; ++k) {
        const auto noise = [&](int i) { return sigma * normal<double>(random_bits(1, 0, std::uint64_t(k * n + i))); };
        const BeatSums<double> beat = beat_of(1.0 / n, n, 0.3, -0.8, 0.1, noise);
        const BeatShape<double> seen = fit(beat, beat.seen);
        amplitude += (seen.amplitude - 0.3) * (seen.amplitude - 0.3) / beats;
        bias += (seen.bias - 0.1) * (seen.bias - 0.1) / beats;
    }
    CHECK_NEAR(amplitude * n / (2 * sigma * sigma), 1, 0.05);
    CHECK_NEAR(bias * n / (sigma * sigma), 1, 0.05);
}

/// A plant that makes 0.8 of its command needs F = 1.25: with K = 0.5 it is 1.125, 1.1875, 1.21875 after three beats.
/// The error falls by 1 - K in each beat, whatever the gain.
static void the_law_by_hand() {
    double more = 0;
    for (double expected : {0.125, 0.1875, 0.21875}) {
        const double sent = 0.3 * (1 + more), seen = 0.8 * sent;
        more = learn(more, sent / seen - 1, 0.5, false);
        CHECK_NEAR(more, expected, 1e-12);
    }
    for (double gain : {0.5, 0.9, 1.2, 2.0}) {
        const double target = 1 / gain - 1;
        more = 0;
        for (int k = 0; k < 10; ++k) {
            const double before = more - target;
            more = learn(more, 1 / gain - 1, 0.5, false);
            CHECK_NEAR(more - target, 0.5 * before, 1e-12);
        }
    }
}

/// A plant whose gain goes with a power p of what it is sent: the error falls by 1 - K (1 + p) near the solution.
static void the_law_on_a_curved_plant() {
    for (double p : {-0.5, 0.5, 1.0}) {
        double more = 0;
        for (int k = 0; k < 40; ++k) {
            const double sent = 1 + more, seen = 0.8 * std::pow(sent, 1 + p);
            more = learn(more, sent / seen - 1, 0.5, false);
        }
        CHECK_NEAR(0.8 * std::pow(1 + more, 1 + p), 1, 1e-4);
    }
}

static void a_limit_winds_nothing_up() {
    double more = 0.1;
    for (int k = 0; k < 100; ++k) more = learn(more, 1.0, 0.5, true);
    CHECK(more == 0.1);
    CHECK_NEAR(learn(more, 0.0, 0.5, true), 0.05, 1e-15);  // but it may shrink
}

/// A plant that makes `gain` of what it is told a tick later; nothing holds it back.
static Controller<double> free_controller() {
    Controller<double> model = test_controller<double>();
    for (int c = 0; c < 4; ++c) model.map[c] = {{0, 1, 0, 0, 0, 0}};
    model.pressure_soft = 4.9e5, model.pressure_hard = 5e5;
    for (int c = 0; c < 4; ++c) model.circuit[c].speed = 100;
    for (JointModel<double>& joint : model.joint) joint.safe_static = joint.safe_rate = joint.safe_square = 1e-9;
    model.slew = 1;
    return model;
}

/// Error of the amplitude that the plant makes after some seconds.
static double error_after(double frequency, double gain, double seconds) {
    static const Controller<double> model = free_controller();
    ControllerState<double> state = init(model);
    ControllerOutput<double> out{};
    for (int i = 0; i < int(seconds * 100); ++i) {
        const auto next =
            step(model, state, tail_readings(out, gain, i, 1e-4), beat_command<double>(frequency, 0.2, 0.2, 0.0));
        state = next.state, out = next.output;
    }
    return std::fabs(gain * asked_amplitude(state, 0) - 0.2);
}

/// Half a degree in 4 s at every frequency and gain; at 1 Hz, where two beats teach, of gains nearer to one.
static void the_loop_settles_for_every_gain() {
    const double half_degree = 0.5 * pi / 180;
    for (double frequency : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0})
        for (double gain : {frequency < 2 ? 0.9 : 0.7, 1.0, frequency < 2 ? 1.2 : 1.5})
            CHECK_NEAR(error_after(frequency, gain, 4.01), 0, half_degree);
    CHECK(error_after(1, 0.55, 12) < half_degree);
    CHECK(error_after(6, 1.9, 20) < half_degree);  // does not swing up later
}

int main() {
    a_sine_is_fitted_exactly();
    noise_passes_by_the_formula();
    the_law_by_hand();
    the_law_on_a_curved_plant();
    a_limit_winds_nothing_up();
    the_loop_settles_for_every_gain();
    return failures();
}
