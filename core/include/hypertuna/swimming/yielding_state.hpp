/// State of a body with joints that yield, and the numbers that its motion is made of.
#pragma once

#include <concepts>
#include <type_traits>

#include "hypertuna/swimming/settle.hpp"
#include "hypertuna/swimming/spring.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Momentum of the body, and of each coordinate that yields its angle from rest and its momentum. As a change of the
/// motion: twist of the head, angles, rates.
template <class S, int D>
struct YieldingState {
    static constexpr int size = 3 + 2 * D;
    Planar<S> body;
    S angle[D];     // rad
    S momentum[D];  // N m s

    friend HYPERTUNA_INLINE YieldingState operator+(YieldingState a, const YieldingState& b) {
        a.body = a.body + b.body;
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) a.angle[d] += b.angle[d], a.momentum[d] += b.momentum[d];
        return a;
    }
    template <class A>
    friend HYPERTUNA_INLINE YieldingState operator*(const A& a, YieldingState b) {
        b.body = a * b.body;
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) b.angle[d] = a * b.angle[d], b.momentum[d] = a * b.momentum[d];
        return b;
    }
    friend HYPERTUNA_INLINE YieldingState operator-(const YieldingState& a, const YieldingState& b) {
        return a + S(base_t<S>(-1)) * b;
    }
};

template <class S, int D>
HYPERTUNA_INLINE S& component(YieldingState<S, D>& y, int k) {
    return k < 3 ? component(y.body, k) : k < 3 + D ? y.angle[k - 3] : y.momentum[k - 3 - D];
}
template <class V, class S, int D>
HYPERTUNA_INLINE YieldingState<V, D> widen(const YieldingState<S, D>& y) {
    YieldingState<V, D> out{widen<V>(y.body), {}, {}};
    for (int d = 0; d < D; ++d) out.angle[d] = V(y.angle[d]), out.momentum[d] = V(y.momentum[d]);
    return out;
}
template <class S, int D, class M>
HYPERTUNA_INLINE YieldingState<S, D> select(const M& mask, const YieldingState<S, D>& yes, YieldingState<S, D> no) {
    no.body = select(mask, yes.body, no.body);
    for (int d = 0; d < D; ++d) {
        no.angle[d] = select(mask, yes.angle[d], no.angle[d]);
        no.momentum[d] = select(mask, yes.momentum[d], no.momentum[d]);
    }
    return no;
}

/// How the coordinates swing over a beat, from rest: mean + sine sin(2 pi f t) + cosine cos(2 pi f t) and harmonics;
/// the largest angles of their hinges, and what their dampers and stops take.
template <class S, int D>
struct Swinging {
    S mean[D], sine[D], cosine[D], peak[D];  // rad
    S damping[D];                            // W
};

/// The scalar of the shape: it has derivatives by the coordinates alone where the state has derivatives.
template <class S, class V, int D>
using Shaped = std::conditional_t<std::same_as<S, V>, S, Dual<S, D>>;

/// A number of the shape with the derivatives of the state whose angles it depends on.
template <class V, int D, class G>
HYPERTUNA_INLINE V lifted(const G& x, const V (&angle)[D]) {
    if constexpr (std::same_as<G, V>)
        return x;
    else {
        V y(x.v);
        constexpr int count = int(sizeof(y.d) / sizeof(y.d[0]));
        for (int d = 0; d < D; ++d) {
            HYPERTUNA_UNROLL
            for (int k = 0; k < count; ++k) y.d[k] += x.d[d] * angle[d].d[k];
        }
        return y;
    }
}
template <class V, int D, class G>
HYPERTUNA_INLINE Planar<V> lifted(const Planar<G>& x, const V (&angle)[D]) {
    return {lifted(x.x, angle), lifted(x.y, angle), lifted(x.z, angle)};
}

/// A link that hangs behind a joint that yields. Its shape's velocity is that by the prescribed joints alone.
template <class V, int D>
struct Hung {
    LinkShape<V> at;
    V x, y, v_x, v_y;  // of the joint at its front: position, and velocity by the prescribed joints
    Twist<V> screw[D];
};

/// How a body moves whose joints yield: twist of the head, rates, and the inertia that the free body opposes to a
/// joint, B - C^T M^-1 C, lower triangle.
template <class V, int D>
struct Moving {
    Twist<V> xi;
    V rate[D];
    V reduced[D][D];
};

/// Solve A x = b in place, A symmetric and positive definite, of which the lower triangle is read.
template <class S, int D>
HYPERTUNA_INLINE void solve_positive(S (&a)[D][D], S (&b)[D]) {
    for (int j = 0; j < D; ++j)
        for (int i = j + 1; i < D; ++i) {
            const S l = a[i][j] / a[j][j];
            for (int k = j + 1; k <= i; ++k) a[i][k] -= l * a[k][j];
            b[i] -= l * b[j];
        }
    for (int j = D - 1; j >= 0; --j) {
        for (int i = j + 1; i < D; ++i) b[j] -= a[i][j] * b[i];
        b[j] = b[j] / a[j][j];
    }
}

template <class A, class B>
HYPERTUNA_INLINE product_t<A, B> dotted(const Planar<A>& a, const Planar<B>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
