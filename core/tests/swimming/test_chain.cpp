/// Tests of the chain of links: positions, velocities and accelerations by hand, and by finite differences of an
/// independent kinematics in complex numbers; J^T is the transpose of J.
#include <complex>

#include "check.hpp"
#include "fish.hpp"
#include "hypertuna/swimming/chain.hpp"

using namespace hypertuna;
using Complex = std::complex<double>;

/// Links of 3, 2 and 4 m with centers of mass 1, 1 and 2 m behind their front joints.
static constexpr Link<double> links[3] = {{3, 1, 0, 0}, {2, 1, 0, 0}, {4, 2, 0, 0}};

/// Link 1 stands across (90 degrees, turning at 2 rad/s and 5 rad/s^2), link 2 runs along again (-90 degrees, 1 rad/s
/// and 1 rad/s^2 more): its front joint is at (3, 2) and moves at (-4, 0) and (-10, -8).
static void by_hand() {
    const JointMotion<double> joint[3] = {{0, 0, 0}, {pi / 2, 2, 5}, {-pi / 2, 1, 1}};
    LinkShape<double> at[3];
    LinkAcceleration<double> g[3];
    shape(3, links, joint, at, g);
    const double wanted[3][10] = {
        {1, 0, 0, 1, 0, 0, 0, 0, 0, 0}, {0, 1, 3, 1, 0, 2, 2, -4, 5, 5}, {1, 0, -2, 5, -4, 6, 3, -10 - 18, -8 + 12, 6}};
    for (int i = 0; i < 3; ++i) {
        const double got[10] = {at[i].c,   at[i].s, at[i].h_t, at[i].h_n, at[i].a_t,
                                at[i].a_n, at[i].w, g[i].t,    g[i].n,    g[i].w};
        for (int k = 0; k < 10; ++k) CHECK_NEAR(got[k], wanted[i][k], 1e-14);
    }
    CHECK_NEAR(joint_position(at[2], links[2]).x, 3, 1e-15);
    CHECK_NEAR(joint_position(at[2], links[2]).y, 2, 1e-15);
    CHECK(joint_rate(at, 0) == 0 && joint_rate(at, 1) == 2 && joint_rate(at, 2) == 1);
}

/// Front joint and center of mass of each link, as complex numbers in body axes.
struct Places {
    Complex joint[3], com[3];
    double psi[3];
};

static double angle(int i, double time) { return i == 0 ? 0 : 0.6 * i * std::sin(2 * time + 0.7 * i); }

static Places places(double time) {
    Places out;
    Complex joint = 0;
    double psi = 0;
    for (int i = 0; i < 3; ++i) {
        psi += angle(i, time);
        const Complex along = std::polar(1.0, psi);
        out.psi[i] = psi;
        out.joint[i] = joint;
        out.com[i] = joint + links[i].com * along;
        joint += links[i].length * along;
    }
    return out;
}

static void by_differences() {
    const double h = 1e-4, tolerance = 1e-5;  // h^2 times the fourth derivative, some hundred; rounding 1e-15 / h^2
    for (double time = 0.1; time < 3; time += 0.2) {
        const Places before = places(time - h), now = places(time), after = places(time + h);
        JointMotion<double> joint[3];
        for (int i = 0; i < 3; ++i) {
            const double swing = angle(i, time), rate = (angle(i, time + h) - angle(i, time - h)) / (2 * h);
            joint[i] = {swing, rate, -4 * swing};
        }
        LinkShape<double> at[3];
        LinkAcceleration<double> g[3];
        shape(3, links, joint, at, g);
        for (int i = 0; i < 3; ++i) {
            const Complex along = std::polar(1.0, now.psi[i]);
            // In the link's axes: real part along the link, imaginary part across it.
            const Complex velocity = (after.com[i] - before.com[i]) / (2 * h) * std::conj(along);
            const Complex acceleration = (after.com[i] - 2.0 * now.com[i] + before.com[i]) / (h * h) * std::conj(along);
            const Complex arm = now.com[i] * std::conj(along);  // moments: along x across - across x along
            CHECK_NEAR(at[i].c, along.real(), 1e-15);
            CHECK_NEAR(at[i].s, along.imag(), 1e-15);
            CHECK_NEAR(at[i].h_t, -arm.imag(), 1e-14);
            CHECK_NEAR(at[i].h_n, arm.real(), 1e-14);
            CHECK_NEAR(at[i].a_t, velocity.real(), tolerance);
            CHECK_NEAR(at[i].a_n, velocity.imag(), tolerance);
            CHECK_NEAR(at[i].w, (after.psi[i] - before.psi[i]) / (2 * h), tolerance);
            CHECK_NEAR(g[i].t, acceleration.real(), tolerance);
            CHECK_NEAR(g[i].n, acceleration.imag(), tolerance);
            CHECK_NEAR(g[i].w, (after.psi[i] - 2 * now.psi[i] + before.psi[i]) / (h * h), tolerance);
            CHECK_NEAR(joint_position(at[i], links[i]).x, now.joint[i].real(), 1e-14);
            CHECK_NEAR(joint_position(at[i], links[i]).y, now.joint[i].imag(), 1e-14);
        }
    }
}

/// Power is the same at the links and at the nose: f . (J xi) = (J^T f) . xi.
static void transpose() {
    Random random;
    const auto some = [&] { return random(-2, 2); };
    for (int k = 0; k < 100; ++k) {
        const double psi = 3 * some();
        const LinkShape<double> at = {std::cos(psi), std::sin(psi), some(), some(), 0, 0, 0};
        const Along<double> f = {some(), some(), some()};
        const Twist<double> xi = {some(), some(), some()};
        const Along<double> v = at.velocity(xi);
        const Wrench<double> at_nose = at.wrench(f);
        CHECK_NEAR(at_nose.x * xi.x + at_nose.y * xi.y + at_nose.z * xi.z, f.t * v.t + f.n * v.n + f.w * v.w, 1e-13);
    }
}

int main() {
    by_hand();
    by_differences();
    transpose();
    return failures();
}
