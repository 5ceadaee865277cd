#include "exchange/shm_channel.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "common/base/error.hpp"
#include "exchange/futex.hpp"
#include "exchange/shm_segment.hpp"

namespace talik::exchange {
namespace {

constexpr std::chrono::microseconds spin_time{8}; // a futex wake costs about as much: longer spinning only burns

class ShmChannel final : public Channel {
public:
    ShmChannel(Role self, const WaitLimits& wait_limits, SharedSegment&& segment)
        : Channel(self, wait_limits), segment_(std::move(segment)), mask_(segment_->ring_bytes - 1),
          written_(out().written), taken_(in().taken) {}

    ~ShmChannel() override {
        own().presence = shm::Presence::left;
        wake_partner();
    }

    void advance_progress(std::uint64_t done, std::uint64_t total) noexcept override {
        own().done.store(done, std::memory_order_relaxed);
        own().total.store(total, std::memory_order_relaxed);
        own().beats.fetch_add(1, std::memory_order_relaxed);
    }
    PartnerProgress partner_progress() const override { return {partner().done.load(), partner().total.load()}; }

    void state_cause(const std::string& cause) noexcept override {
        std::uint32_t none = 0;
        if (!own().cause_state.compare_exchange_strong(none, 1)) return; // the first cause stays
        const std::size_t size = std::min(cause.size(), sizeof own().cause - 1);
        std::memcpy(own().cause, cause.data(), size);
        std::replace(own().cause, own().cause + size, '\n', ' ');
        own().cause[size] = '\0';
        own().cause_state = 2;
        wake_partner();
    }
    void wish_to_end() noexcept override { own().wishes_to_end = 1; }
    std::string partner_cause() const override { return partner().cause_state == 2 ? std::string(partner().cause) : std::string(); }
    bool partner_wishes_to_end() const noexcept override { return partner().wishes_to_end != 0; }

protected:
    std::size_t room() const override {
        return static_cast<std::size_t>(segment_->ring_bytes - sound(written_ - out().taken.load()));
    }
    std::size_t available() const override { return static_cast<std::size_t>(sound(in().written.load() - taken_)); }

    void write(std::span<const std::byte> bytes) override {
        std::byte* ring = segment_.ring_data(static_cast<int>(role()));
        while (!bytes.empty()) {
            if (room() == 0) {
                flush();
                wait([this] { return room() > 0; });
            }
            const auto at = static_cast<std::size_t>(written_ & mask_);
            const std::size_t n = std::min({bytes.size(), room(), static_cast<std::size_t>(segment_->ring_bytes) - at});
            std::memcpy(ring + at, bytes.data(), n);
            written_ += n;
            bytes = bytes.subspan(n);
        }
    }

    void flush() override {
        out().written.store(written_); // sequentially consistent, before the look at `sleeping`: see wait()
        if (partner().sleeping.load() != 0) wake_partner();
    }

    void read(std::span<std::byte> bytes) override {
        const std::byte* ring = segment_.ring_data(static_cast<int>(partner_of(role())));
        while (!bytes.empty()) {
            wait([this] { return available() > 0; });
            const auto at = static_cast<std::size_t>(taken_ & mask_);
            const std::size_t n = std::min({bytes.size(), available(), static_cast<std::size_t>(segment_->ring_bytes) - at});
            std::memcpy(bytes.data(), ring + at, n);
            taken_ += n;
            bytes = bytes.subspan(n);
            in().taken.store(taken_);
            if (partner().sleeping.load() != 0) wake_partner();
        }
    }

    // No wake-up is lost: this side stores `sleeping` and then looks once more; the partner stores its counter and then
    // looks at `sleeping`. In the one order of sequentially consistent operations, one of the two sees the other; and the
    // doorbell, rung between our reading it and falling asleep, keeps us awake.
    void nap(const Ready& ready, std::chrono::milliseconds longest) override {
        own().sleeping = 1;
        const std::uint32_t ticket = own().doorbell;
        if (!ready()) futex_wait(own().doorbell, ticket, longest);
        own().sleeping = 0;
    }

    bool spin(const Ready& ready) override {
        const auto end = std::chrono::steady_clock::now() + spin_time;
        do {
            for (int i = 0; i < 16; ++i) cpu_pause();
            if (ready()) return true;
        } while (std::chrono::steady_clock::now() < end);
        return false;
    }

    PartnerView look() override {
        const shm::Side& side = partner();
        PartnerView view;
        const shm::Presence presence = side.presence;
        if (presence == shm::Presence::attached || presence == shm::Presence::left) {
            if (!watch_.watching()) meet_partner();
            view.presence = presence == shm::Presence::left ? PartnerView::Presence::left : PartnerView::Presence::attached;
            view.pid = side.process.pid;
            view.process_alive = watch_.alive();
            if (in_this_pid_namespace(side.process)) view.process_state = process_state(view.pid);
        } else if (segment_->preamble.refused != 0) {
            view.cause = std::string(segment_->preamble.refusal);
        }
        view.fate = fate(); // asked after the look at the process: a death that was seen can be told
        view.process_alive = view.process_alive && view.fate.empty();
        view.movement = side.beats.load() + side.done.load() + in().written.load() + out().taken.load();
        view.progress = partner_progress();
        if (side.cause_state == 2) view.cause = std::string(side.cause);
        return view;
    }

private:
    void wake_partner() noexcept {
        partner().doorbell.fetch_add(1);
        futex_wake(partner().doorbell);
    }

    void meet_partner() {
        watch_ = ProcessWatch(partner().process, segment_.file(), static_cast<int>(partner_of(role())));
        segment_.remove_name();
    }

    // What the partner wrote is checked before it is used to address memory.
    std::uint64_t sound(std::uint64_t filled) const {
        if (filled > segment_->ring_bytes)
            fail(ExitCode::partner_lost, "the partner sends nonsense: the counters of the ring are corrupted", "restart from the last checkpoint");
        return filled;
    }

    shm::Side& own() const { return segment_->side[static_cast<int>(role())]; }
    shm::Side& partner() const { return segment_->side[static_cast<int>(partner_of(role()))]; }
    shm::Ring& out() const { return segment_->ring[static_cast<int>(role())]; }
    shm::Ring& in() const { return segment_->ring[static_cast<int>(partner_of(role()))]; }

    SharedSegment segment_;
    std::uint64_t mask_;
    std::uint64_t written_, taken_; // this side's own counters, ahead of what is published
    ProcessWatch watch_;
};

} // namespace

namespace {

SharedSegment make_segment(const std::string& name, const ShmOptions& options) {
    return SharedSegment::create(name, std::bit_ceil(std::max<std::size_t>(options.ring_bytes, 4096)), options.free_bytes);
}

} // namespace

std::unique_ptr<Channel> make_shm_channel(const std::string& name, const WaitLimits& limits, const ShmOptions& options) {
    return std::make_unique<ShmChannel>(Role::driver, limits, make_segment(name, options));
}

std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> shm_channels_of_one_mapping(const std::string& name, const WaitLimits& limits, const ShmOptions& options) {
    SharedSegment made = make_segment(name, options), joined = SharedSegment::join_here(name, made);
    auto driver = std::make_unique<ShmChannel>(Role::driver, limits, std::move(made));
    return {std::move(driver), std::make_unique<ShmChannel>(Role::farm, limits, std::move(joined))};
}

std::unique_ptr<Channel> join_shm_channel(const std::string& name, const WaitLimits& limits) {
    auto channel = std::make_unique<ShmChannel>(Role::farm, limits, SharedSegment::join(name, limits));
    return channel;
}

} // namespace talik::exchange
