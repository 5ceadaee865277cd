#include "exchange/mpi_channel.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <deque>
#include <fmt/format.h>
#include <thread>

#include "common/base/error.hpp"
#include "exchange/mpi_world.hpp"

namespace talik::exchange {
namespace {

using mpi::World;

constexpr std::size_t job_capacity = std::size_t(4) << 20; // bytes under way each way before the writer waits
constexpr std::size_t most_at_once = std::size_t(64) << 20; // MPI counts in int
constexpr std::chrono::microseconds spin_time{10}, shortest_nap{5}, longest_nap{500};
constexpr std::chrono::milliseconds between_standings{100};

// How a side stands: sent beside the frames.
struct Standing {
    std::uint64_t taken = 0; // bytes of the partner's that were read: room for more
    std::uint64_t done = 0, total = 0, beats = 0;
    std::uint32_t wishes_to_end = 0, left = 0;
    char cause[400] = {};
};

int frame_tag(Role sender) { return 10 + static_cast<int>(sender); }
int standing_tag(Role sender) { return 20 + static_cast<int>(sender); }

// Buffers that MPI reads from until it is done with them; they are used again and again.
class Outbox {
public:
    std::vector<std::byte>& next() {
        for (std::size_t i = 0; i < requests_.size(); ++i) {
            int done = 1;
            if (requests_[i] != MPI_REQUEST_NULL) MPI_Test(&requests_[i], &done, MPI_STATUS_IGNORE);
            if (done) return buffers_[latest_ = i];
        }
        requests_.push_back(MPI_REQUEST_NULL);
        buffers_.emplace_back();
        return buffers_[latest_ = buffers_.size() - 1];
    }
    void send(int to, int tag, MPI_Comm comm) {
        MPI_Isend(buffers_[latest_].data(), static_cast<int>(buffers_[latest_].size()), MPI_BYTE, to, tag, comm, &requests_[latest_]);
    }
    bool empty() {
        bool all = true;
        for (MPI_Request& request : requests_) {
            int done = 1;
            if (request != MPI_REQUEST_NULL) MPI_Test(&request, &done, MPI_STATUS_IGNORE);
            all = all && done;
        }
        return all;
    }

private:
    std::deque<std::vector<std::byte>> buffers_; // their places do not move
    std::deque<MPI_Request> requests_;
    std::size_t latest_ = 0;
};

class MpiChannel final : public Channel {
public:
    MpiChannel(std::shared_ptr<World> world, Role self, int peer, std::size_t capacity, const WaitLimits& wait_limits)
        : Channel(self, wait_limits), world_(std::move(world)), peer_(peer), capacity_(capacity) {
        use_checksums(true);
        const mpi::Rank& partner = world_->rank(peer);
        near_ = partner.machine == mpi::this_machine() && in_this_pid_namespace(partner.process);
        if (near_) watch_ = ProcessWatch(partner.process, -1, 0);
    }
    ~MpiChannel() override {
        const std::lock_guard lock(world_->mutex());
        own_.left = 1;
        send_standing();
        for (int i = 0; i < 200 && !outbox_.empty(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1)); // a lost partner takes nothing
    }

    void advance_progress(std::uint64_t done, std::uint64_t total) noexcept override {
        done_ = done, total_ = total, ++beats_;
        const auto now = Clock::now().time_since_epoch().count();
        auto told = told_.load();
        if (now - told < Clock::duration(between_standings).count() || !told_.compare_exchange_strong(told, now)) return;
        const std::unique_lock lock(world_->mutex(), std::try_to_lock);
        if (lock) send_standing();
    }
    PartnerProgress partner_progress() const override {
        const std::lock_guard lock(world_->mutex());
        pump();
        return {partner_.done, partner_.total};
    }
    void state_cause(const std::string& cause) noexcept override {
        const std::lock_guard lock(world_->mutex());
        if (own_.cause[0] != '\0') return;
        std::strncpy(own_.cause, cause.c_str(), sizeof own_.cause - 1);
        std::replace(std::begin(own_.cause), std::end(own_.cause), '\n', ' ');
        send_standing();
    }
    std::string partner_cause() const override {
        const std::lock_guard lock(world_->mutex());
        pump();
        return partner_.cause;
    }
    void wish_to_end() noexcept override {
        const std::lock_guard lock(world_->mutex());
        if (own_.wishes_to_end != 0) return;
        own_.wishes_to_end = 1;
        send_standing();
    }
    bool partner_wishes_to_end() const noexcept override {
        const std::lock_guard lock(world_->mutex());
        pump();
        return partner_.wishes_to_end != 0;
    }

protected:
    std::size_t room() const override {
        const std::lock_guard lock(world_->mutex());
        pump();
        return capacity_ - std::min(capacity_, static_cast<std::size_t>(sent_ - partner_.taken));
    }
    std::size_t available() const override {
        const std::lock_guard lock(world_->mutex());
        if (arrived_ == taken_) pump();
        return static_cast<std::size_t>(arrived_ - taken_);
    }
    void write(std::span<const std::byte> bytes) override { outgoing_.insert(outgoing_.end(), bytes.begin(), bytes.end()); }
    void flush() override {
        wait([this] { // a frame larger than the room goes alone
            const std::size_t free = room();
            return free >= outgoing_.size() || free == capacity_;
        });
        const std::lock_guard lock(world_->mutex());
        if (own_.beats != beats_) send_standing(); // progress comes before the answer it led to
        for (std::size_t begin = 0; begin < outgoing_.size(); begin += most_at_once) {
            const auto piece = std::span(outgoing_).subspan(begin, std::min(most_at_once, outgoing_.size() - begin));
            outbox_.next().assign(piece.begin(), piece.end());
            outbox_.send(peer_, frame_tag(role()), world_->comm());
        }
        sent_ += outgoing_.size();
        outgoing_.clear();
    }
    void read(std::span<std::byte> bytes) override {
        while (!bytes.empty()) {
            wait([this] { return available() > 0; });
            const std::lock_guard lock(world_->mutex());
            std::vector<std::byte>& first = inbox_.front();
            const std::size_t n = std::min(bytes.size(), first.size() - at_);
            std::memcpy(bytes.data(), first.data() + at_, n);
            at_ += n;
            taken_ += n;
            bytes = bytes.subspan(n);
            if (at_ == first.size()) {
                spare_.push_back(std::move(first));
                inbox_.pop_front();
                at_ = 0;
            }
            if (taken_ - own_.taken >= capacity_ / 4) send_standing();
        }
    }
    // MPI can only be asked: less and less often.
    void nap(const Ready& ready, std::chrono::milliseconds longest) override {
        {
            const std::lock_guard lock(world_->mutex());
            if (taken_ != own_.taken) send_standing();
        }
        std::chrono::microseconds pause = shortest_nap, slept{0};
        do {
            std::this_thread::sleep_for(pause);
            slept += pause;
            pause = std::min(2 * pause, longest_nap);
        } while (!ready() && slept < longest);
    }
    bool spin(const Ready& ready) override {
        const auto end = Clock::now() + spin_time;
        do
            if (ready()) return true;
        while (Clock::now() < end);
        return false;
    }
    PartnerView look() override {
        PartnerView view;
        view.process_alive = !near_ || watch_.alive(); // on another machine it is the launcher that tells
        const std::lock_guard lock(world_->mutex());
        pump();
        view.presence = partner_.left != 0 ? PartnerView::Presence::left : PartnerView::Presence::attached;
        view.movement = partner_.beats + partner_.done + partner_.taken + arrived_;
        view.progress = {partner_.done, partner_.total};
        view.cause = partner_.cause;
        view.pid = world_->rank(peer_).process.pid;
        if (near_) view.process_state = process_state(view.pid);
        return view;
    }

private:
    using Clock = std::chrono::steady_clock;

    void send_standing() const { // the lock is held
        own_.taken = taken_;
        own_.done = done_, own_.total = total_, own_.beats = beats_;
        const auto bytes = std::as_bytes(std::span(&own_, 1));
        outbox_.next().assign(bytes.begin(), bytes.end());
        outbox_.send(peer_, standing_tag(role()), world_->comm());
    }

    // Takes what has come; the lock is held.
    void pump() const {
        const Role partner = partner_of(role());
        MPI_Status status;
        int there = 0, size = 0;
        for (MPI_Iprobe(peer_, standing_tag(partner), world_->comm(), &there, &status); there; MPI_Iprobe(peer_, standing_tag(partner), world_->comm(), &there, &status))
            MPI_Recv(&partner_, sizeof partner_, MPI_BYTE, peer_, standing_tag(partner), world_->comm(), MPI_STATUS_IGNORE);
        for (MPI_Iprobe(peer_, frame_tag(partner), world_->comm(), &there, &status); there; MPI_Iprobe(peer_, frame_tag(partner), world_->comm(), &there, &status)) {
            MPI_Get_count(&status, MPI_BYTE, &size);
            std::vector<std::byte> bytes;
            if (!spare_.empty()) bytes = std::move(spare_.back()), spare_.pop_back();
            bytes.resize(static_cast<std::size_t>(size));
            MPI_Recv(bytes.data(), size, MPI_BYTE, peer_, frame_tag(partner), world_->comm(), MPI_STATUS_IGNORE);
            arrived_ += bytes.size();
            if (size > 0) inbox_.push_back(std::move(bytes));
        }
    }

    std::shared_ptr<World> world_;
    int peer_;
    std::size_t capacity_;
    bool near_ = false; // the partner is a process that can be looked at
    ProcessWatch watch_;

    // Under the lock of the world.
    mutable Outbox outbox_;
    mutable Standing own_, partner_;
    mutable std::deque<std::vector<std::byte>> inbox_;
    mutable std::vector<std::vector<std::byte>> spare_;
    std::size_t at_ = 0; // in the first of the inbox
    std::uint64_t sent_ = 0, taken_ = 0;
    mutable std::uint64_t arrived_ = 0;
    std::vector<std::byte> outgoing_;

    std::atomic<std::uint64_t> done_{0}, total_{0}, beats_{0};
    std::atomic<Clock::rep> told_{0};
};

} // namespace

bool built_with_mpi() { return true; }

void begin_mpi(Role role) { World::job()->begin(role); }

std::vector<std::unique_ptr<Channel>> make_mpi_channels(int farms, const WaitLimits& limits) {
    const auto world = World::job();
    const std::vector<int> there = world->farms();
    require(farms == 0 || farms == static_cast<int>(there.size()), fmt::format("--farms {}: this MPI job has {}", farms, there.size()), "leave --farms out: it is mpirun that says how many");
    std::vector<std::unique_ptr<Channel>> channels;
    for (const int rank : there) channels.push_back(std::make_unique<MpiChannel>(world, Role::driver, rank, job_capacity, limits));
    return channels;
}

std::unique_ptr<Channel> join_mpi_channel(const WaitLimits& limits) {
    const auto world = World::job();
    return std::make_unique<MpiChannel>(world, Role::farm, world->driver(), job_capacity, limits);
}

void end_mpi(bool in_order) noexcept { World::job()->end(in_order ? 10.0 : 1.0); }

std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> mpi_pair(std::size_t capacity, const WaitLimits& limits) {
    const auto world = World::self();
    return {std::make_unique<MpiChannel>(world, Role::driver, 0, capacity, limits), std::make_unique<MpiChannel>(world, Role::farm, 0, capacity, limits)};
}

} // namespace talik::exchange
