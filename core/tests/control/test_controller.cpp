/// Tests of the controller: clamp and slew for any input, faults, timeout, arming; float against double; arbitrary
/// bits.
#define HYPERTUNA_BOARD  // its memory is what bounds the state
#include <bit>
#include <limits>
#include <type_traits>

#include "allocations.hpp"
#include "check.hpp"
#include "pilot.hpp"

using namespace hypertuna;

static_assert(std::is_trivially_copyable_v<Controller<float>> && std::is_trivially_copyable_v<ControllerState<float>>);
static_assert(sizeof(ControllerState<float>) + sizeof(ControllerStep<float>) < 6000);

/// A run with readings of a tail that follows, changed by `spoil` tick by tick.
template <class T, class Spoil>
static ControllerStep<T> run(int ticks, const Spoil& spoil) {
    const Controller<T> model = test_controller<T>();
    ControllerStep<T> now{init(model), {}};
    for (int i = 0; i < ticks; ++i) {
        Readings<T> readings = tail_readings(now.output, 0.9, i);
        Command<T> command = beat_command<T>();
        spoil(i, readings, command);
        now = step(model, now.state, readings, command);
    }
    return now;
}

/// Three parabolas that join smoothly, the middle one through zero: values by hand.
static void the_pump_map() {
    const PumpMap<double> map{-0.5, 0.5, {2, 1, 3, -1, 4, 0}};
    CHECK(servo_angle(map, 0.0) == 0);
    CHECK_NEAR(servo_angle(map, 0.5), 1.25, 1e-15);  // 2 * 0.5 + 0.5^2
    CHECK_NEAR(servo_angle(map, 0.6), 1.25 + 4 * 0.1, 1e-15);
    CHECK_NEAR(servo_angle(map, -0.6), -0.75 - 3 * 0.1 - 0.01, 1e-15);
}

static void a_healthy_tail_beats_without_complaint() {
    std::uint32_t flags = 0;
    const Controller<double> model = test_controller<double>();
    ControllerStep<double> now{init(model), {}};
    double widest = 0;
    for (int i = 0; i < 500; ++i) {
        now = step(model, now.state, tail_readings(now.output, 0.9, i), beat_command<double>());
        flags |= now.output.status.flags;
        if (i > 300) widest = std::fmax(widest, std::fabs(now.output.set[1]));
    }
    CHECK((flags & ((1u << int(Condition::pressure_limit)) - 1)) == 0);  // no fault, not blind
    CHECK_NEAR(widest, 0.3, 0.01);
}

static void faults_are_reported_and_survived() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto bend = run<double>(600, [&](int i, auto& r, auto&) {
        if (i > 300) r.bend[1] = nan;
    });
    CHECK(bend.output.status.has(Condition::bend_fault, 1) && bend.output.status.has(Condition::open_loop, 1));
    CHECK(!bend.output.status.has(Condition::bend_fault, 0));
    // A sensor that changes but does not follow: noise about one angle.
    const auto dull = run<double>(600, [&](int i, auto& r, auto&) { r.bend[0] = 0.1 + 1e-3 * ((7 * i) % 5); });
    CHECK(dull.output.status.has(Condition::bend_fault, 0) && dull.output.status.has(Condition::open_loop, 0));
    CHECK(dull.state.posture[0].more == 0 && dull.state.posture[0].aside == 0);  // nothing was learned from it
    double held = 0;
    const auto stuck = run<double>(
        600, [&](int i, auto& r, auto&) { (i < 300 ? held : r.pressure[2]) = i < 300 ? r.pressure[2] : held; });
    CHECK(stuck.output.status.has(Condition::pressure_fault, 2) && stuck.output.status.has(Condition::blind, 2));
    CHECK(stuck.output.status.flags >> int(Condition::hard_stop) == 0);
}

/// A pressure sensor that is off by 100 kPa contradicts bend and model, to either side and on every circuit; a bend
/// sensor that is off by 0.4 rad contradicts pressures, model and what its pumps were sent to.
static void sensors_that_are_off_are_told_apart() {
    for (int c = 0; c < 4; ++c)
        for (double off : {-1e5, 1e5}) {
            const auto shifted = run<double>(600, [&](int i, auto& r, auto& command) {
                command.frequency = 0.1, command.amplitude[0] = command.amplitude[1] = 0.1;
                if (i > 300) r.pressure[c] += off;
            });
            for (int other = 0; other < 4; ++other)
                CHECK(shifted.output.status.has(Condition::pressure_fault, other) == (other == c));
            CHECK(!shifted.output.status.has(Condition::bend_fault));
        }
    for (int j = 0; j < 2; ++j) {
        const auto bent = run<double>(600, [&](int i, auto& r, auto& command) {
            command.frequency = 0.1, command.amplitude[0] = command.amplitude[1] = 0.1;
            if (i > 300) r.bend[j] += 0.4;
        });
        CHECK(bent.output.status.has(Condition::bend_fault, j) &&
              !bent.output.status.has(Condition::bend_fault, 1 - j));
        CHECK(!bent.output.status.has(Condition::pressure_fault));
    }
}

/// For any target a pump's rate changes smoothly, and the pump draws only as fast as its cylinder stays full.
static void a_pump_turns_smoothly() {
    const Controller<double> model = test_controller<double>();
    const double smooth = model.circuit[0].smooth * model.tick;
    ControllerStep<double> now{init(model), {}};
    double before[4] = {};
    for (int i = 0; i < 600; ++i) {
        Command<double> command = beat_command<double>();
        if (i % 100 < 50) command.frequency = 8, command.bias[0] = i % 200 < 100 ? 0.3 : -0.3;
        command.armed = i % 150 < 140;
        Readings<double> readings = tail_readings(now.output, 0.9, i);
        if (i % 170 > 165) readings.pressure[0] = 3.4e5 + i;  // a release, too
        now = step(model, now.state, readings, command);
        for (int c = 0; c < 4; ++c) {
            const double change = now.state.circuit[c].servo.change;
            CHECK(std::fabs(change - before[c]) < smooth * 1.001);
            CHECK(-model.circuit[c].draw * model.tick * 1.001 < change);
            before[c] = change;
        }
    }
}

/// The correction that good beats taught is kept when the bend sensor fails.
static void the_last_good_correction_is_kept() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double before = run<double>(400, [](int, auto&, auto&) {}).state.posture[0].more;
    const auto after = run<double>(900, [&](int i, auto& r, auto&) {
        if (i >= 400) r.bend[0] = nan;
    });
    CHECK(std::fabs(before) > 1e-3);
    CHECK(after.state.posture[0].more == before);
}

static void the_hard_stop_is_latched_until_armed_anew() {
    const auto pulse = [](int i, auto& r, auto&) {
        if (i >= 200 && i < 203) r.pressure[1] = 3.1e5 - 1e5 * (i == 200);
    };
    const auto stopped = run<double>(400, pulse);
    CHECK(stopped.output.status.has(Condition::hard_stop, 1));
    CHECK(stopped.output.target[0] == 0 && stopped.output.target[1] == 0);  // its joint rests
    CHECK(stopped.state.bend_sent[1] != 0);                                 // the other joint beats on
    const auto armed = run<double>(400, [&](int i, auto& r, auto& c) { pulse(i, r, c), c.armed = i != 300; });
    CHECK(!armed.output.status.has(Condition::hard_stop));
    const auto only_asked = run<double>(400, [&](int i, auto& r, auto& c) { pulse(i, r, c), c.fresh = i % 2 == 0; });
    CHECK(only_asked.output.status.has(Condition::hard_stop));
}

/// The hard limit also holds for a faulty sensor: readings with steps that no working sensor makes still release the
/// joint, after more of them in a row than spikes have.
static void the_hard_stop_believes_any_sensor() {
    const auto high = [](int first, int last) {
        return [=](int i, auto& r, auto&) {
            if (i >= 200 && r.pressure[1] > 0)
                r.pressure[1] = i % 2 == 0 ? -9e4 : 1.5e5;  // steps of 240 kPa: distrusted
            if (first <= i && i < last) r.pressure[1] = 4e5 + 1e3 * (i % 3);
        };
    };
    const auto sure = run<double>(400, high(260, 260 + hard_any));
    CHECK(sure.output.status.has(Condition::pressure_fault, 1) && sure.output.status.has(Condition::hard_stop, 1));
    CHECK(!run<double>(400, high(260, 260 + hard_any - 1)).output.status.has(Condition::hard_stop));
}

/// A pressure that stays bit for bit while the other joint moves the body is a sensor that is stuck.
static void a_sensor_is_stuck_while_anything_moves() {
    const auto stuck = run<double>(600, [](int i, auto& r, auto& c) {
        c.amplitude[1] = 0;
        if (i > 300) r.pressure[2] = 2.3e5;
    });
    CHECK(stuck.output.status.has(Condition::blind, 2));
}

/// The governor bounds the bias like any bend.
static void a_bias_is_governed() {
    const auto pressed = run<double>(900, [](int, auto& r, auto& c) {
        c.frequency = 2, c.amplitude[0] = 0, c.bias[0] = 0.4;
        r.pressure[0] += 1.7e5;
    });
    CHECK(std::fabs(pressed.state.bend_sent[0]) < 0.1);
}

/// A bend that no sensor shows may swing twice as wide as it is sent, and nothing would tell: it is sent at half of the
/// rate that the governor leaves a bend that is seen, 0.8 / 2 of 30 rad/s. A sensor that does not follow shows nothing.
static void a_bend_that_no_sensor_shows_is_slow() {
    const Controller<double> model = test_controller<double>();
    const auto amplitude = [&](bool faulty, int dull) {
        ControllerState<double> state = init(model);
        state.amplitude[0].value = 0.4, state.governor[0].bend_limit = 0.5, state.swing = 0.01;
        state.bend[0].faulty = faulty, state.posture[0].dull = dull;
        return allowed(model, state, 0).amplitude;
    };
    CHECK_NEAR(amplitude(false, 0), 30 * 0.01, 1e-15);
    CHECK_NEAR(amplitude(false, 1), 30 * 0.01, 1e-15);
    CHECK_NEAR(amplitude(true, 0), 0.4 * 30 * 0.01, 1e-15);
    CHECK_NEAR(amplitude(false, 2), 0.4 * 30 * 0.01, 1e-15);
    // Beats too narrow to judge a sensor do not acquit it.
    const auto narrow = run<double>(900, [](int i, auto& r, auto& c) {
        if (i > 500) c.amplitude[0] = 0.02;
        r.bend[0] = 0.1 + 1e-3 * ((7 * i) % 5);
    });
    CHECK(narrow.state.posture[0].dull == 2);
}

/// A pump turns only as fast as the units' pressure leaves margin below the soft limit for its flow: thick oil takes a
/// part of it.
static void a_pump_pushes_no_faster_than_its_oil_allows() {
    const Controller<double> model = test_controller<double>();
    const auto push = [&](double viscosity) {
        ControllerState<double> state = init(model);
        state.viscosity.value = state.viscosity.largest = viscosity;
        const double sent = furthest_angle(model, state, 0, model.circuit[0].rings());
        return follow(model.servo, state.circuit[0].servo, sent).change / model.tick;
    };
    CHECK_NEAR(push(1.0), (1 - flow_held) * 1.9e5 / std::hypot(3e5, 7e4), 1e-9);
    CHECK_NEAR(push(0.0), 1.9e5 / 7e4, 1e-9);
}

/// A pump whose line rings draws more slowly the emptier its cylinder is, because refilling it hammers. The readings
/// show this if the line rings slowly.
static void a_pump_does_not_draw_its_cylinder_empty() {
    Controller<double> model = test_controller<double>();
    SupervisorModel<double>& line = model.circuit[0];
    line.draw = 1e5 / line.hammer;
    const auto draw = [&](double trough) {
        ControllerState<double> state = init(model);
        state.circuit[0].trough = trough;
        state.circuit[0].servo.change = -line.draw * model.tick;
        const double sent = nearest_angle(model, state, 0);
        return -follow(model.servo, state.circuit[0].servo, sent).change / model.tick;
    };
    CHECK_NEAR(draw(line.fill - 9e4), line.draw, 1e-9);
    line.spare = 2 / line.hammer;
    CHECK_NEAR(draw(line.fill + 1e5), line.draw, 1e-9);
    CHECK_NEAR(draw(line.fill - 2.5e4), 0.5 * line.draw, 1e-9);
    for (double empty : {5e4, 9e4}) CHECK_NEAR(draw(line.fill - empty), 0, 1e-9);
}

/// Oil that swings up to the soft limit with a period of two ticks: the pump waits at each crest, and must not use each
/// trough to push, or it would keep the swing up. The hammer of its push is at most 0.02 of the swing.
static void a_pump_does_not_drive_the_ringing_of_its_line() {
    Controller<double> model = test_controller<double>();
    SupervisorModel<double>& line = model.circuit[0];
    line.smooth = 1e5;  // rings, and limits no rate
    ControllerState<double> state = init(model);
    state.viscosity.value = state.viscosity.largest = 0;
    const double swing = model.pressure_soft - line.fill;
    for (int i = 0; i < 10; ++i) {
        use_pressure(model, state, 0, i % 2 == 0 ? model.pressure_soft : line.fill, true);
        const double sent = furthest_angle(model, state, 0, true);
        const double push = line.hammer * follow(model.servo, state.circuit[0].servo, sent).change / model.tick;
        CHECK_NEAR(push, i % 2 == 0 ? 0 : crest_fall * swing, 1e-6 * swing);
        CHECK(push < 0.02 * swing);
    }
}

static void without_commands_the_tail_comes_to_rest() {
    const auto lost = run<double>(500, [](int i, auto&, auto& c) { c.fresh = i < 300; });
    CHECK(lost.output.status.has(Condition::timeout));
    // The tail rests, not only the command: the correction of an amplitude of zero is zero.
    for (int j = 0; j < 2; ++j) CHECK(std::fabs(lost.output.set[j]) < 1e-4 && asked_amplitude(lost.state, j) < 1e-4);
    const auto bad = run<double>(300, [](int i, auto&, auto& c) {
        if (i > 200) c.amplitude[1] = std::nan("");
    });
    CHECK(bad.output.status.has(Condition::bad_command));
    CHECK_NEAR(bad.state.amplitude[1].value, 0.3, 1e-6);  // the last good one
}

/// Single precision, as on the robot, sends the same pulses to within a microsecond.
static void float_against_double() {
    const Controller<double> fine = test_controller<double>();
    const Controller<float> coarse = test_controller<float>();
    ControllerStep<double> a{init(fine), {}};
    ControllerStep<float> b{init(coarse), {}};
    for (int i = 0; i < 1000; ++i) {
        a = step(fine, a.state, tail_readings(a.output, 0.9, i), beat_command<double>());
        b = step(coarse, b.state, tail_readings(b.output, 0.9, i), beat_command<float>());
        for (int s = 0; s < 6; ++s) CHECK_NEAR(b.output.pulse[s], a.output.pulse[s], 1e-6);
    }
}

/// A float of arbitrary bits; every second draw is a special value, such as NaN or infinity.
template <class T>
static T any_number(std::uint64_t bits) {
    const T sane = T(double(std::int64_t(bits)) / 9.3e18);
    switch (bits % 16) {
        case 0:
            return std::numeric_limits<T>::quiet_NaN();
        case 1:
            return std::numeric_limits<T>::infinity();
        case 2:
            return -std::numeric_limits<T>::infinity();
        case 3:
            return std::numeric_limits<T>::max();
        case 4:
            return std::numeric_limits<T>::denorm_min();
        case 5:
            return T(0);
        case 6:
        case 7:
            return std::bit_cast<T>(typename IntegerOf<T>::type(bits >> 8));
        case 8:
        case 9:
            return sane * T(6e5);
        default:
            return sane;
    }
}

template <class T>
static bool all_finite(const ControllerState<T>& s) {
    T sum = s.supply + s.frequency.value;
    for (int j = 0; j < max_joints; ++j)
        sum += s.amplitude[j].value + s.bias[j].value + s.phase[j].value + s.more[j].value + s.aside[j].value +
               s.bend_sent[j] + s.governor[j].ceiling + s.governor[j].bend_limit + s.posture[j].seen.mean +
               s.posture[j].seen.first.x + s.posture[j].seen.third.y + s.posture[j].more + s.posture[j].aside +
               s.oscillator[j].x + s.oscillator[j].y;
    for (int c = 0; c < max_circuits; ++c) sum += s.circuit[c].pressure + s.circuit[c].change;
    return is_finite(sum);
}

/// A million ticks of arbitrary readings and commands: pulses within clamp and slew from the first on, state finite.
template <class T>
static void arbitrary_bits(int ticks) {
    const Controller<T> model = test_controller<T>();
    ControllerStep<T> now{init(model), {}};
    T last[6] = {};
    bool good = true;
    const T most = model.slew * model.tick * T(1.0001);
    for (int i = 0; i < ticks && good; ++i) {
        Readings<T> r;
        Command<T> c;
        std::uint64_t channel = 0;
        const auto draw = [&] { return any_number<T>(random_bits(11, channel++, std::uint64_t(i))); };
        for (T& x : r.bend) x = draw();
        for (T& x : r.pressure) x = draw();
        for (T& x : r.current) x = draw();
        for (int k = 0; k < 3; ++k) r.rate[k] = draw(), r.acceleration[k] = draw();
        r.voltage = draw(), c.frequency = draw();
        for (int j = 0; j < max_joints; ++j) c.amplitude[j] = draw(), c.phase[j] = draw(), c.bias[j] = draw();
        c.fin[0] = draw(), c.fin[1] = draw();
        c.fresh = random_bits(5, 0, std::uint64_t(i)) % 3 != 0, c.armed = random_bits(5, 1, std::uint64_t(i)) % 50 != 0;
        now = step(model, now.state, r, c);
        for (int s = 0; s < 6; ++s) {
            const T pulse = now.output.pulse[s], target = now.output.target[s];
            good = good && model.pulse_min <= pulse && pulse <= model.pulse_max;
            good = good && abs(target - last[s]) <= most;
            last[s] = target;
        }
        good = good && all_finite(now.state);
        if (!good) std::fprintf(stderr, "at tick %d\n", i);
    }
    CHECK(good);
}

int main() {
    const int before = allocations;
    the_pump_map();
    a_healthy_tail_beats_without_complaint();
    faults_are_reported_and_survived();
    sensors_that_are_off_are_told_apart();
    a_pump_turns_smoothly();
    the_last_good_correction_is_kept();
    the_hard_stop_is_latched_until_armed_anew();
    the_hard_stop_believes_any_sensor();
    a_sensor_is_stuck_while_anything_moves();
    a_bias_is_governed();
    a_bend_that_no_sensor_shows_is_slow();
    a_pump_pushes_no_faster_than_its_oil_allows();
    a_pump_does_not_draw_its_cylinder_empty();
    a_pump_does_not_drive_the_ringing_of_its_line();
    without_commands_the_tail_comes_to_rest();
    float_against_double();
    arbitrary_bits<float>(700000);
    arbitrary_bits<double>(300000);
    CHECK(allocations == before);
    return failures();
}
