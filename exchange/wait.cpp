#include "exchange/wait.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/progress.hpp"

namespace talik::exchange {
namespace {

constexpr const char* restart = "restart from the last checkpoint";

std::string named(Role role, int pid) {
    return pid > 0 ? fmt::format("{} (process {})", name_of(role), pid) : name_of(role);
}

} // namespace

const char* name_of(Role role) { return role == Role::driver ? "the driver" : "the farm"; }

Patience::Patience(Role self, const WaitLimits& limits) : self_(self), limits_(limits), last_look_(Clock::now()) {}

void Patience::judge(const PartnerView& partner) {
    // A pause between two looks that is far longer than a look's interval was ours (stopped, suspended, starved), and
    // says nothing about the partner.
    const auto now = Clock::now();
    const double interval = std::chrono::duration<double>(now - last_look_).count();
    const double counted = std::min(interval, 3e-3 * static_cast<double>(look_interval.count()));
    last_look_ = now;
    waited_ += counted;
    if (!seen_) first_done_ = partner.progress.done;
    motionless_ = !seen_ || partner.movement != last_movement_ ? 0.0 : motionless_ + counted;
    seen_ = true;
    last_movement_ = partner.movement;

    // Before the partner has come nothing is under way that could be ended in order; and a partner that was launched and
    // ended by the same Ctrl-C is not what ended this side.
    const bool absent = partner.presence == PartnerView::Presence::absent;
    if (absent && interrupted()) report_interrupt("start again");
    if (partner.presence == PartnerView::Presence::left || !partner.process_alive || !partner.cause.empty())
        report_lost(partner);
    check_interrupt();
    if (absent) {
        if (waited_ >= limits_.attach_seconds)
            fail(ExitCode::partner_lost,
                 fmt::format("{} did not come to the exchange within {:g} s", name_of(partner_of(self_)), limits_.attach_seconds),
                 "start it with the same --exchange name, and look at what it says");
        return;
    }
    if (motionless_ >= limits_.stall_seconds) report_stalled(partner);
    tell_progress(partner);
}

void Patience::report_lost(const PartnerView& partner) const {
    const std::string who = named(partner_of(self_), partner.pid);
    if (!partner.cause.empty()) // its own words come first: the survivor must not be taken for the culprit
        fail(ExitCode::partner_lost, fmt::format("{} ended; it reports: {}", who, partner.cause), restart);
    if (!partner.fate.empty()) fail(ExitCode::partner_lost, fmt::format("{} {}", who, partner.fate), restart);
    if (partner.presence == PartnerView::Presence::left)
        fail(ExitCode::partner_lost, who + " left the exchange without a farewell", restart);
    fail(ExitCode::partner_lost, who + " died without a word (killed, out of memory, or a crash)", restart);
}

void Patience::report_stalled(const PartnerView& partner) const {
    const bool stopped = partner.process_state == 'T' || partner.process_state == 't';
    std::string text = fmt::format("{} has stalled: nothing of it moved for {:g} s", named(partner_of(self_), partner.pid),
                                   limits_.stall_seconds);
    if (partner.progress.total > 0) text += fmt::format(", it stands at {} of {}", partner.progress.done, partner.progress.total);
    if (stopped) text += ", and it is stopped (SIGSTOP or Ctrl-Z)";
    fail(ExitCode::partner_lost, text,
         stopped ? fmt::format("continue it with kill -CONT {}, or end it, and {}", partner.pid, restart)
                 : std::string("end it and ") + restart + ", or allow a longer wait");
}

void Patience::check_interrupt() const {
    if (interrupted() && (interrupt_count() >= 2 || seconds_since_interrupt() > limits_.grace_after_interrupt_seconds)) report_interrupt(restart);
}

void Patience::report_interrupt(const char* remedy) const {
    fail(ExitCode::failed, fmt::format("interrupted by {} while waiting for {}", interrupt_name(), name_of(partner_of(self_))), remedy);
}

void Patience::tell_progress(const PartnerView& partner) {
    if (waited_ < next_line_) return;
    next_line_ = 2.0 * waited_;
    const auto [done, total] = partner.progress;
    if (total == 0 || self_ == Role::farm) return; // what the driver is at, the driver's own progress line tells
    std::string eta;
    if (done > first_done_ && total >= done)
        eta = ", about " + readable_duration(waited_ * static_cast<double>(total - done) / static_cast<double>(done - first_done_)) + " to go";
    log::info("waiting for {}: it is at {} of {}{}", name_of(partner_of(self_)), done, total, eta);
}

} // namespace talik::exchange
