/// Pectoral fins: flat plates that servos pitch, with lift and drag from attached flow through stall.
///
/// Fin 0 is on the port side (y < 0), fin 1 to starboard. A positive angle lifts the leading edge: swimming forward,
/// the fin lifts. At an angle of attack a and speed V, per 1/2 rho S V^2,
///     attached  C_L = k sin a cos a          C_D = C_D0 + C_L^2 / (pi AR)
///     stalled   C_L = 2 sin a |sin a| cos a  C_D = C_D0 + 2 |sin a|^3
/// and the share s = sin^8 a / (sin^8 a + sin^8 a_s) of stalled flow blends them: half at the angle of stall. The slope
/// is Helmbold's, k = 2 pi AR / (2 + sqrt(4 + AR^2)). Flow along the span does nothing.
#pragma once

#include "hypertuna/math/spatial.hpp"
#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Fin {
    Vector<S> place;  // m, center of area of the starboard fin from the nose, in body axes
    S chord;          // m
    S area;           // m^2 of one fin
    S slope;          // k
    S induced;        // 1 / (pi AR)
    S stall;          // sin^8 of the angle of stall
    S drag;           // C_D0
    S bandwidth;      // 1/s: rate at which the servo's first-order lag closes in
    S speed;          // rad/s: fastest that it turns
};

/// A fin from what describes it; `stall` is the angle.
template <class S>
Fin<S> make_fin(const Vector<S>& place, const S& span, const S& chord, const S& stall, const S& drag,
                const S& bandwidth, const S& speed) {
    const S aspect = span / chord, sine = sincos(stall).sin, fourth = sine * sine * sine * sine;
    const S slope = S(base_t<S>(2 * pi)) * aspect / (S(2) + sqrt(S(4) + aspect * aspect));
    return {place,
            chord,
            span * chord,
            slope,
            S(1) / (S(base_t<S>(pi)) * aspect),
            fourth * fourth,
            drag,
            S(base_t<S>(2 * pi)) * bandwidth,
            speed};
}

/// A fin as a row of numbers, in this order: how it comes from Python.
inline constexpr const char* fin_columns[] = {"x",     "y",         "z",         "span", "chord",
                                              "stall", "drag_zero", "bandwidth", "speed"};
inline constexpr int fin_column_count = sizeof(fin_columns) / sizeof(fin_columns[0]);

template <class S, class T>
Fin<S> read_fin(const T* row) {
    const auto at = [row](int k) { return S(base_t<S>(row[k])); };
    return make_fin(Vector<S>{at(0), at(1), at(2)}, at(3), at(4), at(5), at(6), at(7), at(8));
}

/// Force on a fin along x and z, N, from the velocity of its center through the water.
template <class S>
struct FinForce {
    S x, z;
};
template <class S>
HYPERTUNA_INLINE FinForce<S> fin_force(const Fin<S>& fin, const S& density, const S& u_x, const S& u_z,
                                       const S& angle) {
    const SinCos<S> turn = sincos(angle);
    const S speed = sqrt(u_x * u_x + u_z * u_z + S(base_t<S>(1e-24))), scale = S(1) / speed;
    const S sine = S(0) - scale * (u_x * turn.sin + u_z * turn.cos);
    const S cosine = scale * (u_z * turn.sin - u_x * turn.cos);
    const S sine2 = sine * sine, sine4 = sine2 * sine2, sine8 = sine4 * sine4;
    const S stalled = sine8 / (sine8 + fin.stall), attached = S(1) - stalled;
    const S steep = S(2) * sine * abs(sine), level = fin.slope * sine * cosine;
    const S lift = attached * level + stalled * steep * cosine;
    const S drag = fin.drag + attached * fin.induced * level * level + stalled * steep * sine;
    const S pressure = S(base_t<S>(0.5)) * density * fin.area * speed;
    return {pressure * (lift * u_z - drag * u_x), S(0) - pressure * (lift * u_x + drag * u_z)};
}

/// Rate at which a fin follows its servo's target, rad/s.
template <class S>
HYPERTUNA_INLINE S fin_rate(const Fin<S>& fin, const S& angle, const S& target) {
    return max(S(0) - fin.speed, min(fin.speed, fin.bandwidth * (target - angle)));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
