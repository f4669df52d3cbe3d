/// List of the water laws, which kernels, bindings, Python and tests go through. A new law is added here, and its
/// header above.
#pragma once

#include <type_traits>

#include "hypertuna/swimming/any_law.hpp"
#include "hypertuna/swimming/elongated.hpp"
#include "hypertuna/swimming/lumped.hpp"
#include "hypertuna/swimming/strip.hpp"

/// A law is added here, and its header above.
#define HYPERTUNA_WATER_LAWS(use) use(Lumped) use(Strip) use(Elongated)

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class, template <class> class... Law>
struct LawList {
    static constexpr int count = sizeof...(Law);
    template <class S>
    using Any = AnyLaw<S, Law...>;

    /// Call work(std::type_identity<Law<S>>) for every law in turn.
    template <class S, class Work>
    static void each(const Work& work) {
        (work(std::type_identity<Law<S>>{}), ...);
    }
};

#define HYPERTUNA_NEXT_LAW(Law) , Law
using WaterLaws = LawList<void HYPERTUNA_WATER_LAWS(HYPERTUNA_NEXT_LAW)>;
#undef HYPERTUNA_NEXT_LAW

/// Call work(std::type_identity<Law<S>>) for the law at this place of the list.
template <class S, class Work>
void with_listed_law(int index, const Work& work) {
    int k = 0;
    WaterLaws::each<S>([&](auto law) {
        if (k++ == index) work(law);
    });
}

/// Call work(std::type_identity<Law<S>>) for the law at this place of the list; with HYPERTUNA_SMALL, for the type that
/// can be any law.
template <class S, class Work>
void with_law([[maybe_unused]] int index, const Work& work) {
#ifdef HYPERTUNA_SMALL
    work(std::type_identity<WaterLaws::Any<S>>{});
#else
    with_listed_law<S>(index, work);
#endif
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
