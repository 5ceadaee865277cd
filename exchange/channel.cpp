#include "exchange/channel.hpp"

#include <algorithm>

#include "common/base/interrupt.hpp"
#include "common/base/stage_timer.hpp"

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

void Channel::wait(const Ready& ready) {
    if (ready()) return;
    const StageTimer::Scope timing(waiting_seconds_);
    if (spin(ready)) return;
    Patience patience(role_, limits_);
    while (!sleep_once(ready, Patience::look_interval, patience)) {}
}

bool Channel::sleep_once(const Ready& ready, std::chrono::milliseconds longest, Patience& patience) {
    nap(ready, longest);
    if (ready()) return true;
    const PartnerView view = look();
    if (ready()) return true; // what it sent before it ended counts
    if (interrupted()) wish_to_end();
    patience.judge(view);
    return false;
}

bool Channel::await(std::chrono::milliseconds longest) {
    const Ready ready = [this] { return available() > 0; };
    if (!ready()) {
        const StageTimer::Scope timing(waiting_seconds_);
        const bool fresh = !awaiting_;
        if (fresh) awaiting_.emplace(role_, limits_);
        if (!(fresh && spin(ready)) && !sleep_once(ready, std::min(longest, Patience::look_interval), *awaiting_)) return false;
    }
    awaiting_.reset();
    return true;
}

void Channel::look_after() { Patience(role_, limits_).judge(look()); }

std::string Channel::fate() const {
    if (!fate_) return {};
    return fate_().value_or(std::string());
}

} // namespace talik::exchange
