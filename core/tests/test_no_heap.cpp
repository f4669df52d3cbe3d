/// The core lives on the memory it is given: not one allocation from tabulating a beat to settling it and its
/// derivatives.
#include <cstdlib>
#include <new>

#include "check.hpp"
#include "fish.hpp"

using namespace hypertuna;

static int allocations = 0;

// Not inlined: else the compiler sees new paired with free and warns.
HYPERTUNA_NOINLINE void* operator new(std::size_t size) {
    ++allocations;
    return std::malloc(size);
}
HYPERTUNA_NOINLINE void* operator new(std::size_t size, std::align_val_t alignment) {
    ++allocations;
    return std::aligned_alloc(std::size_t(alignment), size);
}
HYPERTUNA_NOINLINE void operator delete(void* p) noexcept { std::free(p); }
HYPERTUNA_NOINLINE void operator delete(void* p, std::size_t) noexcept { std::free(p); }
HYPERTUNA_NOINLINE void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

template <class S, class Law>
static void settles_without_heap() {
    static Fish<S, Law, 128> fish(S(2), S(base_t<S>(0.2)));
    const int before = allocations;
    fish.fill();
    const Settled<S> s =
        settle(fish.swimmer, fish.joints, fish.table, fish.length, fish.period, fish.brisk(), 60, fish.scratch);
    const Settled<S> w =
        wait(fish.swimmer, fish.joints, fish.table, fish.length, fish.period, fish.rest(), 10, fish.scratch);
    CHECK(allocations == before);
    CHECK(all(s.distance < S(base_t<S>(settle_tolerances.settled))));
    CHECK(all(S(0) < w.residual));
}

int main() {
    delete new volatile int(0);  // the counter counts
    delete new Lanes<double, 4>(1.0);
    CHECK(allocations == 2);

    settles_without_heap<double, Lumped<double>>();
    settles_without_heap<double, Strip<double>>();
    settles_without_heap<Lanes<double, 4>, Lumped<Lanes<double, 4>>>();
    settles_without_heap<Lanes<double, 4>, Strip<Lanes<double, 4>>>();
    return failures();
}
