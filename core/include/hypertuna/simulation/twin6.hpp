/// Twin in space: the true values of its sensors, and the pilot that steers it.
#pragma once

#include "hypertuna/pilot/pilot.hpp"
#include "hypertuna/simulation/body6.hpp"
#include "hypertuna/simulation/twin.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

/// Height of the antenna above the surface, m.
template <class S, class Law, int D>
S antenna_height(const Body6<S, Law, D>& body, const Pose6<S>& pose) {
    const Vector<S> place{body.tail.fish.link[0].com, S(0), body.antenna};
    return pose.position.z + dot(rotation(pose.attitude).up, place);
}

/// True values of all sensors: the IMU sits at the head's center of mass and stands upright; depth and fix are those of
/// the nose. `fixed` says whether the antenna is out of the water.
template <class S, class Law, int D>
PilotReadings<S> true_readings(const Twin<Body6<S, Law, D>>& twin, const TwinState<S, D, InSpace>& at,
                               const PlantOutput<S, D, InSpace>& seen) {
    PilotReadings<S> out{};
    out.robot = inner_readings<S, D, InSpace>(twin.plant.joints, at, seen);
    const Body6<S, Law, D>& body = twin.plant.body;
    const Pose6<S>& pose = at.plant.pose;
    const auto& [v, w] = at.plant.xi;
    const Rotation<S> r = rotation(pose.attitude);
    const S com = body.tail.fish.link[0].com;
    const Vector<S> arm{com, S(0), body.space[0].com_height};
    // Specific force: acceleration in the world minus gravity. The water's frame accelerates where the current changes.
    const Vector<S> nose = seen.twist_rate.linear + cross(w, v) + look_out(body, pose, at.plant.xi).fall;
    const Vector<S> force = nose + cross(seen.twist_rate.angular, arm) + cross(w, cross(w, arm));
    const Vector<S> field = to_body(r, body.sea.field);
    const auto put = [](S* to, const Vector<S>& from) { to[0] = from.x, to[1] = from.y, to[2] = from.z; };
    put(out.robot.rate, w);
    put(out.robot.acceleration, force);
    put(out.field, field);
    out.depth = depth_shown(body.sea, pose.position.z);
    out.fix[0] = pose.position.x, out.fix[1] = pose.position.y;
    out.fixed = S(0) < antenna_height(body, pose);
    return out;
}

/// One simulated tick of the twin, and the pilot's step in it.
template <class S, int D>
struct PilotTick {
    Tick<S, D, InSpace> tick;
    PilotStep<S> step;
};

/// Whether the head's motion is physically possible: 100 m/s at most, and finite.
template <class S>
bool plausible(const SpatialTwist<S>& xi, const Pose6<S>& pose) {
    const S far = S(base_t<S>(100)), speed = dot(xi.linear, xi.linear) + dot(xi.angular, xi.angular);
    return speed < far * far &&
           is_finite(pose.position.x + pose.position.y + pose.position.z + squared_norm(pose.attitude));
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
