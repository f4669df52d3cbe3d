/// Tests of the failsafes of a joint: it is released above the hard pressure limit, and where it does not follow.
#include "vehicle_test.hpp"

/// A pressure above the hard limit releases its joint: this is reported until the robot is armed again, and the other
/// joint beats on.
static void over_pressure() {
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    contact(300);
    const int channel = hypertuna::first_channel("pressure");
    const Calibration& c = v.model.calibration;
    for (int k = 0; k < 50; ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        board.raw.channel[channel] = {};
        const float pressure = 100e3f + 14e3f * float(k) + 300.0f * float(k % 3);
        board.raw.channel[channel].add(std::int32_t(pressure / c.scale[channel] + c.zero[channel]));
        tick(v, board);
        CHECK(v.now.faults.has(Fault::over_pressure) <= (v.model.pilot.controller.pressure_hard < pressure + 2e3f));
    }
    contact(300);
    CHECK(v.now.faults.has(Fault::over_pressure) && !v.now.faults.has(Fault::no_stroke));
    CHECK(v.now.state == State::gait && v.now.output.target[0] == 0 && v.now.output.target[2] != 0);
    give(v, Order::disarm, ground), contact(300);
    CHECK(give(v, Order::arm, ground) == Refusal::none);
    contact(100);
    CHECK(!v.now.faults.has(Fault::over_pressure));
}

/// A joint that does not follow is released, and reported within some beats; if so chosen, the robot also comes up. A
/// joint that pressure or a sensor limits is not released. Arming gives it another chance.
static void no_stroke() {
    for (Answer answer : {Answer::warn, Answer::surface})
        for (int joint : {0, 1}) {
            choose("stroke_answer", answer);
            CHECK(set_gait(v, ground, beat()) == Refusal::none);
            contact(600);
            CHECK(!v.now.faults.has(Fault::no_stroke));
            board.limp[joint] = true, contact(250);
            CHECK(v.now.faults.has(Fault::no_stroke) && !v.now.faults.has(Fault::over_pressure));
            CHECK(v.state.controller.circuit[2 * joint].stopped && !v.state.controller.circuit[2 - 2 * joint].stopped);
            CHECK(v.now.state == (answer == Answer::warn ? State::gait : State::rest));
            contact(300), give(v, Order::disarm, ground), contact(300);
            board.limp[joint] = false;
            CHECK(give(v, Order::arm, ground) == Refusal::none && set_gait(v, ground, beat()) == Refusal::none);
            contact(600);
            CHECK(!v.now.faults.has(Fault::no_stroke) && !v.state.controller.circuit[2 * joint].stopped);
        }
    for (float part : {0.2f, 0.3f}) {  // a beat is judged only if its bias is less than a quarter of its amplitude
        begin_armed();
        Command<float> biased = beat();
        for (int j = 0; j < 2; ++j) biased.bias[j] = part * biased.amplitude[j];
        CHECK(set_gait(v, ground, biased) == Refusal::none);
        contact(600), board.limp[0] = true, contact(600);
        CHECK(v.now.faults.has(Fault::no_stroke) == (part < 0.25f));
    }
    begin_armed();
    CHECK(set_gait(v, ground, beat()) == Refusal::none);
    board.limp[0] = true;
    for (int k = 0; k < 600; ++k) {
        on_ground_contact(v, ground), float_upright(board, v, int(v.now.tick));
        board.raw.channel[hypertuna::first_channel("pressure")] = {};
        tick(v, board);
    }
    CHECK(v.now.faults.has(Fault::pressure_sensor) && !v.now.faults.has(Fault::no_stroke));
}

/// A servo that turns by less than 0.3 of the angle sent is reported within some beats, with a bias and at any circuit.
/// One that turns further is not, though the joint bends less.
static void a_servo_stands() {
    for (int circuit = 0; circuit < 4; ++circuit)
        for (float bias : {0.0f, 0.3f})
            for (float turns : {0.0f, 0.2f, 0.7f}) {
                begin_armed();
                Command<float> biased = beat();
                for (int j = 0; j < 2; ++j) biased.bias[j] = bias * biased.amplitude[j];
                CHECK(set_gait(v, ground, biased) == Refusal::none);
                contact(600);
                CHECK(!v.now.faults.has(Fault::no_stroke));
                board.stands = circuit, board.turns = turns, contact(400);
                CHECK(v.now.faults.has(Fault::no_stroke) == (turns < 0.3f));
                const int first = circuit / 2 * 2;  // of the joint, which is released
                CHECK(v.state.controller.circuit[first].stopped == (turns < 0.3f));
                CHECK(!v.state.controller.circuit[2 - first].stopped);
            }
}

/// Slope of the line through the angles sent (0, 1, 2, 3) and shown (5, 5, 6, 6): (4 * 35 - 6 * 22) / (4 * 14 - 36) =
/// 8 / 20. A constant offset, such as a shifted sensor's, changes nothing.
static void the_slope_of_a_turn() {
    for (float offset : {0.0f, 100.0f}) {
        Turn turn{};
        for (int k = 0; k < 4; ++k) turn.add(float(k), offset + (k < 2 ? 5.0f : 6.0f));
        CHECK(turn.spread(4) == 20 && turn.less(0.41f, 4) && !turn.less(0.39f, 4));
    }
}

int main() {
    over_pressure();
    no_stroke();
    a_servo_stands();
    the_slope_of_a_turn();
    CHECK(allocations == 0);
    return failures();
}
