#include "app/radio/radio.hpp"

#include "app/radio/dispatch.hpp"

namespace hypertuna::firmware {

static constexpr int max_bytes = 512;  // bytes read per tick: 50 kB/s
static constexpr int max_frames = 8;   // frames made per tick

const MessageKind* accepted_kind(std::uint32_t id) {
    for (const MessageKind& kind : accepted.kind)
        if (kind.id == id) return &kind;
    return nullptr;
}

void boot(Radio& radio, const Vehicle& vehicle) {
    std::memset(static_cast<void*>(&radio), 0, sizeof radio);  // a temporary would not fit onto the stack
    begin(radio.telemetry);
    radio.fault_reported_at = radio.refusal_reported_at = 0u - 1000u;  // long ago
    radio.out.sender = {std::uint8_t(limits(vehicle).system_id), own_component, 0};
    radio.signing.stamp = radio.signing.floor = vehicle.stamp;
    adopt_key(radio.signing, vehicle);
}

/// Report new faults, one per second.
static void report_faults(Radio& radio, const Snapshot& now) {
    radio.reported_faults.flags &= now.faults.flags;
    const std::uint32_t fresh = now.faults.flags & ~radio.reported_faults.flags;
    if (fresh == 0 || now.tick - radio.fault_reported_at < 100 || !has_room(radio.out, max_answers_per_command)) return;
    for (int f = 0; f < faults; ++f)
        if (fresh >> f & 1) {
            radio.reported_faults.set(Fault(f), true), radio.fault_reported_at = now.tick;
            return send_text(radio, std::uint8_t(fault_texts[f].severity), fault_texts[f].sentence);
        }
}

/// Send mode and current item when they change.
static void report_changes(Radio& radio, const Vehicle& vehicle) {
    const State state = snapshot(vehicle).state;
    if (radio.reported_state == state && radio.reported_leg == vehicle.leg) return;
    if (radio.reported_state != state)
        radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_CURRENT_MODE)].requested = true;
    radio.telemetry.stream[stream_index(MAVLINK_MSG_ID_MISSION_CURRENT)].requested = true;
    radio.reported_state = state, radio.reported_leg = vehicle.leg;
}

/// Send the next parameter or mode of a list, or the next piece of a file; false if there is none.
static bool send_next_of_list(Radio& radio, const Vehicle& vehicle) {
    return send_next_parameter(radio, vehicle) || send_next_mode(radio) || send_next_piece(radio, vehicle);
}

/// Add a tick's share to the allowances. A full buffer in the radio reduces that of telemetry and lists, not that of
/// answers.
static void allow(Radio& radio, const Vehicle& vehicle) {
    Outbox& out = radio.out;
    const Limits& limit = limits(vehicle);
    Telemetry& telemetry = radio.telemetry;
    if (radio_status_lasts < snapshot(vehicle).tick - telemetry.radio_status_at) telemetry.throttle = 100;
    const float line = limit.link_rate / 8.0f / ticks_per_second;
    out.rate = max(line * limit.link_share, min(line, float(least_rate) / ticks_per_second));
    allow(out.allowance, out.rate);
    allow(telemetry.allowance, out.rate * float(telemetry.throttle) / 100.0f);
}

/// Send telemetry or the next item of a list, in turn; false if there is neither.
static bool send_in_turn(Radio& radio, const Vehicle& vehicle) {
    Outbox& out = radio.out;
    const float before = out.allowance;
    const bool sent = ((out.frames & 1) != 0 && send_next_of_list(radio, vehicle)) ||
                      send_telemetry(radio.telemetry, out, radio.signing, vehicle, radio.parser) ||
                      send_next_of_list(radio, vehicle);
    radio.telemetry.allowance += out.allowance - before;
    radio.telemetry.sent = radio.telemetry.sent || sent;
    return sent;
}

/// Fill the outbox: a due heartbeat first, then answers, then lists and telemetry.
static void fill_outbox(Radio& radio, const Vehicle& vehicle) {
    Outbox& out = radio.out;
    out.sender.system = std::uint8_t(limits(vehicle).system_id);
    allow(radio, vehicle);
    for (int k = 0; k < max_frames && may_send(out); ++k) {
        if (heartbeat_is_due(radio.telemetry, snapshot(vehicle).tick)) {
            send_telemetry(radio.telemetry, out, radio.signing, vehicle, radio.parser);
        } else if (!send_answer(out, radio.signing)) {
            if (radio.telemetry.allowance <= 0.0f || !send_in_turn(radio, vehicle)) break;
        }
    }
}

void tick(Radio& radio, Vehicle& vehicle, const std::uint8_t* bytes, int count) {
    adopt_key(radio.signing, vehicle);
    radio.signing.stamp += std::uint64_t(1e5f / ticks_per_second);
    const int end = count < max_bytes ? count : max_bytes;
    Frame frame;
    for (int at = 0; at < end;) {
        at += feed(radio.parser, bytes + at, end - at);
        while (next(radio.parser, frame)) on_frame(radio, vehicle, frame);
    }
    store_stamp(radio.signing, vehicle);
    await_item(radio, vehicle);
    calibrate_gyro(radio, vehicle);
    report_faults(radio, snapshot(vehicle));
    report_changes(radio, vehicle);
    fill_outbox(radio, vehicle);
}

}  // namespace hypertuna::firmware
