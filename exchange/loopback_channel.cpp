#include "exchange/loopback_channel.hpp"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <unistd.h>
#include <vector>

namespace talik::exchange {
namespace {

struct Side {
    bool left = false;
    std::string cause;
    PartnerProgress progress;
    std::uint64_t beats = 0; // counts everything that moves on this side
    bool wishes_to_end = false;
};

// A bounded queue of bytes: `written` and `taken` count from the start.
struct Pipe {
    std::vector<std::byte> bytes;
    std::size_t written = 0, taken = 0;
    std::size_t available() const { return written - taken; }
    std::size_t room() const { return bytes.size() - available(); }
};

struct Shared {
    std::mutex mutex;
    std::condition_variable changed;
    std::array<Side, 2> side;
    std::array<Pipe, 2> pipe; // [i] is written by role i
};

class LoopbackChannel final : public Channel {
public:
    LoopbackChannel(Role self, const WaitLimits& wait_limits, std::shared_ptr<Shared> shared)
        : Channel(self, wait_limits), shared_(std::move(shared)) {}
    ~LoopbackChannel() override {
        const std::lock_guard lock(shared_->mutex);
        own().left = true;
        shared_->changed.notify_all();
    }

    void advance_progress(std::uint64_t done, std::uint64_t total) noexcept override {
        const std::lock_guard lock(shared_->mutex);
        own().progress = {done, total};
        ++own().beats;
    }
    PartnerProgress partner_progress() const override {
        const std::lock_guard lock(shared_->mutex);
        return partner().progress;
    }
    void state_cause(const std::string& cause) noexcept override {
        const std::lock_guard lock(shared_->mutex);
        if (own().cause.empty()) own().cause = cause;
        shared_->changed.notify_all();
    }
    std::string partner_cause() const override {
        const std::lock_guard lock(shared_->mutex);
        return partner().cause;
    }
    void wish_to_end() noexcept override {
        const std::lock_guard lock(shared_->mutex);
        own().wishes_to_end = true;
    }
    bool partner_wishes_to_end() const noexcept override {
        const std::lock_guard lock(shared_->mutex);
        return partner().wishes_to_end;
    }

protected:
    std::size_t room() const override {
        const std::lock_guard lock(shared_->mutex);
        return out().room();
    }
    std::size_t available() const override {
        const std::lock_guard lock(shared_->mutex);
        return in().available();
    }
    void write(std::span<const std::byte> bytes) override {
        while (!bytes.empty()) {
            wait([this] { return room() > 0; });
            const std::lock_guard lock(shared_->mutex);
            const std::size_t n = std::min(bytes.size(), out().room());
            for (std::size_t i = 0; i < n; ++i) out().bytes[(out().written + i) % out().bytes.size()] = bytes[i];
            out().written += n;
            moved();
            bytes = bytes.subspan(n);
        }
    }
    void flush() override {}
    void read(std::span<std::byte> bytes) override {
        while (!bytes.empty()) {
            wait([this] { return available() > 0; });
            const std::lock_guard lock(shared_->mutex);
            const std::size_t n = std::min(bytes.size(), in().available());
            for (std::size_t i = 0; i < n; ++i) bytes[i] = in().bytes[(in().taken + i) % in().bytes.size()];
            in().taken += n;
            moved();
            bytes = bytes.subspan(n);
        }
    }
    void nap(const Ready& ready, std::chrono::milliseconds longest) override {
        const std::uint64_t before = beats();
        if (ready()) return;
        std::unique_lock lock(shared_->mutex);
        shared_->changed.wait_for(lock, longest, [&] { return partner().beats != before || partner().left; });
    }
    PartnerView look() override {
        const std::lock_guard lock(shared_->mutex);
        PartnerView view;
        view.presence = partner().left ? PartnerView::Presence::left : PartnerView::Presence::attached;
        view.movement = partner().beats;
        view.progress = partner().progress;
        view.cause = partner().cause;
        view.pid = static_cast<int>(getpid());
        return view;
    }

private:
    std::uint64_t beats() const {
        const std::lock_guard lock(shared_->mutex);
        return partner().beats;
    }
    void moved() {
        ++own().beats;
        shared_->changed.notify_all();
    }

    Side& own() const { return shared_->side[static_cast<std::size_t>(role())]; }
    Side& partner() const { return shared_->side[static_cast<std::size_t>(partner_of(role()))]; }
    Pipe& out() const { return shared_->pipe[static_cast<std::size_t>(role())]; }
    Pipe& in() const { return shared_->pipe[static_cast<std::size_t>(partner_of(role()))]; }

    std::shared_ptr<Shared> shared_;
};

} // namespace

std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> loopback_pair(std::size_t capacity, const WaitLimits& limits) {
    auto shared = std::make_shared<Shared>();
    for (Pipe& pipe : shared->pipe) pipe.bytes.resize(std::max<std::size_t>(capacity, 64));
    return {std::make_unique<LoopbackChannel>(Role::driver, limits, shared),
            std::make_unique<LoopbackChannel>(Role::farm, limits, shared)};
}

} // namespace talik::exchange
