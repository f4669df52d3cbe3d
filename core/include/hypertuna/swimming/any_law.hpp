/// A water law that is chosen at run time: code for all laws at once, where size counts more than speed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "hypertuna/swimming/stepping.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// One of the laws `Each<S>...`. To its users it sheds and beats; where the law in place does not shed, that force is
/// zero.
template <class S, template <class> class... Each>
struct AnyLaw {
    static constexpr bool sheds = true;
    static constexpr bool beats = true;
    static constexpr int flag_bits = 8;  // the bits above these hold the law's place in the list

    /// Memory per link for the coefficients of any law and for the inertia; the coefficients of all links come before
    /// the inertias.
    struct Coefficients {
        alignas(S) std::byte law[std::max({sizeof(typename Each<S>::Coefficients)...})];
        LinkInertia<S> inertia;
    };
    int place;
    const LinkInertia<S>* inertias;
    std::tuple<Each<S>...> laws;

    static AnyLaw read(int links, Columns<S>& in, const Link<S>* link, const S& density, unsigned flags,
                       Coefficients* out) {
        AnyLaw any{int(flags >> flag_bits), nullptr, {}};
        std::byte* const memory = out->law;
        LinkInertia<S>* const inertias =
            reinterpret_cast<LinkInertia<S>*>(memory + std::size_t(links) * sizeof(out->law));
        visit(any, [&]<class Law>(Law& law) {
            law = Law::read(links, in, link, density, flags & ((1u << flag_bits) - 1),
                            reinterpret_cast<typename Law::Coefficients*>(memory));
            for (int i = 0; i < links; ++i) inertias[i] = law.inertia(i);
        });
        any.inertias = inertias;
        return any;
    }

    HYPERTUNA_INLINE const LinkInertia<S>& inertia(int i) const { return inertias[i]; }
    template <class G, class V>
    HYPERTUNA_INLINE Along<V> drag(int i, const Along<V>& v, const Along<G>& bend) const {
        return visit(*this, [&]<class Law>(const Law& law) {
            if constexpr (Law::beats)
                return law.drag(i, v, bend);
            else
                return law.drag(i, v);
        });
    }
    template <class V>
    HYPERTUNA_INLINE Along<V> shed(const Along<V>& v) const {
        return visit(*this, [&]<class Law>(const Law& law) {
            if constexpr (Law::sheds)
                return law.shed(v);
            else
                return Along<V>{V(S(0)), V(S(0)), V(S(0))};
        });
    }

    /// Call work(law) with the law in place and return its result.
    template <std::size_t k = 0, class Any, class Work>
    static HYPERTUNA_INLINE auto visit(Any& any, const Work& work) {
        if constexpr (k + 1 < sizeof...(Each))
            if (any.place != int(k)) return visit<k + 1>(any, work);
        return work(std::get<k>(any.laws));
    }
};

/// Momentum after one beat, in code compiled for the law in place: most of the time is spent here.
template <class S, template <class> class... Each, class G, class V>
Momentum<V> swim_beat(const Swimmer<S, AnyLaw<S, Each...>, G>& fish, const ShapeTable<S, G>& table, int stride,
                      const S& period, const Momentum<V>& P) {
    return fish.water.visit(fish.water, [&]<class Law>(const Law& law) {
        return swim_beat(Swimmer<S, Law, G>{fish.links, fish.link, law}, table, stride, period, P);
    });
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
