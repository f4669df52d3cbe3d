/// Posture: peaks behind noise, the PID beat by beat, and the closed loop over the gains that a plant may have.
#include "check.hpp"
#include "pilot.hpp"

using namespace hypertuna;

static void median_of_three() {
    CHECK(median(1.0, 2.0, 3.0) == 2 && median(3.0, 1.0, 2.0) == 2 && median(2.0, 3.0, 1.0) == 2);
    CHECK(median(1.0, 9.0, 1.0) == 1);  // a spike never gets through
}

/// Peaks of a sine behind median and low-pass, put right by the low-pass's gain: to 2 % at 16 samples a beat.
static void peaks_of_a_sine() {
    const PostureModel<double> model{0, 0, 0, 0.1, 0.25, 0.1, 0.05, 0.05};
    for (double frequency : {1.0, 3.0, 6.0}) {
        const double turns = frequency * 0.01, A = 0.3, b = 0.1;
        const LowPass<double> filter = low_pass(model, turns, sincos(2 * pi * turns));
        Peaks<double> peaks{};
        BeatShape<double> shape{};
        const int beat = int(std::lround(1 / turns));
        for (int i = 0; i < 5 * beat; ++i) {
            update(peaks, filter.weight, b + A * std::sin(2 * pi * turns * i));
            if (i % beat == beat - 1) shape = close_beat(peaks, filter.gain);
        }
        CHECK_NEAR(shape.amplitude, A, 0.05 * A);
        CHECK_NEAR(shape.bias, b, 0.02);
    }
}

/// The largest of a hundred noisy samples would be too large by twice the noise; behind the filters, by less than a
/// quarter of it.
static void noise_hardly_moves_the_peaks() {
    const PostureModel<double> model{0, 0, 0, 0.1, 0.25, 0.1, 0.05, 0.05};
    const double turns = 0.01, A = 0.3, sigma = 0.0035;
    const LowPass<double> filter = low_pass(model, turns, sincos(2 * pi * turns));
    Peaks<double> noisy{}, clean{};
    double excess = 0;
    const int beats = 400;
    for (int i = 0; i < 100 * beats; ++i) {
        const double x = A * std::sin(2 * pi * turns * i);
        update(clean, filter.weight, x);
        update(noisy, filter.weight, x + sigma * normal<double>(random_bits(1, 0, std::uint64_t(i))));
        if (i % 100 == 99)
            excess += close_beat(noisy, filter.gain).amplitude - close_beat(clean, filter.gain).amplitude;
    }
    CHECK_NEAR(excess / beats / sigma, 0, 0.25);
}

static void the_integrator_does_not_wind_up() {
    const PostureModel<double> model{0.1, 0.8, 0, 0.05, 0.25, 0.1, 0.05, 0.05};
    Pid<double> pid{};
    for (int i = 0; i < 100; ++i) pid = correct(model, pid, 0.1, true, 0.5);
    CHECK(pid.sum == 0);
    pid = correct(model, pid, 0.1, false, 0.5);
    CHECK_NEAR(pid.sum, 0.08, 1e-15);
    CHECK_NEAR(pid.output, 0.09, 1e-15);
    pid = correct(model, pid, -0.05, true, 0.5);  // but it may shrink
    CHECK_NEAR(pid.sum, 0.04, 1e-15);
    for (int i = 0; i < 100; ++i) pid = correct(model, pid, 0.1, false, 0.5);
    CHECK(pid.sum == 0.5 && pid.output == 0.5);
}

/// Error of the amplitude after 4 s, of a plant that makes `gain` of what it is told a tick later.
static double error_after(double frequency, double gain, double seconds) {
    static Controller<double> model = test_controller<double>();
    for (int c = 0; c < 4; ++c) model.map[c] = {{0, 1, 0, 0, 0, 0}};
    model.pressure_soft = 4.9e5, model.pressure_hard = 5e5;  // nothing holds it back
    for (int c = 0; c < 4; ++c) model.circuit[c].speed = 100;
    for (JointModel<double>& joint : model.joint) joint.safe_static = joint.safe_rate = joint.safe_square = 1e-9;
    model.slew = 1;
    ControllerState<double> state = init(model);
    ControllerOutput<double> out{};
    for (int i = 0; i < int(seconds * 100); ++i) {
        const auto next =
            step(model, state, tail_readings(out, gain, i, 1e-4), beat_command<double>(frequency, 0.2, 0.2, 0.0));
        state = next.state, out = next.output;
    }
    return std::fabs(state.posture[0].set.amplitude - state.posture[0].seen.amplitude);
}

/// Half a degree in 4 s at every frequency where the plant makes most of its command; in time also where it does not.
static void the_loop_settles_for_every_gain() {
    const double half_degree = 0.5 * pi / 180;
    for (double frequency : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0})
        for (double gain : {frequency < 2 ? 0.9 : 0.8, 1.0, 1.2})
            CHECK_NEAR(error_after(frequency, gain, 4.01), 0, half_degree);
    CHECK(error_after(1, 0.5, 12) < half_degree);
    CHECK(error_after(6, 1.2, 20) < half_degree);  // does not swing up later
}

int main() {
    median_of_three();
    peaks_of_a_sine();
    noise_hardly_moves_the_peaks();
    the_integrator_does_not_wind_up();
    the_loop_settles_for_every_gain();
    return failures();
}
