#include "common/base/interrupt.hpp"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace talik {
namespace {

// Lock-free atomics are all that a signal handler may touch.
std::atomic<int> count{0};
std::atomic<int> first_signal{0};
std::atomic<std::int64_t> first_time{0}; // ns of CLOCK_MONOTONIC
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t now() noexcept {
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time); // async-signal-safe
    return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

void on_signal(int signal) {
    const int nth = count.fetch_add(1) + 1;
    if (nth == 1) {
        first_time = now();
        first_signal = signal;
    }
    if (nth >= 3) { // whoever asks three times means it
        std::signal(signal, SIG_DFL);
        std::raise(signal);
    }
}

} // namespace

void watch_interrupts() {
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART; // files being written are not cut short; waits wake by themselves
    sigemptyset(&action.sa_mask);
    for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
        struct sigaction present {};
        sigaction(signal, nullptr, &present);
        if (present.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr); // nohup stays nohup
    }
    sigset_t held;
    sigemptyset(&held);
    for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) sigaddset(&held, signal);
    sigprocmask(SIG_UNBLOCK, &held, nullptr);
}

bool interrupted() noexcept { return first_signal.load() != 0; }
int interrupt_count() noexcept { return count.load(); }
int interrupting_signal() noexcept { return first_signal.load(); }

double seconds_since_interrupt() noexcept {
    return interrupted() ? 1e-9 * static_cast<double>(now() - first_time.load()) : 0.0;
}

const char* interrupt_name() noexcept {
    switch (first_signal.load()) {
    case 0: return "";
    case SIGINT: return "SIGINT";
    case SIGTERM: return "SIGTERM";
    case SIGHUP: return "SIGHUP";
    case SIGUSR1: return "SIGUSR1";
    default: return "a signal";
    }
}

void forget_interrupts() noexcept {
    count = 0;
    first_signal = 0;
    first_time = 0;
}

} // namespace talik
