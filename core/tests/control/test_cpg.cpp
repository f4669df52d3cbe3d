/// Central pattern generator: against Eq. 37, put right and as printed, and free of step-size distortion.
#include "check.hpp"
#include "hypertuna/control/controller.hpp"

using namespace hypertuna;

static constexpr double k = 10, h = 10;  // 1/s: convergence and coupling

static Network<double> network(double tick) { return {std::exp(-2 * k * tick), std::exp(-h * tick)}; }
static Smoothing<double> smoothing(double rate, double tick) { return {rate * tick, std::exp(-rate * tick)}; }

/// Eq. 37 for one oscillator: the linear part rotates if the sign of omega in the second row is `sign` = +1.
/// The factor x in the first row is a misprint, as printed for `factor_x`.
struct Hopf {
    double omega, A, b, sign;
    bool factor_x;
    void step(double& x, double& y, double dt) const {
        const auto rate = [&](double X, double Y, double& dx, double& dy) {
            const double u = X - b, s = A * A - u * u - Y * Y;
            dx = -omega * Y + k / (A * A) * (factor_x ? X : 1) * u * s;
            dy = sign * omega * u + k / (A * A) * Y * s;
        };
        double ax, ay, bx, by;
        rate(x, y, ax, ay);
        rate(x + dt / 2 * ax, y + dt / 2 * ay, bx, by);
        x += dt * bx, y += dt * by;
    }
    int crossings(double seconds) const {  // of x through the bias, after a second
        double x = b + 0.3 * A, y = 0.1 * A;
        int count = 0;
        for (int i = 0; i < int(seconds * 1e5); ++i) {
            const double before = x;
            step(x, y, 1e-5);
            count += i > 100000 && (before - b) * (x - b) < 0;
        }
        return count;
    }
};

/// Both couplings -omega: a saddle, whose solutions run to a fixed point and stay. One sign changed, it beats.
static void the_printed_equation_does_not_oscillate() {
    const double f = 2;
    CHECK(Hopf({2 * pi * f, 0.28, 0.28, -1, true}).crossings(5) == 0);
    CHECK(Hopf({2 * pi * f, 0.28, 0.28, -1, false}).crossings(5) == 0);
    CHECK(Hopf({2 * pi * f, 0.28, 0.28, 1, false}).crossings(5) == 2 * 2 * 4);  // two a beat, 2 Hz, 4 s
}

/// The scaled form is Eq. 37 put right: its output A x + b follows the same path from the same start.
static void the_scaled_oscillator_is_the_corrected_equation() {
    const double omega = 2 * pi * 3, A = 0.28, tick = 0.01;
    const Hopf hopf{omega, A, A, 1, false};
    double x = A + 0.4 * A, y = -0.2 * A;
    Oscillator<double> z{0.4, -0.2};
    for (int i = 0; i < 100; ++i) {
        for (int n = 0; n < 1000; ++n) hopf.step(x, y, tick / 1000);
        z = oscillate(network(tick), z, sincos(omega * tick));
        CHECK_NEAR(A + A * z.x, x, 1e-7);  // midpoint rule in 1e-5 s: (omega dt)^3 / 6 rad a step, 1e5 steps
    }
}

/// Two oscillators and a tick ten times as long: the same phases and radii, to rounding.
static void no_step_size_distortion() {
    const double lag = 0.7, omega = 2 * pi * 6;
    Oscillator<double> a[2], b[2];
    for (int run = 0; run < 2; ++run) {
        const double tick = run == 0 ? 0.01 : 0.001;
        Oscillator<double>* z = run == 0 ? a : b;
        z[0] = {0.3, -0.1}, z[1] = {1.5, 0.4};
        for (int i = 0; i < (run == 0 ? 40 : 400); ++i) {
            z[1] = couple(network(tick), z[1], z[0], sincos(lag));
            for (int n = 0; n < 2; ++n) z[n] = oscillate(network(tick), z[n], sincos(omega * tick));
        }
    }
    for (int n = 0; n < 2; ++n) {
        CHECK_NEAR(a[n].x, b[n].x, 1e-12);
        CHECK_NEAR(a[n].y, b[n].y, 1e-12);
    }
}

/// Phase coupling psi' = -h sin psi: tan(psi / 2) falls by exp(-h t), from a quarter turn ahead; also the sign of Phi
/// in Eq. 37.
static void coupling_brings_the_lag() {
    const double tick = 0.01, lag = 0.7;
    const Oscillator<double> reference{1, 0};
    Oscillator<double> z{std::cos(pi / 2 - lag), std::sin(pi / 2 - lag)};  // psi = -pi / 2
    for (int i = 1; i <= 30; ++i) {
        z = couple(network(tick), z, reference, sincos(lag));
        const double psi = -lag - std::atan2(z.y, z.x);
        CHECK_NEAR(std::tan(psi / 2), -std::exp(-h * tick * i), 1e-13);
        CHECK_NEAR(z.x * z.x + z.y * z.y, 1, 1e-14);  // coupling changes the phase only
    }
    // Where the reference is at the top of its sine, the other still has the lag to go.
    for (int i = 0; i < 300; ++i) z = couple(network(tick), z, reference, sincos(lag));
    CHECK_NEAR(z.x, std::cos(lag), 1e-12);
    CHECK(z.y < 0);
}

/// A critically damped step: 1 - (1 + rate t) exp(-rate t), with any tick.
static void filters_are_exact() {
    for (double tick : {0.01, 0.1}) {
        const double rate = 15;
        Follower<double> y{0, 0};
        for (double t = tick; t < 0.55; t += tick) {
            y = follow(smoothing(rate, tick), y, 1.0);
            CHECK_NEAR(y.value, 1 - (1 + rate * t) * std::exp(-rate * t), 1e-14);
            CHECK_NEAR(y.change, rate * rate * t * std::exp(-rate * t) * tick, 1e-14);
        }
    }
}

/// With A = 0, Eq. 37 creeps to its bias, r = r0 / sqrt(1 + 2 k r0^2 t); a filtered amplitude is there in a second.
static void without_amplitude_the_filter_converges() {
    const double r0 = 0.5, t = 1, creeping = r0 / std::sqrt(1 + 2 * k * r0 * r0 * t);
    CHECK(creeping > 0.2);
    Follower<double> fin{r0, 0};
    for (int i = 0; i < 100; ++i) fin = follow(smoothing(15.8, 0.01), fin, 0.0);
    CHECK(std::fabs(fin.value) < 1e-5);
}

/// If any value of a command jumps, the generator's output stays continuous: it changes at most as its filters allow.
static void commands_jump_but_the_output_does_not() {
    Controller<double> model{};
    const double tick = 0.01, rate = 15.8;
    model.joints = 2, model.tick = tick, model.network = network(tick), model.smoothing = smoothing(rate, tick);
    ControllerState<double> state = init(model);
    double before[2] = {}, largest = 0;
    for (int i = 0; i < 2000; ++i) {
        const bool high = i / 100 % 2 == 0;
        state.target = {high ? 6.0 : 1.0,
                        {high ? 0.3 : 0.1, high ? 0.0 : 0.4},
                        {0, high ? 0.6 : -0.6},
                        {high ? 0.2 : -0.2, 0.1},
                        {}};
        generate(model, state, true);
        for (int j = 0; j < 2; ++j) {
            const double bend = state.bias[j].value + state.amplitude[j].value * state.oscillator[j].x;
            largest = std::fmax(largest, std::fabs(bend - before[j]));
            before[j] = bend;
        }
    }
    // Amplitude 0.4 at 6 Hz, turned by the coupling at most h 1.2 faster; a filter moves at most rate / e of its step.
    CHECK(largest < (0.4 * (2 * pi * 6 + h * 1.2) + (0.4 + 0.4) * rate / std::exp(1.0)) * tick);
    CHECK(largest > 0.4 * 2 * pi * 6 * tick * 0.3);
}

/// The second joint lags the first: sin(p) and sin(p - Phi).
static void the_network_settles_to_its_pattern() {
    Controller<double> model{};
    const double tick = 0.01, lag = 40 * pi / 180, frequency = 2;
    model.joints = 2, model.tick = tick, model.network = network(tick), model.smoothing = smoothing(15.8, tick);
    ControllerState<double> state = init(model);
    state.target = {frequency, {0.28, 0.4}, {0, lag}, {}, {}};
    for (int i = 0; i < 500; ++i) generate(model, state, true);
    for (int i = 0; i < 100; ++i) {
        generate(model, state, true);
        const double p = std::atan2(state.oscillator[0].x, -state.oscillator[0].y);  // x = sin p
        CHECK_NEAR(state.oscillator[1].x, std::sin(p - lag), 1e-12);
    }
    CHECK_NEAR(state.amplitude[1].value, 0.4, 1e-12);
}

int main() {
    the_printed_equation_does_not_oscillate();
    the_scaled_oscillator_is_the_corrected_equation();
    no_step_size_distortion();
    coupling_brings_the_lag();
    filters_are_exact();
    without_amplitude_the_filter_converges();
    commands_jump_but_the_output_does_not();
    the_network_settles_to_its_pattern();
    return failures();
}
