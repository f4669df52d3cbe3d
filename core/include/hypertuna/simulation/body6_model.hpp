/// Model of the body in space: its links beyond the plane, its pose, and how the pose follows a twist.
#pragma once

#include "hypertuna/simulation/fin.hpp"
#include "hypertuna/simulation/sea.hpp"
#include "hypertuna/simulation/tail.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Velocity of a link across the plane: up, and rates of turn about its own axes t and n. Momenta, forces and moments
/// use the same type.
template <class S>
struct Across {
    S z, t, n;
};

/// What describes a link in space in addition to Link; heights are above the plane of the joints.
template <class S>
struct LinkBody {
    S com_height;      // m
    S roll, pitch;     // kg m^2, about the axes t and n through the center of mass
    S volume;          // m^3
    S center;          // m, center of buoyancy behind the front joint
    S center_height;   // m; forces of the water in the plane act at this height
    S height, width;   // m, of the section, mean over the link
    S drag_vertical;   // C_z on length x width
    S added_vertical;  // vertical added mass in units of rho pi/4 width^2
    S drag_roll;       // C_r on length x height
};

/// Order of a LinkBody's numbers in a row from Python.
inline constexpr const char* link_body_columns[] = {"com_height",    "roll",           "pitch",    "volume",
                                                    "center",        "center_height",  "height",   "width",
                                                    "drag_vertical", "added_vertical", "drag_roll"};

template <class S, class T>
LinkBody<S> read_link_body(const T* row) {
    const auto at = [row](int k) { return S(base_t<S>(row[k])); };
    return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8), at(9), at(10)};
}

/// Constants of a link in the equations of motion.
template <class S>
struct LinkSpace {
    S along, along_height, turn_height;  // kg m, kg m, kg m^2: inertia between v_t and w_n, v_n and w_t, w and w_t
    S heave, heave_pitch;                // kg, kg m: inertia of v_z, and between v_z and w_n
    S roll, pitch;                       // kg m^2, inertia of w_t and w_n about the link's point in the plane
    S mass, com_height;                  // kg, m
    S lift;                              // N, buoyancy with the whole link under water
    S center, center_height;             // m, center of buoyancy from the link's point
    S height;                            // m, of the section
    S drag, middle,
        half_length;  // kg/m, m, m: vertical drag of the whole link; its middle from the link's point; half its length
    S drag_roll;      // kg m^2
    bool flat;        // no mass or force of the link lies above or below the plane of the joints
};

template <class S>
LinkSpace<S> make_link_space(const LinkBody<S>& body, const Link<S>& link, const LinkInertia<S>& inertia,
                             const S& density) {
    const S half(base_t<S>(0.5)), h = body.com_height, c = body.center_height;
    const S quarter_pi(base_t<S>(pi / 4)), middle = half * link.length - link.com;
    // Added mass in the plane, and out of it.
    const S tangential = inertia.tangential - link.mass, normal = inertia.normal - link.mass;
    const S added = body.added_vertical * density * quarter_pi * body.width * body.width * link.length;
    const S thick = body.height * body.height - body.width * body.width;
    const S added_roll = density * S(base_t<S>(pi / 128)) * thick * thick * link.length;
    const S side = half * density * body.drag_roll * link.length * body.height * body.height;
    LinkSpace<S> out;
    out.along = link.mass * h + tangential * c;
    out.along_height = S(0) - (link.mass * h + normal * c);
    out.turn_height = S(0) - inertia.coupling * c;
    out.heave = link.mass + added;
    out.heave_pitch = S(0) - added * middle;
    out.roll = body.roll + link.mass * h * h + normal * c * c + added_roll;
    out.pitch = body.pitch + link.mass * h * h + tangential * c * c +
                added * (middle * middle + link.length * link.length * S(base_t<S>(1.0 / 12)));
    out.mass = link.mass, out.com_height = h;
    out.lift = density * S(base_t<S>(gravity)) * body.volume;
    out.center = body.center - link.com, out.center_height = c;
    out.height = body.height;
    out.drag = half * density * body.drag_vertical * link.length * body.width;
    out.middle = middle, out.half_length = half * link.length;
    out.flat = h == S(0) && c == S(0);
    out.drag_roll = side * body.height * body.height * S(base_t<S>(1.0 / 32));
    return out;
}

template <class S, class Law, int D>
struct Body6 {
    using Scalar = S;
    using Space = InSpace;
    static constexpr int coordinates = D;

    Tail<S, Law, D> tail;       // its head is never clamped
    const LinkSpace<S>* space;  // one per link
    S wake;     // kg/m: part of the largest vertical added mass per length that the tail end leaves behind
    S reach;    // m: largest distance of any part of the robot from the nose
    S antenna;  // m, height of the satellite receiver's antenna above the head's point in the plane
    Fin<S> fin;
    Sea<S> sea;
};

/// Position of the nose, attitude of the head, and angles of the fins.
template <class S>
struct Pose6 {
    Vector<S> position;      // m
    Quaternion<S> attitude;  // body to world
    S fin[2];                // rad

    template <class A>
    friend HYPERTUNA_INLINE Pose6 operator*(const A& a, const Pose6& b) {
        return {a * b.position, a * b.attitude, {a * b.fin[0], a * b.fin[1]}};
    }
    friend HYPERTUNA_INLINE Pose6 operator+(const Pose6& a, const Pose6& b) {
        return {a.position + b.position, a.attitude + b.attitude, {a.fin[0] + b.fin[0], a.fin[1] + b.fin[1]}};
    }
};

template <class S>
struct HeadOf<S, InSpace> {
    using Twist = SpatialTwist<S>;
    using Pose = Pose6<S>;
};

/// Rate of the pose at a twist, which is relative to the water at the nose's depth; the fins follow their targets.
template <class S, class Law, int D>
HYPERTUNA_INLINE Pose6<S> pose_rate(const Body6<S, Law, D>& body, const Pose6<S>& pose, const SpatialTwist<S>& xi,
                                    const S* fin_target) {
    const Rotation<S> r = rotation(pose.attitude);
    return {to_world(r, xi.linear) + current(body.sea, pose.position.z),
            attitude_rate(pose.attitude, xi.angular),
            {fin_rate(body.fin, pose.fin[0], fin_target[0]), fin_rate(body.fin, pose.fin[1], fin_target[1])}};
}

/// The part of a twist in the plane, for tail.hpp.
template <class S>
HYPERTUNA_INLINE Twist<S> in_plane(const SpatialTwist<S>& xi) {
    return {xi.linear.x, xi.linear.y, xi.angular.z};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
