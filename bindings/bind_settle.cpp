#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <atomic>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include "hypertuna/host/beat_gradient.hpp"
#include "hypertuna/host/beat_status.hpp"
#include "hypertuna/host/directions.hpp"
#include "hypertuna/host/spring_steps.hpp"
#include "hypertuna/host/yielding.hpp"
#include "model.hpp"

namespace hypertuna {

#define HYPERTUNA_DECLARE(arch)        \
    extern const Kernel kernel_##arch; \
    extern const YieldKernel kernel_##arch##_yielding;
HYPERTUNA_DECLARE(scalar)
HYPERTUNA_DECLARE(x86_64_v2)
HYPERTUNA_DECLARE(x86_64_v3)
HYPERTUNA_DECLARE(x86_64_v4)

/// Kernels of this build that this processor can run, the fastest last.
static std::vector<const Kernel*> available_kernels() {
    std::vector<const Kernel*> kernels;
#ifdef HYPERTUNA_HAVE_SCALAR
    kernels.push_back(&kernel_scalar);
#endif
#ifdef HYPERTUNA_HAVE_X86_64_V2
    if (__builtin_cpu_supports("x86-64-v2")) kernels.push_back(&kernel_x86_64_v2);
#endif
#ifdef HYPERTUNA_HAVE_X86_64_V3
    if (__builtin_cpu_supports("x86-64-v3")) kernels.push_back(&kernel_x86_64_v3);
#endif
#ifdef HYPERTUNA_HAVE_X86_64_V4
    if (__builtin_cpu_supports("x86-64-v4")) kernels.push_back(&kernel_x86_64_v4);
#endif
    return kernels;
}

static const Kernel* find_kernel(const std::string& name) {
    for (const Kernel* kernel : available_kernels())
        if (name == kernel->name) return kernel;
    return nullptr;
}

const Kernel& kernel() {
    static const std::string wanted = [] {
        const char* name = std::getenv("HYPERTUNA_ISA");
        return std::string(name ? name : "");
    }();
    static const Kernel* const chosen = wanted.empty() ? available_kernels().back() : find_kernel(wanted);
    if (chosen) return *chosen;
    std::string message = "HYPERTUNA_ISA must name an instruction set that this build and processor have, but is '" +
                          wanted + "': use one of";
    for (const Kernel* k : available_kernels()) message += std::string(" ") + k->name;
    throw nb::value_error(message.c_str());
}

/// The kernel in use for joints that yield.
static const YieldKernel& yield_kernel() {
#ifdef HYPERTUNA_HAVE_X86_64_V2
    if (&kernel() == &kernel_x86_64_v2) return kernel_x86_64_v2_yielding;
#endif
#ifdef HYPERTUNA_HAVE_X86_64_V3
    if (&kernel() == &kernel_x86_64_v3) return kernel_x86_64_v3_yielding;
#endif
#ifdef HYPERTUNA_HAVE_X86_64_V4
    if (&kernel() == &kernel_x86_64_v4) return kernel_x86_64_v4_yielding;
#endif
#ifdef HYPERTUNA_HAVE_SCALAR
    return kernel_scalar_yielding;
#endif
    throw nb::value_error("HYPERTUNA_ISA: has no kernel for joints that yield");
}

/// Any kernel, for tables that are the same in all.
static const Kernel& any_kernel() { return *available_kernels().front(); }

/// All names of a list.
static std::vector<std::string> names(const char* (*name)(int)) {
    std::vector<std::string> all;
    for (int k = 0; name(k); ++k) all.push_back(name(k));
    return all;
}

/// Name, unit, label, meaning, where it is shown, what is better, and whether it has derivatives.
using AboutRow = std::tuple<std::string, std::string, std::string, std::string, int, int, bool>;

static std::vector<AboutRow> quantities_of_a_beat() {
    std::vector<AboutRow> rows;
    for (const auto& [about, of] : quantities<double>)
        rows.emplace_back(about.name, about.unit, about.label, about.meaning, int(about.shown), int(about.better),
                          about.differentiable);
    return rows;
}

using Frequency = Input<1>;
using PerGroup = Input<2>;

inline constexpr std::size_t max_gaits = 1 << 24;  // largest number in one call, so that results can be counted by int

static GaitBatch batch(const Model& model, const Frequency& frequency, const PerGroup& amplitude, const PerGroup& phase,
                       const PerGroup& bias) {
    const std::pair<const char*, const PerGroup*> arrays[] = {
        {"amplitude", &amplitude}, {"phase", &phase}, {"bias", &bias}};
    if (frequency.shape(0) > max_gaits) throw nb::value_error("frequency: too many gaits for one call");
    for (const auto& [name, array] : arrays) {
        check_extent(name, array->shape(0), frequency.shape(0));
        check_extent(name, array->shape(1), model.groups);
    }
    return {frequency.data(), amplitude.data(), phase.data(), bias.data()};
}

static void check_steps(int steps) {
    if (steps < 8 || steps % 4) throw nb::value_error("steps: must be a multiple of 4, 8 at least");
}

/// Call work(begin, end) on blocks of [0, count) from several threads. A block is a whole number of lanes, so that
/// results do not depend on which thread does which block.
template <class Work>
static void in_parallel(int count, int block, int threads, const Work& work) {
    std::atomic<int> next{0};
    std::exception_ptr failure;
    std::once_flag first_failure;
    const auto worker = [&] {
        try {
            for (int begin; (begin = next.fetch_add(block)) < count;) work(begin, std::min(begin + block, count));
        } catch (...) {  // no exception may leave a thread: the first one is kept, and the others stop
            std::call_once(first_failure, [&] { failure = std::current_exception(); });
            next = count;
        }
    };
    std::vector<std::thread> others;
    try {
        for (int k = 1; k < std::min(threads, (count + block - 1) / block); ++k) others.emplace_back(worker);
    } catch (const std::system_error&) {
        // The system gives no more threads: the existing ones do the work.
    }
    worker();
    for (std::thread& other : others) other.join();
    if (failure) std::rethrow_exception(failure);
}

static Output settle_batch(const Model& model, const Frequency& frequency, const PerGroup& amplitude,
                           const PerGroup& phase, const PerGroup& bias, int steps, int wait, int max_beats,
                           int from_rest, int approach, double mass, int threads) {
    const GaitBatch gaits = batch(model, frequency, amplitude, phase, bias);
    check_steps(steps);
    const int count = static_cast<int>(frequency.shape(0));
    const Kernel& use = kernel();
    Output rows = zeros({frequency.shape(0), names(use.settle_column).size()});
    const SettleOptions options{steps, wait, max_beats, from_rest, approach, mass};
    const nb::gil_scoped_release unlocked;
    in_parallel(count, 16 * use.lanes, threads,
                [&](int begin, int end) { use.settle(model, gaits, options, begin, end, rows.data()); });
    return rows;
}

static Directions checked_directions(const Model& model, const Input<2>& along, bool of_gait) {
    check_extent("directions", along.shape(0), of_gait ? beat_rows(model) : parameter_count(model));
    return sort_directions(model, along.data(), int(along.shape(1)), of_gait);
}

static Output gradient(const Model& model, const Frequency& frequency, const PerGroup& amplitude, const PerGroup& phase,
                       const PerGroup& bias, const Input<2>& momentum, const Input<2>& along, int steps, double mass,
                       int threads) {
    const GaitBatch gaits = batch(model, frequency, amplitude, phase, bias);
    check_steps(steps);
    check_extent("momentum", momentum.shape(0), frequency.shape(0));
    check_extent("momentum", momentum.shape(1), 3);
    const Directions directions = checked_directions(model, along, true);
    const Kernel& use = kernel();
    Output rows = zeros({frequency.shape(0), std::size_t(derivative_count), along.shape(1)});
    const nb::gil_scoped_release unlocked;
    in_parallel(static_cast<int>(frequency.shape(0)), 16, threads, [&](int begin, int end) {
        settled_gradient(use, model, gaits, directions, begin, end, momentum.data(), steps, mass, rows.data());
    });
    return rows;
}

static NamedArrays track(const Model& model, const Input<3>& joints, const Input<2>& along, double step,
                         const std::optional<Input<1>>& twist, bool rates) {
    if (joints.shape(0) % 2 != 1) throw nb::value_error("joints: needs two instants a step and one more");
    check_extent("joints", joints.shape(1), model.links);
    check_extent("joints", joints.shape(2), 3);
    if (twist) check_extent("twist", twist->shape(0), 3);
    Directions directions = checked_directions(model, along, false);
    if (twist) directions.still.insert(directions.still.begin(), {-3, -2, -1});
    const std::size_t steps = joints.shape(0) / 2;
    Output pose = zeros({steps + 1, 3}), rate = zeros({steps + 1, 3}),
           gradient_out = zeros({steps + 1, 3, (twist ? 3 : 0) + along.shape(1)}),
           rate_gradient = zeros({rates ? steps + 1 : 0, 3, (twist ? 3 : 0) + along.shape(1)});
    const Kernel& use = kernel();
    {
        const nb::gil_scoped_release unlocked;
        use.track(model, {joints.data(), steps, step, twist ? twist->data() : nullptr}, directions,
                  {pose.data(), rate.data(), gradient_out.data(), rates ? rate_gradient.data() : nullptr});
    }
    NamedArrays out;
    out["pose"] = pose;
    out["rate"] = rate;
    out["gradient"] = gradient_out;
    out["rate_gradient"] = rate_gradient;
    return out;
}

static Output held_force(const Model& model, const Frequency& frequency, const PerGroup& amplitude,
                         const PerGroup& phase, const PerGroup& bias, const Input<1>& speed, const Input<2>& along,
                         int steps, int threads) {
    const GaitBatch gaits = batch(model, frequency, amplitude, phase, bias);
    check_steps(steps);
    check_extent("speed", speed.shape(0), frequency.shape(0));
    const Directions directions = checked_directions(model, along, false);
    const Kernel& use = kernel();
    Output rows = zeros({frequency.shape(0), 1 + along.shape(1)});
    const nb::gil_scoped_release unlocked;
    in_parallel(static_cast<int>(frequency.shape(0)), 4, threads, [&](int begin, int end) {
        use.held(model, gaits, directions, begin, end, speed.data(), steps, rows.data());
    });
    return rows;
}

// --- joints that yield

using Hinges = std::vector<int>;

static void check_hinges(const Model& model, const Hinges& hinges) {
    if (hinges.empty() || hinges.size() > max_hinges) throw nb::value_error("hinges: must be 1 to 3");
    for (std::size_t d = 0; d < hinges.size(); ++d)
        if (hinges[d] <= (d ? hinges[d - 1] : 0) || hinges[d] >= model.links)
            throw nb::value_error("hinges: must be links behind the head, head to tail");
    if (model.links - hinges[0] > max_hung) throw nb::value_error("hinges: have too many links behind them");
}

static YieldBatch yielding(const Model& model, const Hinges& hinges, const Input<2>& spring, const GaitBatch& gaits,
                           std::size_t count) {
    check_hinges(model, hinges);
    check_extent("spring", spring.shape(0), count);
    check_extent("spring", spring.shape(1), hinges.size() * spring_numbers);
    return {gaits, hinges.data(), int(hinges.size()), spring.data()};
}

static Output yield_settle(const Model& model, const Hinges& hinges, const Input<2>& spring, const Frequency& frequency,
                           const PerGroup& amplitude, const PerGroup& phase, const PerGroup& bias, int steps, int wait,
                           int max_beats, int from_rest, int approach, double mass, int threads) {
    const YieldBatch gaits =
        yielding(model, hinges, spring, batch(model, frequency, amplitude, phase, bias), frequency.shape(0));
    check_steps(steps);
    const YieldKernel& use = yield_kernel();
    Output rows = zeros({frequency.shape(0), std::size_t(use.row_width(gaits.hinges))});
    const SettleOptions options{steps, wait, max_beats, from_rest, approach, mass};
    const nb::gil_scoped_release unlocked;
    in_parallel(int(frequency.shape(0)), kernel().lanes, threads,
                [&](int begin, int end) { use.settle(model, gaits, options, begin, end, rows.data()); });
    return rows;
}

static Output yield_gradient(const Model& model, const Hinges& hinges, const Input<2>& spring,
                             const Frequency& frequency, const PerGroup& amplitude, const PerGroup& phase,
                             const PerGroup& bias, const Input<2>& state, const Input<2>& along, int steps, double mass,
                             int threads) {
    const YieldBatch gaits =
        yielding(model, hinges, spring, batch(model, frequency, amplitude, phase, bias), frequency.shape(0));
    const int n = int(along.shape(1)), width = yield_state(gaits.hinges);
    check_steps(steps);
    check_extent("state", state.shape(0), frequency.shape(0));
    check_extent("state", state.shape(1), width);
    check_extent("directions", along.shape(0), parameter_count(model) + spring.shape(1));
    const Directions directions{along.data(), n, {}, {}};
    const YieldKernel& use = yield_kernel();
    Output out = zeros({frequency.shape(0), std::size_t(derivative_count), along.shape(1)});
    const nb::gil_scoped_release unlocked;
    const std::size_t size = std::size_t(derivative_count + width) * (width + n);
    std::vector<double> rates(frequency.shape(0) * size);
    in_parallel(int(frequency.shape(0)), 1, threads, [&](int begin, int end) {
        use.gradient(model, gaits, directions, begin, end, state.data(), steps, mass, rates.data());
        for (int gait = begin; gait < end; ++gait)
            with_hinges(gaits.hinges, [&](auto D) {
                with_moving_start<YieldingState<double, D.value>>(
                    rates.data() + gait * size, n, out.data() + std::size_t(gait) * derivative_count * n);
            });
    });
    return out;
}

static Output yield_bends(const Model& model, const Hinges& hinges, const Input<2>& spring, const Frequency& frequency,
                          const PerGroup& amplitude, const PerGroup& phase, const PerGroup& bias, const Input<1>& state,
                          int steps, int count) {
    const YieldBatch gaits = yielding(model, hinges, spring, batch(model, frequency, amplitude, phase, bias), 1);
    check_extent("state", state.shape(0), yield_state(gaits.hinges));
    Output out = zeros({std::size_t(std::max(count, 0)), hinges.size(), 3});
    yield_kernel().bends(model, gaits, state.data(), steps, count, out.data());
    return out;
}

static void bind_yielding(nb::module_& m) {
    m.def(
        "yield_settle", &yield_settle, nb::arg("model"), nb::arg("hinges"), nb::arg("spring"), nb::arg("frequency"),
        nb::arg("amplitude"), nb::arg("phase"), nb::arg("bias"), nb::kw_only(), nb::arg("steps"), nb::arg("wait"),
        nb::arg("max_beats"), nb::arg("from_rest"), nb::arg("approach"), nb::arg("mass"), nb::arg("threads"),
        "As `settle` for a body whose joints at the fronts of the links `hinges` yield, head to tail, `spring` (gaits, "
        "hinges x spring_columns) being the numbers of each: the named columns, state, monodromy, then of each hinge "
        "mean, sine and cosine of its swing from rest, peak of its angle, and its damper's power.");
    m.def("yield_gradient", &yield_gradient, nb::arg("model"), nb::arg("hinges"), nb::arg("spring"),
          nb::arg("frequency"), nb::arg("amplitude"), nb::arg("phase"), nb::arg("bias"), nb::arg("state"),
          nb::arg("directions"), nb::kw_only(), nb::arg("steps"), nb::arg("mass"), nb::arg("threads"),
          "As `gradient`, the springs' numbers being the last parameters.");
    m.def("yield_bends", &yield_bends, nb::arg("model"), nb::arg("hinges"), nb::arg("spring"), nb::arg("frequency"),
          nb::arg("amplitude"), nb::arg("phase"), nb::arg("bias"), nb::arg("state"), nb::kw_only(), nb::arg("steps"),
          nb::arg("count"), "Angle, rate and acceleration (count, hinges, 3) of hinges at every step from a state on.");
    m.def(
        "spring_columns", [] { return std::vector<std::string>(std::begin(spring_columns), std::end(spring_columns)); },
        "Numbers of a hinge's spring, in the order of a row.");
    m.def(
        "hinge_inertia",
        [](const Model& model, const Hinges& hinges) {
            check_hinges(model, hinges);
            const std::vector<double> inertia = hinge_inertia(yield_kernel(), model, hinges.data(), int(hinges.size()));
            Output out = zeros({hinges.size(), hinges.size()});
            std::copy(inertia.begin(), inertia.end(), out.data());
            return out;
        },
        nb::arg("model"), nb::arg("hinges"),
        "Inertia that the free, straight body opposes to the joints at the fronts of the links `hinges` [kg m^2].");
    m.def(
        "spring_steps",
        [](const Model& model, const Hinges& hinges, const Input<2>& spring, const Frequency& frequency, int steps) {
            check_hinges(model, hinges);
            check_extent("spring", spring.shape(0), hinges.size());
            check_extent("spring", spring.shape(1), spring_numbers);
            std::vector<Spring<double>> springs;
            for (std::size_t d = 0; d < hinges.size(); ++d)
                springs.push_back(read_row<Spring<double>, double>(spring_columns, &spring(d, 0)));
            const SpringRates rates = spring_rates(yield_kernel(), model, hinges, springs);
            std::vector<int> out;
            for (std::size_t k = 0; k < frequency.shape(0); ++k)
                out.push_back(spring_steps(rates, frequency(k), steps));
            return out;
        },
        nb::arg("model"), nb::arg("hinges"), nb::arg("spring"), nb::arg("frequency"), nb::arg("steps"),
        "Steps of a beat at each frequency [Hz] that follow the springs (hinges, spring_columns): `steps`, doubled as "
        "often as it takes; 0 where not even `MOST_SPRING_STEPS` do.");
    m.attr("MOST_SPRING_STEPS") = most_spring_steps;
    m.attr("BENT") = bent;
    m.attr("COMPRESSED") = compressed;
    m.attr("MAX_HINGES") = max_hinges;
    m.attr("YIELD_LINKS") = max_hung;
}

void bind_settle(nb::module_& m) {
    bind_yielding(m);
    m.def("isa", [] { return std::string(kernel().name); }, "Name of the instruction set in use.");
    m.def(
        "isas",
        [] {
            std::vector<std::string> all;
            for (const Kernel* k : available_kernels()) all.push_back(k->name);
            return all;
        },
        "Names of the instruction sets that this build and this processor have.");
    m.def("lanes", [] { return kernel().lanes; }, "Gaits that one instruction serves.");
    m.def("settle", &settle_batch, nb::arg("model"), nb::arg("frequency"), nb::arg("amplitude"), nb::arg("phase"),
          nb::arg("bias"), nb::kw_only(), nb::arg("steps"), nb::arg("wait"), nb::arg("max_beats"), nb::arg("from_rest"),
          nb::arg("approach"), nb::arg("mass"), nb::arg("threads"),
          "Settled beats of many gaits, one row each, columns as named by `settle_columns`: by Newton's method from a "
          "brisk speed, from the motion after `from_rest` beats from rest (>= 0), or by `wait` beats from rest (>= 0). "
          "With `approach` > 0 a start from rest is followed toward each for at most `approach` beats. `mass` [kg] is "
          "the whole body's.");
    m.def(
        "gradient", &gradient, nb::arg("model"), nb::arg("frequency"), nb::arg("amplitude"), nb::arg("phase"),
        nb::arg("bias"), nb::arg("momentum"), nb::arg("directions"), nb::kw_only(), nb::arg("steps"), nb::arg("mass"),
        nb::arg("threads"),
        "Derivatives of settled beats, from their momentum at the start, along `directions` (parameters and links' "
        "shares, directions): (gaits, differentiable quantities, directions); NaN where the start is not determined.");
    m.def("track", &track, nb::arg("model"), nb::arg("joints"), nb::arg("directions"), nb::kw_only(), nb::arg("step"),
          nb::arg("twist") = nb::none(), nb::arg("rates") = false,
          "Swim a joint motion, given at every half step (2 steps + 1, links, 3), from rest in the water or from a "
          "twist (3,) of the head: pose of the nose at every step, its rate, and its derivatives along `directions` "
          "(parameters, directions), after those by the twist if it is given; with `rates` those of the rate, too.");
    m.def("held", &held_force, nb::arg("model"), nb::arg("frequency"), nb::arg("amplitude"), nb::arg("phase"),
          nb::arg("bias"), nb::arg("speed"), nb::arg("directions"), nb::kw_only(), nb::arg("steps"), nb::arg("threads"),
          "Mean force toward the head [N] over a beat of each gait whose head is held on a straight path at `speed` "
          "[m/s], and its derivatives along `directions` (parameters, directions): (gaits, 1 + directions).");
    m.def("settle_columns", [] { return names(any_kernel().settle_column); }, "Names of the columns of `settle`.");
    m.def("quantities", &quantities_of_a_beat,
          "Quantities of a settled beat: name, unit, label, meaning, how far it is shown (0 in data sets, 1 in "
          "records, 2 "
          "in summaries), what is better (0 neither, 1 large, 2 small), and whether it has derivatives.");
    m.attr("SETTLED_DISTANCE") = settle_tolerances.settled;
    m.attr("BEAT_STEPS") = beat_steps;
    m.attr("NEWTON_BEATS") = newton_beats;
    m.attr("APPROACH_BEATS") = approach_beats;
    m.attr("NEUTRAL") = neutral;
    m.attr("NEARLY_STRAIGHT") = nearly_straight;
    m.attr("STATE_SIZE") = int(Momentum<double>::size);
    m.def(
        "verdict",
        [](int status, double beats, double distance, double spectral_radius, double turn) {
            return verdict(BeatStatus(status), beats, distance, spectral_radius, turn);
        },
        nb::arg("status"), nb::arg("beats"), nb::arg("distance"), nb::arg("spectral_radius"), nb::arg("turn"),
        "The verdict on a beat that turns the body by `turn` [rad], in words; `status` is one of `beat_statuses`.");
    m.def(
        "beat_statuses", [] { return std::vector<std::string>(std::begin(beat_statuses), std::end(beat_statuses)); },
        "Names of the statuses of a search for a settled beat.");
}

}  // namespace hypertuna
