#include "exchange/process.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "common/base/error.hpp"

namespace talik::exchange {
namespace {

constexpr double seconds_to_end = 5.0; // after SIGTERM, before SIGKILL

// In the child, between fork and exec: async-signal-safe calls only. Does not return; reports errno through the pipe.
[[noreturn]] void become(char* const* arguments, pid_t parent, int report, const sigset_t& held) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127); // it died before the line above
    for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) { // not the launcher's handlers; but what it ignores (nohup), both ignore
        struct sigaction present {};
        sigaction(signal, nullptr, &present);
        if (present.sa_handler != SIG_IGN) std::signal(signal, SIG_DFL);
    }
    sigprocmask(SIG_SETMASK, &held, nullptr); // survives exec, and so do signals that came meanwhile
    execvp(arguments[0], arguments);
    const int error = errno;
    [[maybe_unused]] const auto written = write(report, &error, sizeof error);
    _exit(127);
}

} // namespace

LaunchedProcess::LaunchedProcess(const std::vector<std::string>& arguments, Interrupts interrupts) {
    ensure(!arguments.empty());
    std::vector<char*> pointers;
    for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
    pointers.push_back(nullptr);
    int report[2];
    if (pipe2(report, O_CLOEXEC) != 0)
        fail(ExitCode::out_of_resource, fmt::format("cannot start '{}': {}", arguments[0], std::strerror(errno)), "close other programs");
    const pid_t parent = getpid();
    sigset_t own, held, during_launch;
    sigemptyset(&held);
    if (interrupts == Interrupts::held)
        for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) sigaddset(&held, signal);
    sigfillset(&during_launch); // between fork and become() the child has this process's handlers, which would swallow them
    pthread_sigmask(SIG_SETMASK, &during_launch, &own);
    pid_ = fork();
    if (pid_ == 0) become(pointers.data(), parent, report[1], held);
    const int fork_error = errno;
    pthread_sigmask(SIG_SETMASK, &own, nullptr);
    close(report[1]);
    int error = 0;
    ssize_t got = 0;
    if (pid_ > 0)
        do got = read(report[0], &error, sizeof error);
        while (got < 0 && errno == EINTR); // end of file: exec closed the pipe
    close(report[0]);
    if (pid_ < 0)
        fail(ExitCode::out_of_resource, fmt::format("cannot start '{}': {}", arguments[0], std::strerror(fork_error)), "close other programs");
    if (got == static_cast<ssize_t>(sizeof error)) {
        int status = 0;
        waitpid(pid_, &status, 0);
        pid_ = -1;
        fail(ExitCode::bad_input, fmt::format("cannot start '{}': {}", arguments[0], std::strerror(error)),
             "see that it is built and stands beside this program");
    }
}

LaunchedProcess::~LaunchedProcess() {
    if (pid_ <= 0 || !running()) return;
    kill(pid_, SIGTERM);
    kill(pid_, SIGCONT); // a stopped process would not see the first
    if (wait(seconds_to_end)) return;
    kill(pid_, SIGKILL);
    wait(seconds_to_end);
}

void LaunchedProcess::end_now() {
    if (pid_ <= 0 || !running()) return;
    kill(pid_, SIGKILL); // a stopped process, too
    wait(seconds_to_end);
}

bool LaunchedProcess::running() {
    if (status_) return false;
    int status = 0;
    pid_t ended;
    do ended = waitpid(pid_, &status, WNOHANG);
    while (ended < 0 && errno == EINTR);
    if (ended == 0) return true;
    status_ = ended == pid_ ? status : 0;
    return false;
}

std::optional<std::string> LaunchedProcess::fate() {
    if (running()) return std::nullopt;
    if (!WIFSIGNALED(*status_)) return fmt::format("exited with code {}", WEXITSTATUS(*status_));
    const int signal = WTERMSIG(*status_);
    const char* name = sigabbrev_np(signal);
    return fmt::format("was killed by signal {} (SIG{})", signal, name ? name : "?");
}

std::optional<int> LaunchedProcess::exit_code() {
    if (running() || !WIFEXITED(*status_)) return std::nullopt;
    return WEXITSTATUS(*status_);
}

bool LaunchedProcess::wait(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (running()) {
        if (std::chrono::steady_clock::now() >= end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

} // namespace talik::exchange
