/// Muscles: rest, the ideal McKibben muscle and thin walls by hand, energy by quadrature, virtual work by dual numbers.
#include <algorithm>

#include "check.hpp"
#include "hypertuna/actuation/muscle.hpp"

using namespace hypertuna;

static constexpr double degree = pi / 180;

template <class S = double>
static DriveUnit<S> unit(double braid_deg, double c1, double c2, double sleeve = 0) {
    const double t = std::tan(braid_deg * degree);
    return {S(8e-3), S(5.6e-3), S(t * t), S(sleeve), {S(c1), S(c2)}, {S(c1 / 2), S(c2 / 2)}, S(0.1)};
}

static void nothing_at_rest() {
    const DriveUnit<double> m = unit(37, 40e3, 7e3, 1e-3);
    CHECK(energy(m, 1.0) == 0 && energy_slope(m, 1.0) == 0 && carried(m, 1.0) == 0);
    CHECK_NEAR(lumen(m, 1.0), pi / 4 * 5.6e-3 * 5.6e-3, 1e-20);
    CHECK_NEAR(contact(m, 1.0), pi / 4 * 64e-6, 1e-20);
}

/// Without walls the force is pi/4 D^2 P (3 cos^2 theta - 1) / sin^2 theta, and zero where cos^2 theta = 1/3.
static void ideal_mckibben() {
    const DriveUnit<double> m = unit(30, 0, 0);
    for (double stretch : {1.05, 1.0, 0.9, 0.8, 0.7}) {
        const double cosine = stretch * std::cos(30 * degree), sine = std::sqrt(1 - cosine * cosine);
        const double diameter = 8e-3 * sine / std::sin(30 * degree);
        const double wanted = pi / 4 * diameter * diameter * 2e5 * (3 * cosine * cosine - 1) / (sine * sine);
        CHECK_NEAR(pull(m, 2e5, stretch), wanted, 1e-13);
    }
    CHECK_NEAR(pull(m, 2e5, 1.0), pi / 4 * 64e-6 * 2e5 * (3 * 0.75 - 1) / 0.25, 1e-13);  // blocked: 50.3 N
    CHECK_NEAR(pull(m, 2e5, 1 / std::sqrt(3) / std::cos(30 * degree)), 0, 1e-13);        // free: 33 % shorter
}

/// A ring that swells as a balloon: every radius has the circumferential stretch sqrt((1 + B/X) / lambda).
static void thin_wall() {
    const double x = 16e-6, dx = 1e-12, stretch = 0.8, swelling = 5e-6;
    const double l1 = stretch, l2 = std::sqrt((1 + swelling / x) / stretch), l3 = 1 / (l1 * l2);
    const double i1 = l1 * l1 + l2 * l2 + l3 * l3, i2 = 1 / (l1 * l1) + 1 / (l2 * l2) + 1 / (l3 * l3);
    const Wall<double> ring = wall(Mooney<double>{40e3, 7e3}, x, x + dx, stretch, swelling);
    CHECK_NEAR(ring.energy / (pi * dx * (40e3 * (i1 - 3) + 7e3 * (i2 - 3))), 1, 1e-6);
    CHECK(wall(Mooney<double>{40e3, 7e3}, x, x, stretch, swelling).energy == 0);
}

/// The closed form against the strain energy summed over the thickness: Simpson's rule, fourth order.
static void energy_by_quadrature() {
    const Mooney<double> solid{40e3, 7e3};
    const double x1 = 7.84e-6, x2 = 16e-6;
    for (double stretch : {1.12, 0.8})
        for (double swelling : {-3e-6, 5e-6}) {
            const auto density = [&](double x) {
                const double l1 = stretch, l2 = std::sqrt((1 + swelling / x) / stretch), l3 = 1 / (l1 * l2);
                return solid.c1 * (l1 * l1 + l2 * l2 + l3 * l3 - 3) +
                       solid.c2 * (1 / (l1 * l1) + 1 / (l2 * l2) + 1 / (l3 * l3) - 3);
            };
            const auto summed = [&](int n) {
                const double h = (x2 - x1) / n;
                double sum = density(x1) + density(x2);
                for (int k = 1; k < n; ++k) sum += (k % 2 ? 4 : 2) * density(x1 + k * h);
                return pi * sum * h / 3;
            };
            const double exact = wall(solid, x1, x2, stretch, swelling).energy;
            const double coarse = summed(16) - exact, fine = summed(32) - exact;
            CHECK_NEAR(summed(2000) / exact, 1, 1e-10);
            CHECK(14 < coarse / fine && coarse / fine < 17);
        }
}

/// Force is the slope of energy minus pressure times the slope of volume; pressure is the slope of energy over
/// swelling.
static void virtual_work() {
    using D = Dual<double, 1>;
    const DriveUnit<double> m = unit(37, 40e3, 7e3, 1e-3);
    const DriveUnit<D> dual = unit<D>(37, 40e3, 7e3, 1e-3);
    for (double stretch = 0.75; stretch < 1.13; stretch += 0.05) {
        D l(stretch);
        l.d[0] = 1;
        const double slope = energy(dual, l).d[0];
        CHECK_NEAR(energy_slope(m, stretch), slope, 1e-12 * (1 + std::fabs(slope)));
        CHECK_NEAR(lumen_slope(m, stretch), lumen(dual, l).d[0], 1e-18);
        CHECK_NEAR(pull(m, 2.5e5, stretch), (energy(dual, l) - 2.5e5 * lumen(dual, l)).d[0], 1e-11);

        const double swelling = muscle_shape(m, stretch).swelling;
        D B(swelling);
        B.d[0] = 1;
        const double hose = hose_wall(dual, D(stretch), B).energy.d[0],
                     sleeve = sleeve_wall(dual, D(stretch), B).energy.d[0];
        CHECK_NEAR(carried(m, stretch), (hose + sleeve) / pi, 1e-9);
    }
}

static void linear_in_pressure_and_closing() {
    const DriveUnit<double> m = unit(37, 40e3, 0);
    for (double stretch : {0.85, 1.0, 1.08}) {
        const double none = pull(m, 0.0, stretch), one = pull(m, 1e5, stretch);
        CHECK_NEAR(pull(m, 3e5, stretch), none + 3 * (one - none), 1e-12);
    }
    for (double braid : {25.0, 37.0, 54.0})
        for (double left : {0.0, 0.05, 0.5}) {
            const DriveUnit<double> other = unit(braid, 1, 0);
            const double closed = closing_stretch(other, left);
            CHECK(1 < closed);
            CHECK_NEAR(lumen(other, closed), left * lumen(other, 1.0), 1e-18);
        }
}

/// In the printed equation a wall without stiffness turns P into P (1 + (d_o - d_i) / D_i); in the balanced one it
/// passes P on.
static void printed() {
    const DriveUnit<double> m = unit(37, 0, 0);
    for (double stretch : {1.0, 0.85}) {
        const double braid2 = muscle_shape(m, stretch).braid2, area = pi / 4 * braid2;
        const double inside = std::sqrt(braid2 - (64e-6 - 5.6e-3 * 5.6e-3) / stretch);
        const double tan2 = std::pow(std::tan(37 * degree), 2) * braid2 / 64e-6 / (stretch * stretch);
        const double wanted = 2e5 * area * (2 * (1 + 2.4e-3 / inside) / tan2 - 1);
        CHECK_NEAR(printed_pull(m, 2e5, stretch, {true, true}), wanted, 1e-12);
        CHECK_NEAR(printed_pull(m, 2e5, stretch, {true, false}), pull(m, 2e5, stretch), 1e-12);
    }
    // With stiffness, one stress for the whole wall is close to the integral over the wall, and a sleeve carries its
    // part.
    const DriveUnit<double> stiff = unit(37, 40e3, 0), sleeved = unit(37, 40e3, 0, 1e-3);
    CHECK_NEAR(printed_pull(stiff, 2e5, 0.9, {false, false}) / pull(stiff, 2e5, 0.9), 1, 0.05);
    CHECK(printed_pull(sleeved, 2e5, 0.9, {false, false}) < printed_pull(stiff, 2e5, 0.9, {false, false}));
    CHECK_NEAR(printed_pull(sleeved, 2e5, 1.0, {true, false}), printed_pull(stiff, 2e5, 1.0, {true, false}), 1e-10);
}

/// Slopes of the walls' pressure and pull, and their derivatives, against dual numbers.
static void walls_by_dual_numbers() {
    const DriveUnit<Dual<double, 1>> m = unit<Dual<double, 1>>(37, 40e3, 7e3, 1e-3);
    for (double swelling : {-4e-6, -1e-6, 0.0, 3e-6}) {
        Dual<double, 1> B(swelling);
        B.d[0] = 1;
        const auto w = walls(m, Dual<double, 1>(0.9), B);
        CHECK_NEAR(w.rigid.v, w.across.d[0], 1e-12 * w.rigid.v);
        CHECK_NEAR(w.change.v, w.rigid.d[0], 1e-12 * std::abs(w.change.v));
        CHECK_NEAR(w.mixed.v, w.along.d[0], 1e-12 * std::abs(w.mixed.v));
        CHECK_NEAR(w.mixed_slope.v, w.mixed.d[0], 1e-12 * std::abs(w.mixed_slope.v));
    }
}

/// The walls of a slack muscle carry the pressure of the oil, to rounding, found in eight evaluations at most: with air
/// and without, also beside a cavity.
static void slack_muscle() {
    const DriveUnit<double> m = unit(37, 40e3, 7e3, 1e-3);
    int searches = 0, parted = 0;
    for (double air : {0.01, 0.0})
        for (double stretch : {0.85, 0.95, 1.05})
            for (double filled = 0.3; filled < 1.6; filled += 0.05) {  // fraction of the lumen's volume at rest
                const double volume = filled * swollen_lumen(m, 0.0), high = muscle_shape(m, stretch).swelling;
                const double stiff = 1e-9 * volume, gas = air * volume * 101325, lowest = 6325;
                int looks = 0;
                const auto oil = [&](double lumen) {
                    const double excess = volume + stiff * 101325 - lumen;
                    const double root = std::sqrt(excess * excess + 4 * stiff * gas), p = (root + excess) / (2 * stiff);
                    ++looks;
                    if (p < lowest) return OilAt<double>{lowest - 101325, 0, 0};
                    return OilAt<double>{p - 101325, -p / root, p * (root - excess) / (root * root * root)};
                };
                const double carried = walls(m, stretch, high).across / pi;
                if (carried <= oil(swollen_lumen(m, high)).pressure) continue;  // taut
                const double near = std::min(high, swelling_of(m, volume));
                looks = 0;
                const SlackMuscle<double> found = slack_muscle(m, stretch, near, high, true, oil);
                CHECK(looks <= 8);
                const OilAt<double> at = oil(swollen_lumen(m, found.swelling));
                const Wall<double> there = walls(m, stretch, found.swelling);
                CHECK_NEAR(there.across / pi, at.pressure, 1e-6 + 1e-14 * std::abs(at.slope) * volume);
                CHECK_NEAR(found.across, there.across, 1e-13 * 40e3);
                CHECK_NEAR(found.along, there.along, 1e-13 * (1 + std::abs(there.along)));
                CHECK_NEAR(found.energy, there.energy, 1e-13 * (1 + there.energy));
                ++searches, parted += at.slope == 0;
            }
    CHECK(searches > 80 && parted > 0);
}

int main() {
    walls_by_dual_numbers();
    slack_muscle();
    nothing_at_rest();
    ideal_mckibben();
    thin_wall();
    energy_by_quadrature();
    virtual_work();
    linear_in_pressure_and_closing();
    printed();
    return failures();
}
