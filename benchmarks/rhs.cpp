/// Speed of the right-hand side of the swimming equations, as a part of what this processor can do at all.
///
/// From standard input, white space between the numbers, SI and radians:
///
///     links frequency
///     length com inertia inertia_mass friction drag amplitude lag      for each link
///
/// (inertia_mass with added mass; friction and drag as in Lumped::Coefficients; amplitude and lag of the joint's
/// angle). To standard output, one JSON object without nesting:
///
///     vector_bits                    width of the widest vector in use
///     fma_peak_gflops                fused multiply-adds in independent chains of that width, each counted as two
///     flops_per_rhs                  + - * / of one right-hand side with its part of the Runge-Kutta step, as written
///     scalar_ns, w4_ns, w8_ns        of one right-hand side of one gait, 1, 4 or 8 gaits side by side
///     scalar_fraction, ...           flops_per_rhs / ns / fma_peak_gflops
///     fraction                       the largest of them
///     dual_flops_per_rhs, dual_...   all of this again with derivatives by the three momenta
///
/// Numbers are medians of processor time over repetitions in which the measurements take turns.
#include <algorithm>
#include <ctime>
#include <functional>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "hypertuna/swimming/lumped.hpp"
#include "hypertuna/swimming/periodic.hpp"

using namespace hypertuna;

static constexpr int steps = 128;  // per beat, as in a sweep
static constexpr int evaluations = 4 * steps;
static constexpr int repetitions = 21;

/// A number that counts what is done with it.
struct Counted {
    double x;
    static inline long operations = 0;

    Counted() = default;
    Counted(double number) : x(number) {}
    static Counted done(double result) { return ++operations, Counted(result); }

    friend Counted operator+(Counted a, Counted b) { return done(a.x + b.x); }
    friend Counted operator-(Counted a, Counted b) { return done(a.x - b.x); }
    friend Counted operator*(Counted a, Counted b) { return done(a.x * b.x); }
    friend Counted operator/(Counted a, Counted b) { return done(a.x / b.x); }
    friend Counted operator-(Counted a) { return Counted(-a.x); }  // a change of sign is free
    Counted& operator+=(Counted a) { return *this = *this + a; }
    Counted& operator-=(Counted a) { return *this = *this - a; }
    friend Counted abs(Counted a) { return Counted(std::fabs(a.x)); }
    friend Counted times_abs(Counted a) { return a * abs(a); }
};

/// A swimmer of plain numbers and the table of its beat.
struct Model {
    int links;
    double frequency;
    std::vector<Link<double>> link;
    std::vector<Lumped<double>::Coefficients> coefficients;
    std::vector<LinkShape<double>> shape;
    std::vector<LinkAcceleration<double>> acceleration;
    std::vector<Symmetric<double>> mobility;
    std::vector<Momentum<double>> momentum;
};

static Model read_model(std::istream& in) {
    Model m;
    in >> m.links >> m.frequency;
    if (!in || m.links < 1) return m;
    std::vector<JointShare<double>> joints;
    std::vector<Swing<double>> swings;
    for (int i = 0; i < m.links; ++i) {
        double length, com, inertia, inertia_mass, friction, drag, amplitude, lag;
        in >> length >> com >> inertia >> inertia_mass >> friction >> drag >> amplitude >> lag;
        m.link.push_back({length, com, inertia_mass, inertia});
        m.coefficients.push_back({inertia_mass, inertia, friction, drag});
        joints.push_back({i, 1.0});
        const double ideal = std::numeric_limits<double>::infinity();
        swings.push_back(response(Harmonic<double>{amplitude, lag, 0.0, ideal}, m.frequency));
    }
    m.shape.resize(2 * steps * m.links), m.acceleration.resize(2 * steps * m.links);
    m.mobility.resize(2 * steps), m.momentum.resize(2 * steps);
    const Swimmer<double, Lumped<double>> fish{m.links, m.link.data(), {m.coefficients.data()}};
    std::vector<JointMotion<double>> motion(m.links);
    tabulate_beat(fish, joints.data(), swings.data(), m.frequency, motion.data(),
                  {m.links, 2 * steps, m.shape.data(), m.acceleration.data(), m.mobility.data(), m.momentum.data()});
    return m;
}

/// The model in another scalar, ready to swim: every lane the same gait.
template <class S>
struct Tank {
    std::vector<Link<S>> link;
    std::vector<typename Lumped<S>::Coefficients> coefficients;
    std::vector<LinkShape<S>> shape;
    std::vector<LinkAcceleration<S>> acceleration;
    std::vector<Symmetric<S>> mobility;
    std::vector<Momentum<S>> momentum;
    Swimmer<S, Lumped<S>> fish;
    ShapeTable<S> table;
    S period;

    explicit Tank(const Model& m) : acceleration(m.acceleration.size()), period(1 / m.frequency) {
        for (const auto& l : m.link) link.push_back({S(l.length), S(l.com), S(l.mass), S(l.inertia)});
        for (const auto& k : m.coefficients)
            coefficients.push_back({S(k.inertia_mass), S(k.inertia), S(k.friction), S(k.drag)});
        for (const auto& at : m.shape)
            shape.push_back({S(at.c), S(at.s), S(at.h_t), S(at.h_n), S(at.a_t), S(at.a_n), S(at.w)});
        for (const auto& a : m.mobility) mobility.push_back({S(a.xx), S(a.xy), S(a.xz), S(a.yy), S(a.yz), S(a.zz)});
        for (const auto& p : m.momentum) momentum.push_back({S(p.x), S(p.y), S(p.z)});
        fish = {m.links, link.data(), {coefficients.data()}};
        table = {m.links, 2 * steps, shape.data(), acceleration.data(), mobility.data(), momentum.data()};
    }
    Tank(const Tank&) = delete;

    /// One beat from rest, in scalar V: S itself or its dual numbers.
    template <class V>
    Momentum<V> swim() const {
        return swim_beat(fish, table, 1, period, Momentum<V>{V(S(0)), V(S(0)), V(S(0))});
    }
};

template <class V>
static double flops(const Tank<Counted>& tank) {
    Counted::operations = 0;
    tank.swim<V>();
    return double(Counted::operations) / evaluations;
}

#if defined(__AVX512F__)
static constexpr int widest = 8;
#elif defined(__AVX__)
static constexpr int widest = 4;
#else
static constexpr int widest = 2;
#endif

/// Twelve independent chains hide the latency of a multiply-add on every processor with up to three units of latency
/// four, and fit into sixteen registers with their two constants.
static constexpr int chains = 12, links_of_chain = 20000;

HYPERTUNA_NOINLINE static double multiply_add(double factor, double term) {
    using Wide = VectorOf<double, widest>::type;
    const Wide a = Wide{} + factor, b = Wide{} + term;
    Wide x[chains];
    for (int c = 0; c < chains; ++c) x[c] = b * double(c);
    for (int k = 0; k < links_of_chain; ++k) {
#pragma GCC unroll 12
        for (int c = 0; c < chains; ++c) x[c] = x[c] * a + b;
    }
    Wide sum{};
    for (const Wide& each : x) sum += each;
    return sum[0];
}

static volatile double sink;  // what is written here must be computed

/// One thing to be timed: a name, how often it is done between two looks at the clock, and its times.
struct Contestant {
    std::string name;
    int rounds;
    std::function<double()> work;
    std::vector<double> seconds{};

    void run() {
        const std::clock_t start = std::clock();
        for (int k = 0; k < rounds; ++k) sink = work();
        seconds.push_back(double(std::clock() - start) / CLOCKS_PER_SEC / rounds);
    }
    double median() {
        std::nth_element(seconds.begin(), seconds.begin() + repetitions / 2, seconds.end());
        return seconds[repetitions / 2];
    }
};

static double first(double x) { return x; }
template <int W>
static double first(const Lanes<double, W>& x) {
    return x[0];
}

template <class S>
static void enter(const Tank<S>& tank, const std::string& width, std::vector<Contestant>& race) {
    race.push_back({width, 200, [&] { return first(tank.template swim<S>().x); }});
    race.push_back({"dual_" + width, 100, [&] { return first(tank.template swim<Dual<S, 3>>().x.d[0]); }});
}

int main() {
    const Model model = read_model(std::cin);
    if (!std::cin) {
        std::cerr << "rhs: standard input must give links, frequency and eight numbers for each link\n";
        return 2;
    }
    const Tank<Counted> counted(model);
    const Tank<double> one(model);
    const Tank<Lanes<double, 4>> four(model);
    const Tank<Lanes<double, 8>> eight(model);
    volatile double factor = 0.5, term = 1;
    std::vector<Contestant> race = {{"peak", 50, [&] { return multiply_add(factor, term); }}};
    enter(one, "scalar", race), enter(four, "w4", race), enter(eight, "w8", race);
    for (int k = 0; k < repetitions; ++k)
        for (Contestant& contestant : race) contestant.run();

    const double peak = 2e-9 * chains * links_of_chain * widest / race[0].median();
    std::cout << "{\"vector_bits\": " << 64 * widest << ", \"fma_peak_gflops\": " << peak;
    for (const std::string kind : {"", "dual_"}) {
        const double count = kind.empty() ? flops<Counted>(counted) : flops<Dual<Counted, 3>>(counted);
        double best = 0;
        std::cout << ", \"" << kind << "flops_per_rhs\": " << count;
        for (const auto& [width, gaits] : {std::pair("scalar", 1), {"w4", 4}, {"w8", 8}}) {
            const auto is = [&](const Contestant& c) { return c.name == kind + width; };
            const double ns = 1e9 * std::find_if(race.begin(), race.end(), is)->median() / evaluations / gaits;
            const double fraction = count / ns / peak;
            best = std::max(best, fraction);
            std::cout << ", \"" << kind << width << "_ns\": " << ns << ", \"" << kind << width
                      << "_fraction\": " << fraction;
        }
        std::cout << ", \"" << kind << "fraction\": " << best;
    }
    std::cout << "}\n";
}
