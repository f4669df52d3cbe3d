/// Record of a tick in the black box: writer and reader iterate over the same list of fields.
#pragma once

#include "app/vehicle/vehicle.hpp"

namespace hypertuna::firmware {

/// Call visit(name, word), visit(name, number) or visit(name, numbers, count) for every field of a record, by its name
/// in a log (src/hypertuna/mission/record.py). The last word has four names, one for each byte.
template <class Visit>
constexpr void visit_record(const Snapshot& now, int joints, const Visit& visit) {
    const Command<float>& command = now.command;
    const Estimate<float>& at = now.estimate;
    visit("tick", now.tick);
    visit_channels([&](const auto& channel, int) {
        if (channel.converter != Converter::none)
            visit(channel.column, channel.of(now.readings), channel.count(joints));
    });
    visit("pulse", now.output.pulse, servos_of(joints)), visit("angle_set", now.output.set, joints);
    visit("frequency_commanded", command.frequency), visit("amplitude_commanded", command.amplitude, joints);
    visit("lag_commanded", command.phase, joints), visit("bias_commanded", command.bias, joints);
    visit("fin_commanded", command.fin, 2);
    visit("attitude_estimated", &at.q.w, 4), visit("position_estimated", &at.x, 2);
    visit("depth_estimated", at.depth), visit("speed_estimated", at.speed), visit("position_error", at.position_error);
    visit("status", now.output.status.flags), visit("reasons", now.reasons.flags), visit("faults", now.faults.flags);
    visit("mode state armed answer", std::uint32_t(now.mode) | std::uint32_t(now.state) << 8 |
                                         std::uint32_t(now.armed()) << 16 | std::uint32_t(now.answer) << 24);
}

/// Digest of the fields' names (FNV-1a), by which a reader recognizes the layout of the records.
inline constexpr std::uint32_t record_layout = [] {
    const Snapshot none{};
    std::uint32_t sum = 2166136261u;
    visit_record(none, max_joints, [&](const char* name, auto...) {
        do sum = (sum ^ std::uint8_t(*name)) * 16777619u;
        while (*name++ != 0);
    });
    return sum;
}();

}  // namespace hypertuna::firmware
