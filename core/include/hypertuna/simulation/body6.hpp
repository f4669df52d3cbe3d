/// The body in space: the tail's links with all six degrees of freedom of the head, and fins, weight and buoyancy.
///
/// Joints yaw only, so every link shares the head's z axis: of its motion (v_t, v_n, v_z, w_t, w_n, w) the part in the
/// plane (v_t, v_n, w) is that of chain.hpp, and the part across it follows from the head's heave, roll rate and pitch
/// rate alone. A link is taken at its center of mass projected to the plane of the joints. It is symmetric about its
/// own upright plane; what lies above or below the plane of the joints couples the two parts. The link obeys
/// Kirchhoff's
///     d/dt (Lambda V) + V x* (Lambda V) = f,
/// Lambda its inertia with added mass, V its velocity relative to the water. Forces in the plane are those of
/// water.hpp: where nothing lies outside the plane, what moves in it stays in it and is the tail of tail.hpp.
#pragma once

#include "hypertuna/simulation/body6_model.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Geometry of a link relative to the head: cosine and sine of its direction, its point in the plane, and how the
/// head's motion across the plane moves that point.
template <class S>
struct LinkView {
    S c, s, x, y;

    HYPERTUNA_INLINE LinkView(const LinkShape<S>& at)
        : c(at.c), s(at.s), x(at.c * at.h_n + at.s * at.h_t), y(at.s * at.h_n - at.c * at.h_t) {}

    HYPERTUNA_INLINE Across<S> velocity(const SpatialTwist<S>& xi) const {
        const S p = xi.angular.x, q = xi.angular.y;
        return {xi.linear.z + p * y - q * x, c * p + s * q, c * q - s * p};
    }
    /// Transpose of `velocity`: turns a load on the link across the plane into a force up and moments about x and y at
    /// the nose.
    HYPERTUNA_INLINE Across<S> wrench(const Across<S>& f) const {
        return {f.z, y * f.z + c * f.t - s * f.n, s * f.t + c * f.n - x * f.z};
    }
    HYPERTUNA_INLINE Vector<S> turned(const Vector<S>& v) const { return {c * v.x + s * v.y, c * v.y - s * v.x, v.z}; }
};

/// Velocity, momentum or load of a link: its parts in the plane and across it.
template <class S>
struct LinkPair {
    Along<S> in;
    Across<S> across;
};

/// Lambda V of a link.
template <class S>
HYPERTUNA_INLINE LinkPair<S> link_momentum(const LinkInertia<S>& inertia, const LinkSpace<S>& k, const LinkPair<S>& v) {
    const Along<S> plane = inertia * v.in;
    return {
        {plane.t + k.along * v.across.n, plane.n + k.along_height * v.across.t, plane.w + k.turn_height * v.across.t},
        {k.heave * v.across.z + k.heave_pitch * v.across.n,
         k.roll * v.across.t + k.along_height * v.in.n + k.turn_height * v.in.w,
         k.pitch * v.across.n + k.along * v.in.t + k.heave_pitch * v.across.z}};
}

/// Integrals of v |v| and s v |v| over s from 0 to 1, for a velocity that goes linearly from v0 to v1.
template <class S>
struct Rise {
    S force, moment;
};
template <class S>
HYPERTUNA_INLINE Rise<S> rise_drag(const S& v0, const S& v1) {
    const S third(base_t<S>(1.0 / 3)), quarter(base_t<S>(0.25)), s0 = v0 * v0, s1 = v1 * v1, mixed = v0 * v1;
    if (!(mixed < S(0))) {
        const S sign = select(v0 + v1 < S(0), S(-1), S(1));
        return {sign * third * (s0 + mixed + s1), sign * third * quarter * (s0 + S(2) * mixed + S(3) * s1)};
    }
    const S gain = S(1) / (v1 - v0), cubes = gain * third * (s1 * abs(v1) - s0 * abs(v0));
    return {cubes, gain * (gain * quarter * (s1 * times_abs(v1) - s0 * times_abs(v0)) - v0 * cubes)};
}

/// Drag of the water on link i, in and across the plane, with the whole link under water.
template <class S, class Law, int D>
HYPERTUNA_INLINE LinkPair<S> link_drag(const Body6<S, Law, D>& body, int i, const LinkPair<S>& v) {
    const LinkSpace<S>& k = body.space[i];
    const S c = k.center_height;
    const Along<S> plane =
        water_force(body.tail.fish, i, Along<S>{v.in.t + c * v.across.n, v.in.n - c * v.across.t, v.in.w},
                    body.tail.shape[i].bending());
    LinkPair<S> f{plane, {S(0), S(0) - c * plane.n - k.drag_roll * times_abs(v.across.t), c * plane.t}};
    // The integral along the link is exact: each point rises at its own rate.
    const S front = k.middle - k.half_length, rear = k.middle + k.half_length;
    const Rise<S> rise = rise_drag(v.across.z - front * v.across.n, v.across.z - rear * v.across.n);
    f.across.z -= k.drag * rise.force;
    f.across.n += k.drag * (front * rise.force + (rear - front) * rise.moment);
    if (i == body.tail.fish.links - 1) {
        // Lighthill's reactive force as in water.hpp, up and down instead of sideways.
        const Along<S> end = faded_wake_force(body.wake, Along<S>{v.in.t, v.across.z - rear * v.across.n, S(0)});
        f.in.t += end.t;
        f.across.z += end.n;
        f.across.n -= rear * end.n;
    }
    return f;
}

/// Vertical direction, gravity and height at the head at one instant, which the forces of all links share.
template <class S>
struct Outlook {
    Vector<S> up;    // upward direction in body axes
    Vector<S> fall;  // m/s^2 in body axes: g upward, plus the acceleration of the frame that moves with the current
    S z;             // m, height of the nose
    bool deep;       // no part of the robot is near the surface
};

template <class S, class Law, int D>
HYPERTUNA_INLINE Outlook<S> look_out(const Body6<S, Law, D>& body, const Pose6<S>& pose, const SpatialTwist<S>& xi) {
    const Rotation<S> r = rotation(pose.attitude);
    const Vector<S> drift = current_rate(body.sea, pose.position.z, dot(r.up, xi.linear));
    return {r.up, to_body(r, drift) + S(base_t<S>(gravity)) * r.up, pose.position.z,
            pose.position.z < S(0) - body.reach};
}

/// Buoyancy on a link whose point is at the height z, and the share of the link that is under water. Near the surface
/// the link's two halves emerge one after the other.
template <class S>
struct Buoyancy {
    Across<S> across;
    Along<S> in;
    S share;
};
template <class S>
HYPERTUNA_INLINE Buoyancy<S> buoyancy(const LinkSpace<S>& k, const Vector<S>& up, const S& z, bool deep) {
    S share(1), arm = k.center;
    if (!deep) {
        const S apart = k.half_length * S(base_t<S>(0.57735026918962576)), half(base_t<S>(0.5));
        const S middle = z + up.x * k.center + up.z * k.center_height;
        const S front = half * submerged(middle - apart * up.x, k.height);
        const S rear = half * submerged(middle + apart * up.x, k.height);
        share = front + rear;
        arm = k.center * share + apart * (rear - front);
    }
    const S f = k.lift * share, f_arm = k.lift * arm, c = k.center_height;
    return {{f * up.z, S(0) - c * f * up.y, c * f * up.x - f_arm * up.z}, {f * up.x, f * up.y, f_arm * up.y}, share};
}

/// Load on link i that keeps the head's twist and the coordinates' rates constant: its inertial force minus weight,
/// buoyancy and drag.
template <class S, class Law, int D>
HYPERTUNA_INLINE LinkPair<S> link_load(const Body6<S, Law, D>& body, int i, const LinkView<S>& view,
                                       const SpatialTwist<S>& xi, const Outlook<S>& out) {
    const LinkShape<S>& at = body.tail.shape[i];
    const LinkSpace<S>& k = body.space[i];
    const LinkInertia<S>& inertia = body.tail.fish.water.inertia(i);
    const LinkPair<S> v{at.velocity(in_plane(xi)), view.velocity(xi)};
    // The point moves, and the link's axes turn against the head's.
    const S x_rate = at.c * at.a_t - at.s * at.a_n, y_rate = at.s * at.a_t + at.c * at.a_n;
    const LinkPair<S> rate{
        velocity_rate(at, body.tail.acceleration[i], in_plane(xi)),
        {xi.angular.x * y_rate - xi.angular.y * x_rate, at.w * v.across.n, S(0) - at.w * v.across.t}};
    const LinkPair<S> p = link_momentum(inertia, k, v), change = link_momentum(inertia, k, rate);
    LinkPair<S> drag = link_drag(body, i, v);
    const Vector<S> up = view.turned(out.up), fall = view.turned(out.fall);
    const Buoyancy<S> lift = buoyancy(k, up, out.z + out.up.x * view.x + out.up.y * view.y, out.deep);
    const S share = lift.share, m = k.mass, h = k.com_height;
    const S wt = v.across.t, wn = v.across.n, w = v.in.w, vt = v.in.t, vn = v.in.n, vz = v.across.z;
    return {
        {change.in.t + wn * p.across.z - w * p.in.n - share * drag.in.t - lift.in.t + m * fall.x,
         change.in.n + w * p.in.t - wt * p.across.z - share * drag.in.n - lift.in.n + m * fall.y,
         change.in.w + vt * p.in.n - vn * p.in.t + wt * p.across.n - wn * p.across.t - share * drag.in.w - lift.in.w},
        {change.across.z + wt * p.in.n - wn * p.in.t - share * drag.across.z - lift.across.z + m * fall.z,
         change.across.t + wn * p.in.w - w * p.across.n + vn * p.across.z - vz * p.in.n - share * drag.across.t -
             lift.across.t - h * m * fall.y,
         change.across.n + w * p.across.t - wt * p.in.w + vz * p.in.t - vt * p.across.z - share * drag.across.n -
             lift.across.n + h * m * fall.x}};
}

/// The equations of motion: those of the tail in the plane, and what heave, roll and pitch add.
template <class S, int D>
struct BodyEquations {
    TailEquations<S, D> tail;
    Symmetric<S> across;  // mass matrix of heave, roll and pitch
    Momentum<S> roll;     // mass matrix between roll and the motion in the plane
    Momentum<S> pitch;    // mass matrix between pitch and the motion in the plane
    S bend[D][2];         // mass matrix between each coordinate and roll and pitch
    Across<S> load;       // load on heave, roll and pitch
};

/// Add a force f at the point `at` of the body to the head's load; both in head axes.
template <class S, int D>
HYPERTUNA_INLINE void push(BodyEquations<S, D>& sum, const Vector<S>& f, const Vector<S>& at) {
    const Vector<S> moment = cross(at, f);
    sum.tail.load = sum.tail.load + Wrench<S>{f.x, f.y, moment.z};
    sum.load = {sum.load.z + f.z, sum.load.t + moment.x, sum.load.n + moment.y};
}

/// Add the forces of the fins, and those of bottom and snag on the nose.
template <class S, class Law, int D>
HYPERTUNA_INLINE void push_head(const Body6<S, Law, D>& body, const Pose6<S>& pose, const SpatialTwist<S>& xi,
                                const Outlook<S>& out, BodyEquations<S, D>& sum) {
    for (int side = 0; side < 2; ++side) {
        Vector<S> at = body.fin.place;
        if (side == 0) at.y = S(0) - at.y;
        const Vector<S> v = xi.linear + cross(xi.angular, at);
        const FinForce<S> f = fin_force(body.fin, body.sea.density, v.x, v.z, pose.fin[side]);
        const S share = out.deep ? S(1) : submerged(out.z + dot(out.up, at), body.fin.chord);
        push(sum, Vector<S>{share * f.x, S(0), share * f.z}, at);
    }
    const S floor = bottom_force(body.sea, out.z, dot(out.up, xi.linear));
    const Vector<S> nose{S(0), S(0), S(0)};
    if (S(0) < floor) push(sum, floor * out.up, nose);
    if (!(S(0) < body.sea.snag.stiffness)) return;
    const Rotation<S> r = rotation(pose.attitude);
    const Vector<S> velocity = to_world(r, xi.linear) + current(body.sea, pose.position.z);
    push(sum, to_body(r, snag_force(body.sea.snag, pose.position, velocity)), nose);
}

/// Add the force of the bottom on the tail end.
template <class S, class Law, int D>
HYPERTUNA_INLINE void push_tail(const Body6<S, Law, D>& body, const SpatialTwist<S>& xi, const Outlook<S>& out,
                                const Twist<S> (&screw)[D], BodyEquations<S, D>& sum) {
    const int last = body.tail.fish.links - 1;
    const LinkShape<S>& at = body.tail.shape[last];
    const LinkView<S> view(at);
    const S behind = body.tail.fish.link[last].length - body.tail.fish.link[last].com;
    const Vector<S> end{view.x + at.c * behind, view.y + at.s * behind, S(0)};
    const S z = out.z + dot(out.up, end);
    if (!(z < S(0) - body.sea.bottom)) return;
    const Along<S> v = tail_velocity(body.tail.fish.link[last], at.velocity(in_plane(xi)));
    const S across = xi.linear.z + xi.angular.x * end.y - xi.angular.y * end.x;
    const S rise = out.up.x * (at.c * v.t - at.s * v.n) + out.up.y * (at.s * v.t + at.c * v.n) + out.up.z * across;
    const Vector<S> f = bottom_force(body.sea, z, rise) * out.up;
    push(sum, f, end);
    const Wrench<S> wrench{f.x, f.y, end.x * f.y - end.y * f.x};
    for (int d = 0; d < D; ++d) sum.tail.bend_load[d] += dot(screw[d], wrench);
}

/// Sum up the equations of motion from nose to tail, as tail_equations does.
template <class S, class Law, int D>
HYPERTUNA_INLINE BodyEquations<S, D> body_equations(const Body6<S, Law, D>& body, const Pose6<S>& pose,
                                                    const SpatialTwist<S>& xi) {
    const Tail<S, Law, D>& tail = body.tail;
    const Outlook<S> out = look_out(body, pose, xi);
    BodyEquations<S, D> sum{};
    Twist<S> screw[D] = {};
    for (int i = 0; i < tail.fish.links; ++i) {
        const LinkShape<S>& at = tail.shape[i];
        const LinkView<S> view(at);
        const LinkSpace<S>& k = body.space[i];
        const Symmetric<S> inertia = seen_from_nose(at, tail.fish.water.inertia(i));
        const LinkPair<S> load = link_load(body, i, view, xi, out);
        const Wrench<S> bias = at.wrench(load.in);
        const Across<S> lift = view.wrench(load.across);
        // Momenta across the plane at unit rates of roll and pitch; those in the plane follow below.
        const S c = at.c, s = at.s;
        const Across<S> up = view.wrench({k.heave, S(0), k.heave_pitch});
        const Across<S> rolling =
            view.wrench({k.heave * view.y - k.heave_pitch * s, k.roll * c, k.heave_pitch * view.y - k.pitch * s});
        const S pitch_z = k.heave_pitch * c - k.heave * view.x, pitch_n = k.pitch * c - k.heave_pitch * view.x;
        sum.across = {sum.across.xx + up.z,      sum.across.xy + up.t,
                      sum.across.xz + up.n,      sum.across.yy + rolling.t,
                      sum.across.yz + rolling.n, sum.across.zz + s * (k.roll * s) + c * pitch_n - view.x * pitch_z};
        sum.load = {sum.load.z - lift.z, sum.load.t - lift.t, sum.load.n - lift.n};
        TailEquations<S, D>& plane = sum.tail;
        plane.body = {plane.body.xx + inertia.xx, plane.body.xy + inertia.xy, plane.body.xz + inertia.xz,
                      plane.body.yy + inertia.yy, plane.body.yz + inertia.yz, plane.body.zz + inertia.zz};
        plane.load = plane.load - bias;
        const Planar<S> joint = joint_position(at, tail.fish.link[i]);
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) {
            const S share = tail.share[i][d];
            screw[d] = screw[d] + Twist<S>{share * joint.y, -share * joint.x, share};
            const Momentum<S> carried = inertia * screw[d];
            plane.cross[d] = plane.cross[d] + carried;
            plane.bend_load[d] -= dot(screw[d], bias);
            HYPERTUNA_UNROLL
            for (int e = 0; e <= d; ++e) plane.bend[d][e] += dot(screw[e], carried);
        }
        if (k.flat) continue;
        const Momentum<S> roll = at.wrench(Along<S>{S(0) - s * k.along, c * k.along_height, c * k.turn_height});
        const Momentum<S> pitch = at.wrench(Along<S>{c * k.along, s * k.along_height, s * k.turn_height});
        sum.roll = sum.roll + roll;
        sum.pitch = sum.pitch + pitch;
        HYPERTUNA_UNROLL
        for (int d = 0; d < D; ++d) {
            sum.bend[d][0] += dot(screw[d], roll);
            sum.bend[d][1] += dot(screw[d], pitch);
        }
    }
    push_head(body, pose, xi, out, sum);
    push_tail(body, xi, out, screw, sum);
    return sum;
}

template <class S, int D>
struct BodyAcceleration {
    SpatialTwist<S> twist;  // rate of the twist's components, m/s^2 and rad/s^2
    S bend[D];              // rad/s^2
};

/// Accelerations under moments on the coordinates [N m]. Leaves the shape in the tail's memory.
template <class S, class Law, int D>
BodyAcceleration<S, D> body6_acceleration(const Body6<S, Law, D>& body, const Bend<S, D>& bend,
                                          const SpatialTwist<S>& xi, const Pose6<S>& pose, const S (&moment)[D]) {
    bend_tail(body.tail, bend);
    const BodyEquations<S, D> sum = body_equations(body, pose, xi);
    // The rows are in the order x, y, yaw, heave, roll, pitch, then the coordinates.
    const Symmetric<S>&a = sum.tail.body, &b = sum.across;
    S matrix[6 + D][6 + D];  // the lower triangle
    const auto put = [&](int row, std::initializer_list<S> values) {
        int column = 0;
        for (const S& value : values) matrix[row][column++] = value;
    };
    put(0, {a.xx});
    put(1, {a.xy, a.yy});
    put(2, {a.xz, a.yz, a.zz});
    put(3, {S(0), S(0), S(0), b.xx});
    put(4, {sum.roll.x, sum.roll.y, sum.roll.z, b.xy, b.yy});
    put(5, {sum.pitch.x, sum.pitch.y, sum.pitch.z, b.xz, b.yz, b.zz});
    S load[6 + D] = {sum.tail.load.x, sum.tail.load.y, sum.tail.load.z, sum.load.z, sum.load.t, sum.load.n};
    for (int d = 0; d < D; ++d) {
        const Momentum<S>& cross = sum.tail.cross[d];
        put(6 + d, {cross.x, cross.y, cross.z, S(0), sum.bend[d][0], sum.bend[d][1]});
        for (int e = 0; e <= d; ++e) matrix[6 + d][6 + e] = sum.tail.bend[d][e];
        matrix[6 + d][6 + d] += body.tail.armature[d];
        load[6 + d] = moment[d] + sum.tail.bend_load[d];
    }
    solve_cholesky(matrix, load);
    BodyAcceleration<S, D> out{{{load[0], load[1], load[3]}, {load[4], load[5], load[2]}}, {}};
    for (int d = 0; d < D; ++d) out.bend[d] = load[6 + d];
    return out;
}

/// The function that a plant calls to accelerate its body, and the pose with its attitude normalized.
template <class S, class Law, int D>
HYPERTUNA_INLINE BodyAcceleration<S, D> body_acceleration(const Body6<S, Law, D>& body, const Bend<S, D>& bend,
                                                          const SpatialTwist<S>& xi, const Pose6<S>& pose,
                                                          const S (&moment)[D]) {
    return body6_acceleration(body, bend, xi, pose, moment);
}
template <class S>
HYPERTUNA_INLINE Pose6<S> tidied(const Pose6<S>& pose) {
    return {pose.position, normalized(pose.attitude), {pose.fin[0], pose.fin[1]}};
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
