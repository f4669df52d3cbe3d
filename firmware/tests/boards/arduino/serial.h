/// Serial ports: an interrupt puts bytes at the device's rate into a ring of 64 bytes plus the memory that the port was
/// given. Bytes without space are lost; while interrupts are off, all but four; at another rate, all.
#pragma once

struct HardwareSerialIMXRT {
    std::deque<std::pair<std::uint64_t, std::uint8_t>> line;  // bytes on their way: time of arrival, byte
    std::deque<std::uint8_t> ring;
    std::vector<std::uint8_t> out;
    std::vector<std::uint32_t> rates;  // rates of every begin()
    std::size_t room = 64, room_out = 40;
    std::uint32_t lost = 0, device = 0;  // lost bytes; rate of the device, 0 for the rate of the port

    void begin(std::uint32_t baud) { rates.push_back(baud); }
    void flush() {}
    void addMemoryForRead(void*, std::size_t bytes) { room = 64 + bytes, ring.clear(); }
    void addMemoryForWrite(void*, std::size_t bytes) { room_out = 40 + bytes; }
    int available() {
        for (; !line.empty() && line.front().first <= stand_in::now_us; line.pop_front()) {
            if (ring.size() < room)
                ring.push_back(line.front().second);
            else
                ++lost;
        }
        return int(ring.size());
    }
    int read() {
        const int byte = ring.front();
        ring.pop_front();
        return byte;
    }
    int availableForWrite() { return int(room_out) - 1; }
    std::size_t write(const std::uint8_t* from, std::size_t count) {
        out.insert(out.end(), from, from + count);
        return count;
    }

    /// Put bytes onto the line, behind those already there. A port receives nothing before it has a rate.
    void come(const std::uint8_t* bytes, std::size_t count) {
        if (rates.empty() || (device != 0 && device != rates.back())) return;
        std::uint64_t at = std::max(stand_in::now_us, line.empty() ? 0 : line.back().first);
        for (std::size_t k = 0; k < count; ++k) line.push_back({at += 10'000'000 / rates.back(), bytes[k]});
    }
    void lose(std::uint64_t from, std::uint64_t to) {
        int arrived = 0;
        std::erase_if(line, [&](const auto& byte) {
            const bool gone = from < byte.first && byte.first <= to && ++arrived > 4;
            lost += gone;
            return gone;
        });
    }
};
inline HardwareSerialIMXRT Serial1, Serial2, Serial3, Serial4, Serial5, Serial6, Serial7, Serial8;

namespace stand_in {

/// Work with interrupts off: micros() misses all of that time but the last millisecond, and rings lose most bytes.
inline void without_interrupts(std::uint32_t us) {
    HardwareSerialIMXRT* const ports[] = {&Serial1, &Serial2, &Serial3, &Serial4,
                                          &Serial5, &Serial6, &Serial7, &Serial8};
    for (HardwareSerialIMXRT* port : ports) port->available();
    const std::uint64_t from = now_us;
    pass(us);
    lost_us += us < 1000 ? 0 : us - 1000;
    for (HardwareSerialIMXRT* port : ports) port->lose(from, now_us);
}

}  // namespace stand_in
