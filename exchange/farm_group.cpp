#include "exchange/farm_group.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/io/byte_stream.hpp"
#include "exchange/farm_group_guard.hpp"

namespace talik::exchange {

FarmGroup::FarmGroup(const std::vector<Channel*>& channels) {
    ensure(!channels.empty());
    for (Channel* channel : channels) {
        members_.push_back(std::make_unique<Member>());
        members_.back()->index = farms() - 1;
        members_.back()->channel = channel;
    }
}

const Hello& FarmGroup::connect(const Hello& hello) {
    hello_ = hello;
    for (const auto& member : members_)
        guard(*member, [&] {
            member->end = std::make_unique<DriverEnd>(*member->channel);
            farm_hello_ = member->end->connect(hello_);
        });
    return farm_hello_;
}

const std::vector<std::vector<std::byte>>& FarmGroup::configure(int rve_count, Setup setup) {
    setup_ = std::move(setup);
    share_out(std::vector<double>(static_cast<std::size_t>(rve_count), 1.0)); // nothing is measured yet
    const auto begin = Clock::now();
    ask_all(FrameType::configure, [this](const Member& member) { return setup_(member.rves); }, said_);
    setup_seconds_ = std::chrono::duration<double>(Clock::now() - begin).count();
    for (const auto& member : members_) make_batches(*member);
    return said_;
}

void FarmGroup::share_out(const std::vector<double>& costs) {
    const auto begins = equal_shares(costs, farms());
    owner_.resize(costs.size());
    local_.resize(costs.size());
    for (const auto& member : members_) {
        const auto k = static_cast<std::size_t>(member->index);
        member->rves.clear();
        for (std::uint32_t rve = begins[k]; rve < begins[k + 1]; ++rve) {
            owner_[rve] = static_cast<std::uint32_t>(k);
            local_[rve] = rve - begins[k];
            member->rves.push_back(rve);
        }
    }
}

void FarmGroup::make_batches(Member& member) {
    member.answer = member.end->make_answer(static_cast<int>(member.rves.size()));
    if (replacement_.at_most > 0) member.scratch = member.answer;
    member.rows.reserve(member.rves.size());
    member.ids.reserve(member.rves.size());
}

void FarmGroup::begin_step(const StepClock& clock, std::span<const std::uint32_t> rves, const Fill& fill) {
    ensure(!in_step_);
    clock_ = clock;
    fill_ = &fill;
    in_step_ = true;
    for (const auto& member : members_) member->rows.clear(), member->ids.clear();
    for (std::uint32_t row = 0; row < rves.size(); ++row) {
        Member& member = *members_[owner_[rves[row]]];
        member.rows.push_back(row);
        member.ids.push_back(local_[rves[row]]);
    }
    for (const auto& member : members_) begin(*member);
    for (;;) { // a chunk to each farm in turn, so that none waits for the first to be served whole
        Member* full = nullptr;
        bool moved = false;
        for (const auto& member : members_) guard(*member, [&] {
            moved = push(*member) || moved;
            if (member->sent < member->rows.size()) full = member.get();
        });
        if (!full) return;
        if (moved) continue;
        // Its ring is full: an answer comes before there is room. Others may have room earlier.
        guard(*full, [&] { full->channel->await(std::chrono::milliseconds(farms() > 1 ? 2 : 50)); });
        tend(*full);
    }
}

// A farm of which nothing is asked in this step gets no message.
void FarmGroup::begin(Member& member) {
    member.sent = 0;
    member.chunk_ready = false;
    member.finished = member.rows.empty();
    member.answer.start({});
    if (member.finished) return;
    const int count = static_cast<int>(member.rows.size());
    if (replacement_.at_most > 0) member.journal.begin_step(clock_, count);
    member.end->begin_step(clock_, count, member.answer);
}

bool FarmGroup::push(Member& member) {
    if (member.sent == member.rows.size()) return false;
    const std::size_t left = member.rows.size() - member.sent;
    const std::size_t count = std::min(left, static_cast<std::size_t>(member.end->chunk_size()));
    if (!member.chunk_ready) {
        Batch& chunk = member.end->next_chunk();
        const auto ids = std::span(member.ids).subspan(member.sent, count);
        std::copy(ids.begin(), ids.end(), chunk.ids().begin());
        (*fill_)(std::span(member.rows).subspan(member.sent, count), chunk);
        if (replacement_.at_most > 0) member.journal.chunk(chunk);
        member.chunk_ready = true;
    }
    if (!member.end->try_send_chunk()) return false;
    member.chunk_ready = false;
    member.sent += count;
    return true;
}

void FarmGroup::finish_step() {
    ensure(in_step_);
    for (;;) {
        Member* awaited = nullptr;
        for (const auto& member : members_) guard(*member, [&] {
            if (member->finished) return;
            while (push(*member)) {} // of a farm that has taken over in the middle of the step
            member->finished = member->sent == member->rows.size() && member->end->try_finish_step();
            if (member->finished && replacement_.at_most > 0) member->journal.end_step(member->answer);
            if (!member->finished && !awaited) awaited = member.get();
        });
        if (!awaited && std::all_of(members_.begin(), members_.end(), [](const auto& m) { return m->finished; })) break;
        if (!awaited) continue; // a farm was replaced in this round
        guard(*awaited, [&] { awaited->channel->await(); });
        tend(*awaited);
    }
    in_step_ = false;
}

// While one farm is waited for, the others see that the driver is at work, and a death among them is seen.
void FarmGroup::tend(const Member& awaited) {
    const auto now = Clock::now();
    if (farms() == 1 || now - last_tended_ < Patience::look_interval) return;
    last_tended_ = now;
    ++ticks_;
    for (const auto& member : members_) {
        if (member.get() == &awaited || !member->end) continue;
        member->channel->advance_progress(ticks_, 0);
        if (!reviving_ && !leaving_) guard(*member, [&] { member->channel->look_after(); });
    }
}

void FarmGroup::ask_all(FrameType question, const Payload& payload, std::vector<std::vector<std::byte>>& replies) {
    replies.resize(members_.size());
    for (const auto& member : members_) {
        auto content = payload(*member);
        if (!content) continue;
        member->question = question;
        member->payload = std::move(*content);
        member->asked = true;
        guard(*member, [&] { member->end->post(question, member->payload); });
    }
    for (const auto& member : members_)
        while (member->asked) {
            guard(*member, [&] {
                auto reply = member->end->try_reply();
                if (!reply) {
                    member->channel->await();
                    return;
                }
                replies[static_cast<std::size_t>(member->index)] = std::move(*reply);
                member->asked = false;
            });
            tend(*member);
        }
}

std::vector<std::vector<std::byte>> FarmGroup::command(const std::string& name) {
    std::vector<std::vector<std::byte>> replies;
    ask_all(FrameType::command, [&](const Member&) { return encode_command(name, {}); }, replies);
    return replies;
}

void FarmGroup::command_rves(const std::string& name, std::span<const std::uint32_t> rves) {
    std::vector<std::vector<std::uint32_t>> ids(members_.size());
    for (const std::uint32_t rve : rves) ids[owner_[rve]].push_back(local_[rve]);
    std::vector<std::vector<std::byte>> payloads, replies;
    for (const auto& own : ids) {
        ByteWriter out;
        out.array(own);
        payloads.push_back(out.take());
    }
    const auto concerns = [&](const Member& member) { return !ids[static_cast<std::size_t>(member.index)].empty(); };
    const auto payload = [&](const Member& member) { return payloads[static_cast<std::size_t>(member.index)]; };
    ask_all(FrameType::command, [&](const Member& member) -> std::optional<std::vector<std::byte>> {
        if (!concerns(member)) return std::nullopt;
        return encode_command(name, payload(member));
    }, replies);
    for (const auto& member : members_)
        if (concerns(*member) && replacement_.at_most > 0) member->journal.command(name, payload(*member));
}

void FarmGroup::bye() {
    std::vector<std::vector<std::byte>> replies;
    leaving_ = true;
    replacement_.at_most = replaced_; // who dies at its farewell needs no successor
    ask_all(FrameType::bye, [](const Member&) { return std::vector<std::byte>(); }, replies);
    remove_bases();
}

double FarmGroup::waiting_seconds() const {
    double sum = waited_for_lost_;
    for (const auto& member : members_) sum += member->channel->waiting_seconds();
    return sum;
}

std::vector<std::uint32_t> equal_shares(std::span<const double> costs, int farms) {
    double total = 0.0, sum = 0.0;
    for (double cost : costs) total += cost;
    std::vector<std::uint32_t> begins = {0};
    const auto count = static_cast<std::uint32_t>(costs.size()), shares = static_cast<std::uint32_t>(farms);
    for (std::uint32_t rve = 0; rve < count && begins.size() < shares; ++rve) {
        sum += costs[rve];
        const double due = total * static_cast<double>(begins.size()) / static_cast<double>(shares);
        const bool rest_is_scarce = count - (rve + 1) <= shares - begins.size(); // every farm gets one, as far as they go
        if (sum >= due - 1e-9 * total || rest_is_scarce) begins.push_back(rve + 1);
    }
    while (begins.size() <= shares) begins.push_back(count);
    return begins;
}

} // namespace talik::exchange
