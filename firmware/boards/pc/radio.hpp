/// The radio of a PC: a UDP socket that sends to 127.0.0.1:PORT first, then to the last sender.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>

namespace hypertuna::firmware {

struct UdpRadio {
    int line = -1;  // socket; -1 until opened: nothing is received, and what is sent is lost
    sockaddr_in peer{};

    bool open(int port) {
        line = ::socket(AF_INET, SOCK_DGRAM, 0);
        peer.sin_family = AF_INET, peer.sin_port = htons(std::uint16_t(port));
        return line >= 0 && ::inet_pton(AF_INET, "127.0.0.1", &peer.sin_addr) == 1;
    }
    /// Receive complete datagrams; those that do not fit are returned by the next call.
    int receive(std::uint8_t* to, int limit) {
        int count = 0;
        while (line >= 0 && count < limit) {
            sockaddr_in from{};
            socklen_t length = sizeof from;
            auto* at = reinterpret_cast<sockaddr*>(&from);
            const ssize_t waiting = ::recvfrom(line, to, 0, MSG_DONTWAIT | MSG_PEEK | MSG_TRUNC, at, &length);
            if (waiting < 0 || (count > 0 && limit - count < waiting)) break;
            length = sizeof from;
            const ssize_t got = ::recvfrom(line, to + count, std::size_t(limit - count), MSG_DONTWAIT, at, &length);
            if (got < 0) break;
            count += int(got), peer = from;
        }
        return count;
    }
    int send(const std::uint8_t* from, int count) {
        if (line >= 0) ::sendto(line, from, std::size_t(count), 0, reinterpret_cast<sockaddr*>(&peer), sizeof peer);
        return count;
    }
};

}  // namespace hypertuna::firmware
