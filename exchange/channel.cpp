#include "exchange/channel.hpp"

namespace talik::exchange {

void Channel::send(const Frame& frame) {
    const FrameHeader header = seal(frame, checksums_);
    write(std::as_bytes(std::span(&header, 1)));
    write(frame.payload);
    flush();
}

bool Channel::try_send(const Frame& frame) {
    if (room() < sizeof(FrameHeader) + frame.payload.size()) return false;
    send(frame);
    return true;
}

void Channel::receive(Frame& frame) {
    FrameHeader header;
    read(std::as_writable_bytes(std::span(&header, 1)));
    check_header(header);
    frame.type = static_cast<FrameType>(header.type);
    frame.layout_hash = header.layout_hash;
    frame.step = header.step;
    frame.payload.resize(header.payload_bytes);
    read(frame.payload);
    check_payload(header, frame);
}

bool Channel::try_receive(Frame& frame) {
    if (available() < sizeof(FrameHeader)) return false;
    receive(frame);
    return true;
}

std::string Channel::fate() const {
    if (!fate_) return {};
    return fate_().value_or(std::string());
}

} // namespace talik::exchange
