/// Tests of the twin, servos to wake, and its ticks: moments by hand, the joints' work against the oil's, mirror
/// images, order of convergence, reproducible bits.
#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/simulation/twin.hpp"
#include "soft.hpp"

using namespace hypertuna;

/// A circuit of round numbers, filled to 50 kPa.
static Circuit<double> plain_circuit() {
    Circuit<double> c{};
    c.pump = {2.5e-4, 0.02, 0.05, pi / 2, 0, 8e-6, 0};
    c.pump.start = travel(c.pump, 0.0).travel;
    c.servo = {7, 8, 20, 0.3, 7.4, 7, 0.3, 0.009};
    c.resistance = 4e9, c.inertance = 1e7, c.compliance = 2e-12, c.bulk_modulus = 1.4e9, c.air = 0.01;
    c.cavitation = -95e3, c.unit_rest = 6e-6;
    const double swollen = oil_volume(c, 1.0, 50e3);
    c.oil_pump = c.pump.chamber / swollen;
    c.oil_unit = (c.unit_rest + c.compliance * 50e3) / swollen;
    return c;
}

/// Energy of a hinge's springs at an angle from rest, whose slope is their moment.
static double stored(const Spring<double>& spring, double angle) {
    const double square = angle * angle, beyond = spring.beyond(angle);
    return 0.5 * spring.stiffness * square + 0.25 * spring.cubic * square * square +
           0.5 * spring.stop_stiffness * beyond * beyond;
}

/// Two joints and a hinge on the body of a Fish.
template <class Law>
struct Robot {
    static constexpr int D = 3;
    Fish<double, Law> fish{2, 0.2};
    double share[4][D] = {{0, 0, 0}, {1, 0, 0}, {0, 0.5, 0}, {0, 0.5, 1}};
    JointMotion<double> motion[4];
    LinkShape<double> shape[4];
    LinkAcceleration<double> acceleration[4];
    Joint<double> joint[2] = {soft_joint(50e3, 0.02), soft_joint(50e3, 0.02)};
    Circuit<double> circuit[4] = {plain_circuit(), plain_circuit(), plain_circuit(), plain_circuit()};
    double armature[D] = {};
    bool direct[2] = {};
    double gear[2] = {1, 1};
    Spring<double> spring[1] = {{0.5, 0.002, 0, 2, 0.05, 5, 0.02, 0, 0}};
    double filled = taut_load(joint[0], 0.0, 0.0).volume[0], rest[4] = {filled, filled, filled, filled};
    Twin<Tail<double, Law, D>> twin{{{{fish.swimmer, share, false, armature, motion, shape, acceleration},
                                      2,
                                      joint,
                                      direct,
                                      gear,
                                      circuit,
                                      rest,
                                      spring},
                                     {1e4, 16, 14, 0.1, 7.4, 0.9, 0},
                                     1.0,
                                     5e-4,
                                     20},
                                    {}};

    Robot() = default;
    Robot(const Robot&) = delete;
    /// Servo targets at tick k of a beat at 2 Hz; `side` -1 exchanges left and right.
    static void targets(int k, double side, double* out) {
        for (int j = 0; j < 2; ++j) {
            const double swing = side * 0.2 * sincos(2 * pi * 2 * 0.01 * k - 0.7 * j).sin;
            out[2 * j] = swing, out[2 * j + 1] = -swing;
        }
    }
    TwinState<double, D> run(int ticks, double side = 1) {
        TwinState<double, D> state = at_rest(twin);
        for (int k = 0; k < ticks; ++k) {
            double target[2 * D] = {};
            targets(k, side, target);
            driven_tick(twin, state, target);
        }
        return state;
    }
};

/// Moment of oil and silicone, minus viscosity times rate, minus friction.
static void moment_by_hand() {
    const Joint<double> joint = soft_joint(50e3, 0.1);
    const JointLoad<double> load = joint_load(joint, 0.1, -0.01, given_pressures(2e5, 1e5));
    const double base = load.elastic + 2e5 * load.slope[0] + 1e5 * load.slope[1];
    const double rubbed = load.friction[0] * (2e5 - load.carried[0]) + load.friction[1] * (1e5 - load.carried[1]);
    CHECK(rubbed > 0.01);
    CHECK_NEAR(bend_moment(joint, load, 0.0), base, 1e-12);
    CHECK_NEAR(bend_moment(joint, load, 5.0), base - 0.05 - rubbed, 1e-4 * rubbed);
    CHECK_NEAR(bend_moment(joint, load, -5.0), base + 0.05 + rubbed, 1e-4 * rubbed);
}

/// At rest and filled nothing moves, in water and clamped in air.
template <class Law>
static void stays_at_rest() {
    Robot<Law> robot;
    TwinState<double, 3> state = at_rest(robot.twin);
    const double target[6] = {};
    const Tick<double, 3> tick = driven_tick(robot.twin, state, target);
    CHECK_NEAR(tick.seen.circuit[0].pump.pressure, 50e3, 1e-6);
    CHECK_NEAR(tick.seen.circuit[3].unit.pressure, 50e3, 1e-6);
    for (int d = 0; d < 3; ++d) CHECK_NEAR(state.plant.bend.angle[d], 0, 1e-12);
    CHECK_NEAR(state.plant.pose.x, 0, 1e-15);
    // Friction of the gears holds against the fill pressure: four servos idle, beside the watt that is there anyway.
    CHECK_NEAR(tick.servo_power, 1 + 4 * 7.4 * 0.3, 1e-9);
}

/// The work of the oil on the joints equals the gain of the body's and the joints' energy plus the losses by friction,
/// damping and water: virtual work through the whole chain.
template <class Law>
static void work_of_the_oil() {
    Robot<Law> robot;
    const Plant<Tail<double, Law, 3>>& plant = robot.twin.plant;
    TwinState<double, 3> state = robot.run(20);
    struct Flows {
        double energy, out;
        int slack;
        double pressure[4], volume[4];
    };
    // Work of the oil between two instants: a slack muscle's volume changes with its pressure, too.
    const auto oil_work = [](const Flows& a, const Flows& b) {
        double sum = 0;
        for (int c = 0; c < 4; ++c) sum += 0.5 * (a.pressure[c] + b.pressure[c]) * (b.volume[c] - a.volume[c]);
        return sum;
    };
    const auto look = [&](const PlantState<double, 3>& at) {
        bend_tail(plant.body, at.bend);
        Flows f{};
        f.energy = kinetic_energy(robot.fish.swimmer, robot.shape, at.xi);
        f.out = water_loss(robot.fish.swimmer, robot.shape, at.xi);
        for (int j = 0; j < 2; ++j) {
            const JointOil<double> oil{plant.circuit + 2 * j, at.circuit + 2 * j, plant.unit_rest + 2 * j};
            const JointLoad<double> load = joint_load(plant.joint[j], at.bend.angle[j], at.strain[j], oil);
            const double w = at.bend.rate[j];
            f.energy += load.energy;
            f.out += plant.joint[j].viscosity * w * w;
            for (int s = 0; s < 2; ++s)
                f.pressure[2 * j + s] = load.pressure[s], f.volume[2 * j + s] = load.volume[s],
                                   f.slack += load.pressure[s] <= load.carried[s];
            const double thrust = joint_thrust(load);
            f.out += thrust * thrust / plant.joint[j].axial_viscosity + joint_friction(load) * sliding(w) * w;
        }
        f.energy += stored(plant.spring[0], at.bend.angle[2]);
        f.out += plant.spring[0].drag(at.bend.angle[2]) * at.bend.rate[2] * at.bend.rate[2];
        return f;
    };
    double target[6] = {}, work = 0, most = 0;
    int slack = 0;
    Robot<Law>::targets(20, 1, target);
    for (int c = 0; c < 4; ++c) state.targets.angle[c] = target[c];
    const double start = look(state.plant).energy, h = 1e-5;
    PlantOutput<double, 3> seen[2];
    Losses<double> lost{};
    for (int k = 0; k < 5000; ++k) {
        const Flows before = look(state.plant);
        const PlantState<double, 3> half = plant_step(plant, state.plant, state.targets, 0.5 * h, seen, lost);
        state.plant = plant_step(plant, state.plant, state.targets, h, seen, lost);
        const Flows middle = look(half), after = look(state.plant);
        work += oil_work(before, middle) + oil_work(middle, after);
        work -= h / 6 * (before.out + 4 * middle.out + after.out);
        slack += after.slack;
        most = max(most, after.energy);
    }
    CHECK(1000 < slack && slack < 15000);
    CHECK_NEAR(look(state.plant).energy - start, work, 1e-7 * most);
    CHECK(std::fabs(work) > 1e-3 * most);
}

/// Servos on an axle and on tendons: their work equals the gain of body and rotors plus the losses in water, gears and
/// hinge.
template <class Law>
static void work_of_the_servos() {
    Robot<Law> robot;
    for (int j = 0; j < 2; ++j) {
        robot.direct[j] = true;
        robot.gear[j] = 1 + 1.5 * j;
        robot.armature[j] = robot.gear[j] * robot.gear[j] * robot.circuit[2 * j].servo.inertia;
    }
    const Plant<Tail<double, Law, 3>>& plant = robot.twin.plant;
    TwinState<double, 3> state = robot.run(20);
    struct Flows {
        double energy, out;
    };
    const auto look = [&](const PlantState<double, 3>& at) {
        bend_tail(plant.body, at.bend);
        Flows f{kinetic_energy(robot.fish.swimmer, robot.shape, at.xi),
                water_loss(robot.fish.swimmer, robot.shape, at.xi)};
        for (int j = 0; j < 2; ++j) {
            const Servo<double>& servo = plant.circuit[2 * j].servo;
            const double angle = robot.gear[j] * at.bend.angle[j], w = robot.gear[j] * at.bend.rate[j];
            f.energy += 0.5 * servo.inertia * w * w;
            f.out += servo.friction * rubbing(w) * w;
            f.out -= axle_drive(servo, state.targets.supply, state.targets.angle[2 * j], angle, w).torque * w;
        }
        f.energy += stored(plant.spring[0], at.bend.angle[2]);
        f.out += plant.spring[0].drag(at.bend.angle[2]) * at.bend.rate[2] * at.bend.rate[2];
        return f;
    };
    const double start = look(state.plant).energy, h = 1e-5;
    double work = 0, most = 0;
    PlantOutput<double, 3> seen[2];
    Losses<double> lost{};
    for (int k = 0; k < 5000; ++k) {
        const Flows before = look(state.plant);
        const PlantState<double, 3> half = plant_step(plant, state.plant, state.targets, 0.5 * h, seen, lost);
        state.plant = plant_step(plant, state.plant, state.targets, h, seen, lost);
        const Flows middle = look(half), after = look(state.plant);
        work -= h / 6 * (before.out + 4 * middle.out + after.out);
        most = max(most, after.energy);
    }
    CHECK(std::fabs(work) > 1e-3 * most);
    CHECK_NEAR(look(state.plant).energy - start, work, 1e-7 * most);
    // The circuit's state is the joint's, or the drum's.
    for (int j = 0; j < 2; ++j) {
        CHECK_NEAR(state.plant.circuit[2 * j].angle, robot.gear[j] * state.plant.bend.angle[j], 1e-12);
        CHECK_NEAR(state.plant.circuit[2 * j].rate, robot.gear[j] * state.plant.bend.rate[j], 1e-11);
        CHECK(state.plant.circuit[2 * j + 1].angle == 0 && state.plant.energy[2 * j + 1] == 0);
    }
}

/// A servo without load: at rest on its target, at most as fast as its voltage lets it, never beyond its stall torque.
static void limits_of_an_axle() {
    const Servo<double> servo{7, 8, 20, 0, 7.4, 7, 0.3, 0.009};
    CHECK(axle_drive(servo, 7.4, 0.4, 0.4, 0.0).torque == 0);
    CHECK_NEAR(axle_drive(servo, 7.4, 3.0, 0.0, 0.0).torque, 7, 1e-12);
    CHECK_NEAR(axle_drive(servo, 3.7, 3.0, 0.0, 0.0).torque, 3.5, 1e-12);  // half of the voltage
    CHECK_NEAR(axle_drive(servo, 7.4, 9.0, 0.0, 8.0).torque, 0, 1e-12);    // without load at full speed
    CHECK_NEAR(axle_drive(servo, 7.4, 9.0, 0.0, 4.0).torque, 3.5, 1e-12);
    // Stalled, all power is heat: rated voltage times stall current, beside the electronics'.
    const ServoDrive<double> stalled = axle_drive(servo, 7.4, 3.0, 0.0, 0.0);
    CHECK_NEAR(servo_power(servo, stalled, 7.4, stalled.torque, 0.0).total, 7.4 * (7 + 0.3), 1e-9);
}

/// Sum of all losses, W.
static double total(const Losses<double>& losses) {
    double sum = 0;
#define HYPERTUNA_EACH(name, from, sentence) sum += losses.name;
    HYPERTUNA_LOSSES(HYPERTUNA_EACH)
#undef HYPERTUNA_EACH
    return sum;
}

/// Losses add up to the servos' power, at every instant and as means of a tick: for joints with oil, with a servo on
/// the axle, and both.
template <class Law>
static void losses_add_up(bool first, bool second) {
    Robot<Law> robot;
    robot.direct[0] = first, robot.direct[1] = second;
    for (int j = 0; j < 2; ++j) robot.armature[j] = robot.direct[j] ? robot.circuit[2 * j].servo.inertia : 0;
    for (Circuit<double>& circuit : robot.circuit) circuit.pump.seal = 10, circuit.loss = 1e12;
    TwinState<double, 3> state = robot.run(60);
    double hinge = 0;
    for (int k = 60; k < 110; ++k) {
        double target[6] = {};
        Robot<Law>::targets(k, 1, target);
        const Tick<double, 3> tick = driven_tick(robot.twin, state, target);
        double power = 0;
        for (int c = 0; c < 4; ++c) power += tick.seen.circuit[c].power.total;
        CHECK_NEAR(total(tick.seen.losses), power, 1e-12 * power);
        CHECK_NEAR(total(tick.losses), tick.servo_power, 1e-12 * tick.servo_power);
        CHECK(tick.losses.gears > 0 && tick.losses.idle > 1);
        hinge += tick.losses.hinge;
        CHECK((tick.losses.line > 0 && tick.losses.seals > 0 && tick.losses.silicone > 0) == !(first && second));
    }
    CHECK(hinge > 0);
}

/// With left and right exchanged, the motion is the mirror image.
template <class Law>
static void mirror() {
    Robot<Law> robot;
    const TwinState<double, 3> a = robot.run(50, 1), b = robot.run(50, -1);
    CHECK(std::fabs(a.plant.bend.angle[0]) > 0.02);
    for (int d = 0; d < 3; ++d) CHECK_NEAR(a.plant.bend.angle[d], -b.plant.bend.angle[d], 1e-9);
    CHECK_NEAR(a.plant.pose.x, b.plant.pose.x, 1e-9);
    CHECK_NEAR(a.plant.pose.y, -b.plant.pose.y, 1e-9);
    CHECK_NEAR(a.plant.circuit[0].passed, b.plant.circuit[1].passed, 1e-15);
}

/// Fourth order or better while no servo is at its torque limit, which is a kink, and the joints do not rub: a tenth of
/// the beat of the other tests. The twin itself takes twenty steps a tick.
template <class Law>
static void converges() {
    Robot<Law> robot;
    for (Joint<double>& joint : robot.joint) joint.soft.unit.friction = 0;
    double angle[3];
    const int steps[3] = {20, 40, 320};
    for (int k = 0; k < 3; ++k) {
        robot.twin.steps = steps[k];
        robot.twin.step = 0.01 / steps[k];
        angle[k] = robot.run(5, 0.1).plant.bend.angle[1];
    }
    const double coarse = std::fabs(angle[0] - angle[2]), fine = std::fabs(angle[1] - angle[2]);
    CHECK(std::fabs(angle[2]) > 1e-3);
    CHECK(coarse < 1e-5 * std::fabs(angle[2]));
    CHECK(coarse > 12 * fine);
}

/// A copied state continues with the same bits.
static void repeats() {
    Robot<Lumped<double>> robot;
    const TwinState<double, 3> a = robot.run(30), b = robot.run(30);
    for (int d = 0; d < 3; ++d) CHECK(same_bits(a.plant.bend.rate[d], b.plant.bend.rate[d]));
    CHECK(same_bits(a.taken, b.taken) && a.taken > 0);
}

/// Charge that a run takes: the integral of P / (efficiency V) dt, with V (V0 - V) = R P / efficiency and V0 falling
/// linearly with the charge; P is the rate of the servos' energies, plus the idle watt.
static void battery_pays_for_the_run() {
    Robot<Lumped<double>> robot;
    TwinState<double, 3> state = at_rest(robot.twin);
    const auto energy = [&] {
        double sum = 0;
        for (int c = 0; c < 4; ++c) sum += state.plant.energy[c];
        return sum;
    };
    const double dt = 0.01;
    double charge = 0, most = 0;
    for (int k = 0; k < 50; ++k) {
        double target[6] = {};
        Robot<Lumped<double>>::targets(k, 1, target);
        const double before = energy();
        driven_tick(robot.twin, state, target);
        const double power = (energy() - before) / dt + 1, open = 14 + (16 - 14) * (1 - charge / 1e4);
        const double voltage = (open + std::sqrt(open * open - 4 * 0.1 * power / 0.9)) / 2;
        CHECK_NEAR(state.battery.voltage, voltage, 1e-12);
        charge += power / (0.9 * voltage) * dt;
        most = max(most, power);
    }
    CHECK_NEAR(state.taken, charge, 1e-12);
    CHECK(most > 20);  // beside 10 W of idle servos
}

/// The IMU reads the second derivative of the path of the head's center of mass, turned into the head's axes, and the
/// first one of the heading: differences of three poses.
template <class Law>
static void imu_reads_the_path() {
    Robot<Law> robot;
    TwinState<double, 3> state = robot.run(33);
    const double com = robot.fish.swimmer.link[0].com, h = 2e-5;
    PlantOutput<double, 3> seen[2], now;
    Losses<double> lost{};
    double x[3], y[3], heading[3];
    Readings<double> read{};
    for (int k = 0; k < 3; ++k) {
        const Pose<double>& pose = state.plant.pose;
        const auto turn = sincos(pose.heading);
        x[k] = pose.x + com * turn.cos, y[k] = pose.y + com * turn.sin, heading[k] = pose.heading;
        if (k == 1) {
            plant_rate(robot.twin.plant, state.plant, state.targets, &now);
            read = true_readings(robot.twin, state, now);
        }
        state.plant = plant_step(robot.twin.plant, state.plant, state.targets, h, seen, lost);
    }
    const double east = (x[2] - 2 * x[1] + x[0]) / (h * h), north = (y[2] - 2 * y[1] + y[0]) / (h * h);
    const auto turn = sincos(heading[1]);
    const double along = turn.cos * east + turn.sin * north, across = turn.cos * north - turn.sin * east;
    CHECK_NEAR(read.rate[2], (heading[2] - heading[0]) / (2 * h), 1e-5);
    CHECK_NEAR(read.acceleration[0], along, 1e-4);
    CHECK_NEAR(read.acceleration[1], across, 1e-4);
    // The comparison is sensitive to each of its terms.
    const Twist<double>& xi = state.plant.xi;
    CHECK(std::fabs(xi.z * xi.y) > 1e-3 && com * xi.z * xi.z > 1e-3);
    CHECK(std::fabs(xi.z * xi.x) > 1e-3 && std::fabs(com * now.twist_rate.z) > 1e-3);
}

/// NaN and runaway states are distinguished from states of a robot.
static void tells_divergence() {
    PlantState<double, 3> at{};
    CHECK(plausible(at));
    at.bend.angle[2] = 4;
    CHECK(!plausible(at));
    at.bend.angle[2] = std::nan("");
    CHECK(!plausible(at));
    at.bend.angle[2] = 0, at.circuit[1].flow = INFINITY;
    CHECK(!plausible(at));
}

template <class Law>
static void each_law() {
    stays_at_rest<Law>();
    work_of_the_oil<Law>();
    work_of_the_servos<Law>();
    losses_add_up<Law>(false, false);
    losses_add_up<Law>(true, false);
    losses_add_up<Law>(true, true);
    mirror<Law>();
    converges<Law>();
}

int main() {
    moment_by_hand();
    limits_of_an_axle();
    WaterLaws::each<double>([](auto law) { each_law<typename decltype(law)::type>(); });
    WaterLaws::each<double>([](auto law) { imu_reads_the_path<typename decltype(law)::type>(); });
    battery_pays_for_the_run();
    repeats();
    tells_divergence();
    return failures();
}
