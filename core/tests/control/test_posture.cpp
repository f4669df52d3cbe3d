/// Posture: harmonics of a beat, the law that learns from beat to beat, and the closed loop over a plant's gains.
#include "check.hpp"
#include "pilot.hpp"

using namespace hypertuna;

static const Oscillator<double> nothing{0, 0};

static Oscillator<double> oscillator_at(double phase) { return {std::sin(phase), -std::cos(phase)}; }

/// Feed a beat of 0.1 + 0.3 sin(phase - 0.8) + third harmonic to the fit; NaN is a gap. Returns the phase after it.
template <class Noise>
static double one_beat(PostureState<double>& posture, double turns, double phase, double third, const Noise& noise) {
    int ticks = 0;
    for (bool ended = false; !ended; ++ticks) {
        const double next = phase + 2 * pi * turns, e = noise(ticks);
        const double bend = 0.1 + 0.3 * std::sin(next - 0.8) - third * std::sin(3 * (next - 0.8));
        if (!std::isnan(e)) add_reading(posture, oscillator_at(next), bend + e);
        ended = beat_ends(oscillator_at(phase), oscillator_at(next));
        phase = next;
    }
    posture.seen = refit(posture.seen, posture.error, double(ticks));
    posture.error = {0, nothing, nothing};
    return phase;
}

/// A beat may last a fractional number of ticks and lack readings: the fit converges to the harmonics of the signal.
static void harmonics_are_fitted_exactly() {
    for (double frequency : {1.0, 3.0, 6.0, 7.7})
        for (int gap : {1000, 4}) {
            const auto noise = [&](int i) { return i % gap == gap - 1 ? std::nan("") : 0.0; };
            PostureState<double> posture{};
            double phase = 1e-3;
            for (int k = 0; k < 60; ++k) phase = one_beat(posture, 0.01 * frequency, phase, 0.02, noise);
            // sin(p) - 0.0667 sin(3 p) is 0.3 + 0.02 high: where the first harmonic peaks, so does minus the third.
            CHECK_NEAR(shape(posture.seen).amplitude, 0.32, 1e-9);
            CHECK_NEAR(shape(posture.seen).bias, 0.1, 1e-9);
        }
}

/// At 6 Hz the samples miss the peaks by up to 2 %, in a pattern of three beats. One beat that begins from the fit of
/// the last one finds the peak within 1 % of the change.
static void sampling_does_not_move_the_peaks() {
    PostureState<double> posture{};
    double phase = 1e-3, low = 1, high = 0;
    const auto silent = [](int) { return 0.0; };
    for (int k = 0; k < 40; ++k) {
        phase = one_beat(posture, 0.06, phase, 0.0, silent);
        if (k == 1) CHECK_NEAR(shape(posture.seen).amplitude, 0.3, 0.01 * 0.3);
        if (k >= 10)
            low = std::fmin(low, shape(posture.seen).amplitude), high = std::fmax(high, shape(posture.seen).amplitude);
    }
    CHECK_NEAR(low, 0.3, 1e-9);
    CHECK_NEAR(high, 0.3, 1e-9);
}

/// White noise s in each of n readings: the variance of the peak, first plus third harmonic, is 2 s^2 / n + 2 s^2 / n;
/// that of the mean, s^2 / n. The standard error of a variance of 20,000 beats is 1 %.
static void noise_passes_by_the_formula() {
    const double sigma = 0.0035;
    const int n = 20, beats = 20000;
    double amplitude = 0, bias = 0, phase = 1e-3;
    PostureState<double> posture{};
    for (int k = 0; k < beats; ++k) {
        const auto noise = [&](int i) { return sigma * normal<double>(random_bits(1, 0, std::uint64_t(k * n + i))); };
        phase = one_beat(posture, 1.0 / n, phase, 0.02, noise);
        if (k < 20) continue;
        const BeatShape<double> seen = shape(posture.seen);
        amplitude += (seen.amplitude - 0.32) * (seen.amplitude - 0.32) / (beats - 20);
        bias += (seen.bias - 0.1) * (seen.bias - 0.1) / (beats - 20);
    }
    CHECK_NEAR(amplitude * n / (4 * sigma * sigma), 1, 0.05);
    CHECK_NEAR(bias * n / (sigma * sigma), 1, 0.05);
}

/// A plant that makes 0.8 of its command needs F = 1.25: with K = 0.5 it is 1.125, 1.1875, 1.21875 after three beats.
/// The error shrinks to 1 - K of itself in each beat, at every gain.
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

/// A plant whose gain is a power p of its command: the error shrinks by the factor 1 - K (1 + p) near the solution.
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

/// A plant without limits: its bend is `gain` times the command of the last tick.
static Controller<double> free_controller() {
    Controller<double> model = test_controller<double>();
    for (int c = 0; c < 4; ++c) model.map[c] = {-10, 10, {1, 0, 0, 0, 0, 0}};
    model.pressure_work = 4e5, model.pressure_soft = 4.9e5, model.pressure_hard = 5e5;
    for (int c = 0; c < 4; ++c) model.circuit[c].speed = 100, model.circuit[c].line = model.circuit[c].hammer = 1;
    for (JointModel<double>& joint : model.joint)
        joint.safe_static = joint.safe_rate = joint.safe_square = 1e-9, joint.rate = joint.sent_rate = 1e9;
    model.slew = 100;
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

/// The error is below half a degree after 4 s at every frequency and gain; at 1 Hz, where only two beats teach, for
/// gains closer to one.
static void the_loop_settles_for_every_gain() {
    const double half_degree = 0.5 * pi / 180;
    for (double frequency : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0})
        for (double gain : {frequency < 2 ? 0.8 : 0.6, 1.0, frequency < 2 ? 1.2 : 1.5})
            CHECK_NEAR(error_after(frequency, gain, 4.01), 0, half_degree);
    CHECK(error_after(1, 0.55, 12) < half_degree);
    CHECK(error_after(6, 1.9, 20) < half_degree);  // the loop does not become unstable later
}

int main() {
    harmonics_are_fitted_exactly();
    sampling_does_not_move_the_peaks();
    noise_passes_by_the_formula();
    the_law_by_hand();
    the_law_on_a_curved_plant();
    a_limit_winds_nothing_up();
    the_loop_settles_for_every_gain();
    return failures();
}
