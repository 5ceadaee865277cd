// Farms that take over: from the last checkpoint, by asking again, to the present.
#include <algorithm>
#include <fmt/format.h>

#include "common/base/log.hpp"
#include "common/io/byte_stream.hpp"
#include "exchange/farm_group_guard.hpp"

namespace talik::exchange {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_journal_bytes = std::size_t(1) << 30; // of all farms: then a checkpoint is due, whatever the clock says

std::string file_name(int farm) { return farm == 0 ? "farm.h5" : fmt::format("farm-{}.h5", farm); }

// farm.h5, farm-1.h5, ..., and what a farm of another making keeps beside it.
std::vector<fs::path> files_of_farms(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().filename().string().starts_with("farm") && entry.path().extension() != ".part") files.push_back(entry.path());
    return files;
}

void link_or_copy(const fs::path& from, const fs::path& to) {
    std::error_code other_device;
    fs::create_hard_link(from, to, other_device);
    if (other_device) fs::copy_file(from, to);
}

// What a farm restores from: the one file, or the folder where several farms wrote one each.
std::vector<std::byte> encode_source(const fs::path& folder) {
    const auto files = files_of_farms(folder);
    const bool several = std::count_if(files.begin(), files.end(), [](const fs::path& file) { return file.extension() == ".h5"; }) > 1;
    return encode_path((several ? fs::absolute(folder) : fs::absolute(folder) / file_name(0)).string());
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

} // namespace

void FarmGroup::replace_lost_farms(Replacement how) {
    replacement_ = std::move(how);
    remove_bases(); // of a run that was killed
}

void FarmGroup::remove_bases() {
    std::error_code ignored;
    if (!replacement_.folder.empty()) fs::remove_all(replacement_.folder, ignored);
    base_.clear();
}

void FarmGroup::revive(Member& member, Error lost) {
    const auto begin = Clock::now();
    reviving_ = true;
    for (;;) {
        if (replaced_ >= replacement_.at_most || !replacement_.another) {
            reviving_ = false;
            throw lost;
        }
        ++replaced_;
        log::warn("{}: another farm takes over ({} of at most {} in this run)", lost.problem(), replaced_, replacement_.at_most);
        try {
            member.end.reset();
            waited_for_lost_ += member.channel->waiting_seconds();
            member.channel = &replacement_.another(member.index);
            bring_up(member);
            break;
        } catch (const Error& again) {
            reviving_ = again.code() == ExitCode::partner_lost && !interrupted();
            if (!reviving_) throw;
            lost = again;
        }
    }
    reviving_ = false;
    const double seconds = seconds_since(begin);
    seconds_lost_ += seconds;
    log::info("the farm that took over stands where the lost one stood: {} step(s) asked again, {:.2f} s", member.journal.steps(), seconds);
}

// From nothing to where the lost farm stood.
void FarmGroup::bring_up(Member& member) {
    ++hello_.epoch; // what the lost farm may still send is not mistaken for an answer
    member.end = std::make_unique<DriverEnd>(*member.channel);
    farm_hello_ = member.end->connect(hello_);
    if (!setup_) return; // it was lost before the set-up
    const auto settle = [&](FrameType question, std::vector<std::byte> payload) {
        member.end->post(question, std::move(payload));
        for (;;) {
            if (auto reply = member.end->try_reply()) return *reply;
            member.channel->await();
            tend(member);
        }
    };
    auto said = settle(FrameType::configure, setup_(member.rves));
    if (member.asked && member.question == FrameType::configure) {
        said_[static_cast<std::size_t>(member.index)] = std::move(said);
        member.asked = false;
        return;
    }
    if (!base_.empty()) settle(FrameType::restore, encode_source(base_));
    member.journal.drop_step();
    member.journal.replay(*member.end, member.scratch, [&] { tend(member); });
    if (in_step_ && !member.finished) begin(member);
    if (member.asked) member.end->post(member.question, member.payload);
}

void FarmGroup::checkpoint(const fs::path& folder) {
    write_files(folder);
    if (replacement_.at_most > 0) link_as_base(folder);
    rebalance(folder);
}

void FarmGroup::write_files(const fs::path& folder) {
    const fs::path whole = fs::absolute(folder);
    std::vector<std::vector<std::byte>> replies;
    ask_all(FrameType::checkpoint, [&](const Member& member) { return encode_path((whole / file_name(member.index)).string()); }, replies);
}

void FarmGroup::restore(const fs::path& folder) {
    std::vector<std::vector<std::byte>> replies;
    ask_all(FrameType::restore, [&](const Member&) { return encode_source(folder); }, replies);
    if (replacement_.at_most > 0) link_as_base(folder);
}

// The checkpoint itself may be removed as the run goes on.
void FarmGroup::link_as_base(const fs::path& folder) {
    const fs::path base = next_base();
    for (const fs::path& file : files_of_farms(folder)) link_or_copy(file, base / file.filename());
    take_as_base(base);
}

void FarmGroup::keep_up() {
    if (replacement_.at_most == 0) return;
    std::size_t bytes = 0;
    for (const auto& member : members_) bytes += member->journal.bytes();
    if (seconds_since(base_time_) < replacement_.interval && bytes < most_journal_bytes) return;
    const fs::path base = next_base();
    write_files(base);
    take_as_base(base);
    rebalance(base);
}

// Two folders in turn: the one before stays good until every farm has confirmed the next.
fs::path FarmGroup::next_base() const {
    const fs::path next = fs::absolute(replacement_.folder) / (base_.filename() == "a" ? "b" : "a");
    fs::remove_all(next);
    fs::create_directories(next);
    return next;
}

void FarmGroup::take_as_base(const fs::path& base) {
    base_ = base;
    base_time_ = Clock::now();
    for (const auto& member : members_) member->journal.clear();
}

// The checkpoint in `folder` is of this moment: RVEs can change hands through it. It pays where what the slowest farm is
// behind the mean, over the time since the last look, is more than the move will take.
void FarmGroup::rebalance(const fs::path& folder) {
    if (farms() == 1 || !farm_hello_.program.starts_with("rve-farm")) return; // another farm need not know the command
    std::vector<double> costs(owner_.size());
    double total = 0.0, most = 0.0;
    const auto replies = command("costs"); // s of each RVE since they were last asked for
    for (const auto& member : members_) {
        ByteReader in(replies[static_cast<std::size_t>(member->index)], "the answer to \"costs\"");
        const auto own = in.array<double>();
        require(own.size() == member->rves.size(), "a farm tells the costs of RVEs that it does not have", "use mpm-driver and rve-farm of one version");
        double load = 0.0;
        for (std::size_t i = 0; i < own.size(); ++i) costs[member->rves[i]] = own[i], load += own[i];
        total += load;
        most = std::max(most, load);
    }
    const double mean = total / farms(), gain = most - mean;
    if (!(gain > move_seconds_.value_or(2.0 * setup_seconds_)) || gain < 0.05 * mean) return;
    const auto begin = Clock::now();
    share_out(costs);
    std::vector<std::vector<std::byte>> replies_of_restore;
    ask_all(FrameType::configure, [this](const Member& member) { return setup_(member.rves); }, said_);
    ask_all(FrameType::restore, [&](const Member&) { return encode_source(folder); }, replies_of_restore);
    for (const auto& member : members_) make_batches(*member);
    move_seconds_ = seconds_since(begin);
    ++moves_;
    log::info("RVEs changed hands in {:.2f} s: the slowest farm had worked {:.2f} s, the mean of {} was {:.2f} s", *move_seconds_, most, farms(), mean);
}

} // namespace talik::exchange
