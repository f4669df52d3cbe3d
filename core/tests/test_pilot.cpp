/// Pilot on a fish that is kinematics alone.
#include "cruise.hpp"

using namespace hypertuna;

static void a_box_at_depth() {
    const Waypoint<double> box[] = {{0, 30, 2, 0.3, 2}, {30, 30, 2, 0.3, 2}, {30, 0, 2, 0.3, 2}, {0, 0, 2, 0.3, 2}};
    const auto mission = mission_of(box, 4);
    const auto end = voyage(mission, Water{}, 1500, 1, [&](const Cruiser& fish, const PilotStep<double>& step, int k) {
        if (k % 1000 == 0)
            std::printf(
                "%6.1f x %6.2f y %6.2f z %5.2f yaw %6.2f pitch %5.2f U %.2f | %6.2f %6.2f d %5.2f s %5.2f c %.3f %.3f "
                "e %5.2f f %.2f| %s %x fin %.2f bias %.2f leg %d\n",
                fish.time, fish.x, fish.y, fish.z, fish.yaw, fish.pitch, fish.speed, step.estimate.x, step.estimate.y,
                step.estimate.depth, step.estimate.sink, step.estimate.current[0], step.estimate.current[1],
                step.estimate.position_error, step.estimate.factor, mode_names[int(step.mode)], step.reasons.flags,
                step.command.fin[0], step.command.bias[0], step.state.guidance.leg);
    });
    std::printf("%d %f %f %f\n", end.ticks, end.fish.x, end.fish.y, end.fish.z);
}

int main() {
    a_box_at_depth();
    return failures();
}
