/// File transfer, read only: the files that describe the parameters to ground stations
/// (mavlink.io/en/services/ftp.html).
///
/// There is one session, number 0: it belongs to the file opened last and to the station that opened it. Pieces of
/// files are sent after answers and heartbeats, in turn with telemetry.
#pragma once

#include "app/radio/radio_state.hpp"

namespace hypertuna::firmware {

inline constexpr int ftp_head = 12, ftp_data = 239;  // bytes of a message's payload

enum FtpCode : std::uint8_t {
    ftp_terminate = 1,
    ftp_reset = 2,
    ftp_open = 4,
    ftp_read = 5,
    ftp_checksum = 14,
    ftp_burst = 15,
    ftp_ack = 128,
    ftp_nak = 129,
};
enum FtpError : std::uint8_t {
    ftp_wrong_size = 3,
    ftp_no_session = 4,
    ftp_end = 6,
    ftp_unknown = 7,
    ftp_not_found = 10
};

/// Head of the payload.
struct FtpHead {
    std::uint16_t sequence;
    std::uint8_t session, code, size, request, complete, spare;
    std::uint32_t offset;
};
static_assert(sizeof(FtpHead) == ftp_head);

inline FtpHead ftp_head_of(const mavlink_file_transfer_protocol_t& m) {
    FtpHead head;
    std::memcpy(&head, m.payload, sizeof head);
    return head;
}

inline mavlink_file_transfer_protocol_t ftp_message(Peer to, const FtpHead& head, const void* data, int count) {
    mavlink_file_transfer_protocol_t m{};
    m.target_system = to.system, m.target_component = to.component;
    std::memcpy(m.payload, &head, sizeof head);
    if (0 < count) std::memcpy(m.payload + ftp_head, data, std::size_t(count));
    return m;
}

/// Answer a request with a number, or without data.
inline void ftp_answer(Radio& radio, Peer to, FtpHead head, int size, std::uint32_t number = 0) {
    head.request = head.code, head.code = ftp_ack, head.size = std::uint8_t(size), head.offset = 0, ++head.sequence;
    reply(radio.out, ftp_message(to, head, &number, size));
}
inline void ftp_refuse(Radio& radio, Peer to, FtpHead head, FtpError error) {
    head.request = head.code, head.code = ftp_nak, head.size = 1, ++head.sequence;
    reply(radio.out, ftp_message(to, head, &error, 1));
}

/// Number of the file with a name, with or without a slash before the name; -1 for none.
inline int file_named(const Description& robot, const char* name, int length) {
    if (0 < length && *name == '/') ++name, --length;
    for (int k = 0; k < robot.files; ++k) {
        const char* own = robot.file[k].name;
        if (int(std::strlen(own)) == length && std::memcmp(own, name, std::size_t(length)) == 0) return k;
    }
    return -1;
}

inline void handle(Radio& radio, const Vehicle& vehicle, Peer from, const mavlink_file_transfer_protocol_t& m) {
    const Description& robot = *vehicle.robot;
    const FtpHead head = ftp_head_of(m);
    if (ftp_data < head.size) return ftp_refuse(radio, from, head, ftp_wrong_size);
    const char* name = reinterpret_cast<const char*>(m.payload + ftp_head);
    const bool named = head.code == ftp_open || head.code == ftp_checksum;
    const int length = head.size != 0 && name[head.size - 1] == 0 ? head.size - 1 : head.size;
    Transfer& transfer = radio.transfer;
    const bool open = transfer.open && transfer.to == from && head.session == 0;
    const int file = named ? file_named(robot, name, length) : open ? transfer.file : -1;
    const bool known = 0 <= file;
    switch (head.code) {
        case ftp_terminate:
        case ftp_reset:
            if (open) transfer.open = transfer.on = false;
            return ftp_answer(radio, from, head, 0);
        case ftp_open:
            if (!known) return ftp_refuse(radio, from, head, ftp_not_found);
            transfer = {true, false, from, file, 0, 0, 0, 0};
            return ftp_answer(radio, from, head, 4, std::uint32_t(robot.file[file].size));
        case ftp_checksum:
            if (!known) return ftp_refuse(radio, from, head, ftp_not_found);
            return ftp_answer(radio, from, head, 4, robot.file[file].crc);
        case ftp_read:
        case ftp_burst:
            if (!known) return ftp_refuse(radio, from, head, ftp_no_session);
            if (std::uint32_t(robot.file[file].size) <= head.offset) return ftp_refuse(radio, from, head, ftp_end);
            transfer = {true, true, from, file, head.code, head.sequence, int(head.offset), head.size};
            return;
        default:
            return ftp_refuse(radio, from, head, ftp_unknown);
    }
}

/// Send the next piece of a file; false if there is none.
inline bool send_next_piece(Radio& radio, const Vehicle& vehicle) {
    Transfer& transfer = radio.transfer;
    if (!transfer.on) return false;
    const FileInfo& file = vehicle.robot->file[transfer.file];
    const int rest = file.size - transfer.offset, most = 0 < transfer.limit ? transfer.limit : ftp_data;
    const int count = rest < most ? rest : most;
    const bool last = transfer.code == ftp_read || count == rest;
    const FtpHead head{
        ++transfer.sequence,           0, ftp_ack, std::uint8_t(count), transfer.code, std::uint8_t(last), 0,
        std::uint32_t(transfer.offset)};
    send(radio.out, radio.signing, ftp_message(transfer.to, head, file.bytes + transfer.offset, count));
    transfer.offset += count, transfer.on = !last;
    return true;
}

}  // namespace hypertuna::firmware
