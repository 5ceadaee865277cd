#pragma once
// Several farms that answer as one. Each owns a share of the RVEs, under ids of its own from 0 on; no answer depends on the
// shares. A farm that is lost can be replaced: another one is set up alike, restored from the last confirmed checkpoint,
// asked again what was asked since (journal.hpp), and the run goes on with the same bits.
#include <filesystem>
#include <memory>

#include "common/base/error.hpp"
#include "exchange/driver_end.hpp"
#include "exchange/journal.hpp"

namespace talik::exchange {

// How farms are replaced. Without `another`, a lost farm ends the run.
struct Replacement {
    int at_most = 0;                            // farms in a run
    std::function<Channel&(int farm)> another;  // ends what is left of the old one, and starts or awaits a new one
    std::filesystem::path folder;               // for the farms' checkpoints in between
    double interval = 60.0;                     // s of wall time between those: the work that a lost farm can cost
};

class FarmGroup {
public:
    FarmGroup(Channel& only) : FarmGroup(std::vector<Channel*>{&only}) {}
    explicit FarmGroup(const std::vector<Channel*>& channels);

    void replace_lost_farms(Replacement how);

    const Hello& connect(const Hello& hello);
    // setup: the payload for the farm that owns these RVEs. Returns what each farm has to say.
    using Setup = std::function<std::vector<std::byte>(std::span<const std::uint32_t> rves)>;
    const std::vector<std::vector<std::byte>>& configure(int rve_count, Setup setup);

    // A step of `rves`, any of them in any order. fill: the columns of a chunk whose row i is row rows[i] of `rves`; it may be
    // called until finish_step() has returned.
    using Fill = std::function<void(std::span<const std::uint32_t> rows, Batch& chunk)>;
    void begin_step(const StepClock& clock, std::span<const std::uint32_t> rves, const Fill& fill);
    void finish_step();
    // Then: the answers, farm by farm.
    int farms() const { return static_cast<int>(members_.size()); }
    const Batch& answer(int farm) const { return members_[static_cast<std::size_t>(farm)]->answer; }
    std::span<const std::uint32_t> rves(int farm) const { return members_[static_cast<std::size_t>(farm)]->rves; } // by the farm's own ids

    std::vector<std::vector<std::byte>> command(const std::string& name); // that changes nothing, of each farm
    void command_rves(const std::string& name, std::span<const std::uint32_t> rves); // to the farms of these, with their ids as an array
    // Files farm.h5, farm-1.h5, ... in `folder`; restore() takes them from any number of farms.
    void checkpoint(const std::filesystem::path& folder);
    void restore(const std::filesystem::path& folder);
    void bye();

    // Between two steps: a checkpoint of the farms alone where one is due, so that a lost farm costs no more than the
    // interval. Then also: RVEs change hands where the farms' measured work says that it pays.
    void keep_up();

    int replaced() const { return replaced_; }
    int moves() const { return moves_; } // times that RVEs changed hands
    double seconds_lost() const { return seconds_lost_; } // with farms that were lost, until the work stood where it had stood
    double waiting_seconds() const;

private:
    using Clock = std::chrono::steady_clock;
    struct Member {
        int index = 0;
        Channel* channel = nullptr;
        std::unique_ptr<DriverEnd> end;
        std::vector<std::uint32_t> rves;       // global ids, by local id
        Journal journal;
        Batch answer, scratch;
        std::vector<std::uint32_t> rows, ids;  // of the step under way: row of the step, local id
        std::size_t sent = 0;
        bool chunk_ready = false, finished = true;
        FrameType question = FrameType::bye;   // the one under way
        std::vector<std::byte> payload;
        bool asked = false;
    };

    void share_out(const std::vector<double>& costs);
    void make_batches(Member& member);
    void begin(Member& member);
    bool push(Member& member); // whether anything could be sent
    void tend(const Member& awaited); // the other farms, while one is waited for
    using Payload = std::function<std::optional<std::vector<std::byte>>(const Member&)>; // nothing: this one is not asked
    void ask_all(FrameType question, const Payload& payload, std::vector<std::vector<std::byte>>& replies);
    template <class Act>
    void guard(Member& member, Act act);
    void revive(Member& member, Error lost);
    void bring_up(Member& member);
    void write_files(const std::filesystem::path& folder);
    std::filesystem::path next_base() const;
    void link_as_base(const std::filesystem::path& folder);
    void take_as_base(const std::filesystem::path& base); // replacements start from it
    void remove_bases();
    void rebalance(const std::filesystem::path& folder);

    std::vector<std::unique_ptr<Member>> members_;
    std::vector<std::uint32_t> owner_, local_; // by global id
    Hello hello_, farm_hello_;
    Setup setup_;
    std::vector<std::vector<std::byte>> said_;

    StepClock clock_;
    const Fill* fill_ = nullptr;
    bool in_step_ = false;
    Clock::time_point last_tended_;

    Replacement replacement_;
    std::filesystem::path base_;      // empty: replacements start from the set-up
    Clock::time_point base_time_ = Clock::now();
    int replaced_ = 0, moves_ = 0;
    bool reviving_ = false, leaving_ = false; // leaving: farms that have said bye may go
    double seconds_lost_ = 0.0, setup_seconds_ = 0.0;
    std::optional<double> move_seconds_; // of the last time RVEs changed hands
    double waited_for_lost_ = 0.0; // s, at channels that are gone
    std::uint64_t ticks_ = 0;
};

// Shares of RVEs in the order of their ids, each about equally costly: begins[k] is the first of farm k, begins[farms] the end.
std::vector<std::uint32_t> equal_shares(std::span<const double> costs, int farms);

} // namespace talik::exchange
