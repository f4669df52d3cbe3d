/// The core uses only memory that it is given: no allocation from tabulating a beat to settling it with derivatives.
#include "allocations.hpp"
#include "check.hpp"
#include "fish.hpp"

using namespace hypertuna;

template <class S, class Law>
static void settles_without_heap() {
    static Fish<S, Law, 128> fish(S(2), S(base_t<S>(0.2)));
    const int before = allocations;
    fish.fill();
    const Settled<S> s = settle(fish.body(), fish.brisk(), 60), w = wait(fish.body(), fish.rest(), 10);
    const Approach<S> way = approach(fish.body(), s.start, 500);
    CHECK(allocations == before);
    CHECK(all(way.distance < S(base_t<S>(approach_tolerances.arrived))));
    CHECK(all(s.distance < S(base_t<S>(settle_tolerances.settled))));
    CHECK(all(S(0) < w.residual));
}

int main() {
    delete new volatile int(0);  // the counter counts
    delete new Lanes<double, 4>(1.0);
    CHECK(allocations == 2);

    WaterLaws::each<double>([](auto law) { settles_without_heap<double, typename decltype(law)::type>(); });
    using Four = Lanes<double, 4>;
    WaterLaws::each<Four>([](auto law) { settles_without_heap<Four, typename decltype(law)::type>(); });
    return failures();
}
