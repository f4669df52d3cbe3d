/// Pectoral fins: flat plates beside the hull that servos pitch, at any angle of attack.
///
/// Fin 0 is on the port side (y < 0), fin 1 to starboard. A positive angle lifts the leading edge: swimming forward,
/// the fin lifts. The hull is a mirror: a fin is half of a plate of aspect ratio AR = 2 span/chord. Sharp edges have no
/// suction, so the force of the pressure is normal to the plate. At an angle of attack a, with s = |sin a|, per
/// 1/2 rho S V^2 and toward the side that the flow leaves,
///     vortices along the side edges  C_N = s (K_p |cos a| + K_v s), K_p = 2 pi AR / (2 + sqrt(4 + AR^2)) (Helmbold)
///     open wake                      C_N = 1.98 s (1 / (0.56 + 0.44 s) - 0.41 (1 - e^(-17/AR))) (Hoerner, Lindenburg)
/// and the share s^16 / (s^16 + sin^16 a_s) of open wake blends them: half at the angle of stall. The side edges'
/// suction turns normal to the plate (Polhamus); K_v = pi / (1 + AR/2) is that of a slender plate for AR = 0, and of
/// the vortex lattice in validation/flow within 11 % from AR = 0.5 to 4. C_D0 acts along the flow. Flow along the span
/// does nothing.
#pragma once

#include <cmath>

#include "hypertuna/math/spatial.hpp"
#include "hypertuna/math/trig.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class S>
struct Fin {
    Vector<S> place;  // m, center of area of the starboard fin from the nose, in body axes
    S chord;          // m
    S area;           // m^2 of one fin
    S slope;          // K_p
    S edges;          // K_v
    S ends;           // 0.41 (1 - e^(-17/AR)): how much flow around the ends reduces the wake's suction
    S stall;          // sin^16 of the angle of stall
    S drag;           // C_D0
    S bandwidth;      // 1/s: rate of the servo's first-order lag
    S speed;          // rad/s: largest rate of the fin
};

/// x^16.
template <class S>
HYPERTUNA_INLINE S power_16(const S& x) {
    const S x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
    return x8 * x8;
}

/// Make a fin from its span, chord and coefficients; `stall` is the angle of stall [rad], `bandwidth` is in Hz.
template <class S>
Fin<S> make_fin(const Vector<S>& place, const S& span, const S& chord, const S& stall, const S& drag,
                const S& bandwidth, const S& speed) {
    using T = base_t<S>;
    using std::exp;
    const S aspect = S(2) * span / chord;
    return {place,
            chord,
            span * chord,
            S(T(2 * pi)) * aspect / (S(2) + sqrt(S(4) + aspect * aspect)),
            S(T(2 * pi)) / (S(2) + aspect),
            S(T(0.41)) * (S(1) - exp(S(-17) / aspect)),
            power_16(sincos(stall).sin),
            drag,
            S(T(2 * pi)) * bandwidth,
            speed};
}

/// Order of a fin's numbers in a row from Python.
inline constexpr const char* fin_columns[] = {"x",     "y",         "z",         "span", "chord",
                                              "stall", "drag_zero", "bandwidth", "speed"};

template <class S, class T>
Fin<S> read_fin(const T* row) {
    const auto at = [row](int k) { return S(base_t<S>(row[k])); };
    return make_fin(Vector<S>{at(0), at(1), at(2)}, at(3), at(4), at(5), at(6), at(7), at(8));
}

/// Coefficient of the force normal to the plate at an angle of attack, from its sine and cosine.
template <class S>
HYPERTUNA_INLINE S normal_coefficient(const Fin<S>& fin, const S& sine, const S& cosine) {
    using T = base_t<S>;
    const S s = abs(sine), steep = power_16(s), open = steep / (steep + fin.stall);
    const S vortices = fin.slope * abs(cosine) + fin.edges * s;
    const S wake = S(T(1.98)) * (S(1) / (S(T(0.56)) + S(T(0.44)) * s) - fin.ends);
    return sine * (vortices + open * (wake - vortices));
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
    const S normal = normal_coefficient(fin, sine, cosine);
    const S lift = normal * cosine, drag = fin.drag + normal * sine;
    const S pressure = S(base_t<S>(0.5)) * density * fin.area * speed;
    return {pressure * (lift * u_z - drag * u_x), S(0) - pressure * (lift * u_x + drag * u_z)};
}

/// Rate at which a fin follows its servo's target, rad/s.
template <class S>
HYPERTUNA_INLINE S fin_rate(const Fin<S>& fin, const S& angle, const S& target) {
    return max(S(0) - fin.speed, min(fin.speed, fin.bandwidth * (target - angle)));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
