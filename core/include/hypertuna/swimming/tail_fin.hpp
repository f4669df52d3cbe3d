/// Force of the water on a tail fin, in addition to the change of the momentum that the fin carries: Kirchhoff's
/// equations know no edges. Derivation: docs/model.md, "Strip: the force on a fin".
#pragma once

#include "hypertuna/swimming/water.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Force of the wake at the trailing edge, and the terms that leave suction as the only force along a plate. Where the
/// fin moves backward, its two edges change roles.
template <class S>
struct TailFin {
    S middle{};               // middle of the fin from the link's center of mass, m
    S sense{}, act{};         // m behind the middle: where the speed determines the lift, and where the lift acts
    S lift{}, fading{};       // force per speed along and speed across, kg/m; the second times |v_t| / |v|
    S carried{}, turning{};   // added mass that turns with the fin, and that whose moment fades with the lift, kg
    S suction{}, attached{};  // suction at the leading edge, kg/m; attached added mass, which fades with the lift
    S leading{};              // m ahead of the middle: where the speed determines the suction

    template <class V>
    HYPERTUNA_INLINE Along<V> force(const Along<V>& v) const {
        const V ahead = abs(v.t), mid = v.n + middle * v.w;
        const S rear = select(v.t < V(S(0)), S(1), S(-1));
        const V across = mid + rear * sense * v.w, front = mid - leading * v.w;
        const V cos_incidence = ahead / magnitude<S>(v.t, across);
        const V f_n = -(ahead * across * (lift + fading * cos_incidence));
        const V f_t = -(carried * v.w * mid + S(base_t<S>(0.5)) * (suction + attached * cos_incidence) * front * front);
        return {f_t, f_n, (middle + rear * act) * f_n + (V(S(1)) - cos_incidence) * turning * v.t * mid};
    }
};

/// A fin that is the whole last link, with one added mass per length.
template <class S>
struct EdgeStrip {
    S added, shed;  // kg/m, added mass: of the link, and that shed by the trailing edge at small incidence
    S ahead;        // added mass of the link ahead over the edge's: there the fin has no leading edge
    S suction;      // fraction that acts at the leading edge

    TailFin<S> fin(const Link<S>& link) const {
        const S half = S(base_t<S>(0.5)), arm = half * link.length;
        const S whole = min(added, S(2) * shed), constant_lift = half * whole;  // more would let the wake give energy
        return {.middle = arm - link.com,
                .sense = arm,
                .act = arm,
                .lift = constant_lift,
                .fading = shed - constant_lift,
                .carried = whole * link.length,
                .suction = whole * (ahead + suction * (S(1) - ahead)),
                .leading = arm};
    }
};

/// A fin as a plate of its own at the end of the last link. Lift follows the speed at three quarters of the chord, as
/// in the theory of thin plates, and acts so that steady lift, with Munk's moment, has its center at a quarter of it.
/// Both fade together as the plate stalls: the wake's power fades with them, and is never negative.
template <class S>
struct EdgePlate {
    S mass;         // kg, added mass across
    S chord, lift;  // m; kg/m, lift per speed along and across
    S slope;        // lift slope in units of a slender wing's
    S suction;      // fraction that acts at the leading edge

    S middle(const Link<S>& link) const { return link.length - S(base_t<S>(0.5)) * chord - link.com; }

    TailFin<S> fin(const Link<S>& link) const {
        const S quarter(base_t<S>(0.25)), tiny(base_t<S>(1e-12));
        const S carried = min(mass, chord * lift);  // added mass of a slender plate with this lift
        const S share = carried / max(chord * lift, tiny);
        const S attached_share =
            min(suction * (S(1) - S(base_t<S>(0.5)) * slope), S(4) * share);  // more would let the wake give energy
        return {.middle = middle(link),
                .sense = quarter * chord,
                .act = abs(share - quarter) * chord,
                .fading = lift,
                .carried = carried,
                .turning = carried,
                .attached = S(2) * attached_share * lift};
    }

    /// Inertia of a link with an added mass `all` [kg] across: the plate has its own part, what lies ahead of the plate
    /// the rest; `rotary` scales the added moments of inertia.
    LinkInertia<S> inertia(const Link<S>& link, const S& tangential, const S& all, const S& rotary) const {
        const S mass_ahead = all - mass, ahead = link.length - chord, front = S(base_t<S>(0.5)) * ahead - link.com;
        const S rear = middle(link), twelfth(base_t<S>(1.0 / 12)), plate(base_t<S>(1.0 / 32));
        return {link.mass + tangential, link.mass + all, mass_ahead * front + mass * rear,
                link.inertia + mass_ahead * (front * front + rotary * twelfth * ahead * ahead) +
                    mass * (rear * rear + rotary * plate * chord * chord)};
    }
};

/// Choose between two fins or inertias by a mask, lane by lane.
template <class M, class S>
TailFin<S> select(const M& mask, const TailFin<S>& yes, const TailFin<S>& no) {
    return {select(mask, yes.middle, no.middle),     select(mask, yes.sense, no.sense),
            select(mask, yes.act, no.act),           select(mask, yes.lift, no.lift),
            select(mask, yes.fading, no.fading),     select(mask, yes.carried, no.carried),
            select(mask, yes.turning, no.turning),   select(mask, yes.suction, no.suction),
            select(mask, yes.attached, no.attached), select(mask, yes.leading, no.leading)};
}
template <class M, class S>
LinkInertia<S> select(const M& mask, const LinkInertia<S>& yes, const LinkInertia<S>& no) {
    return {select(mask, yes.tangential, no.tangential), select(mask, yes.normal, no.normal),
            select(mask, yes.coupling, no.coupling), select(mask, yes.rotary, no.rotary)};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
