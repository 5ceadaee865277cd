#include "common/base/interrupt.hpp"
#include "exchange/process.hpp"
#include "exchange/process_identity.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <atomic>
#include <csignal>
#include <pthread.h>
#include <thread>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

TEST_CASE("The fate of a launched program is told: its exit code or its signal", "[exchange][process]") {
    LaunchedProcess ends({"sh", "-c", "exit 4"});
    REQUIRE(ends.wait(10.0));
    CHECK(ends.fate() == "exited with code 4");
    CHECK(ends.exit_code() == 4);
    LaunchedProcess sleeps({"sleep", "30"});
    CHECK_FALSE(sleeps.fate().has_value());
    kill(sleeps.pid(), SIGKILL);
    REQUIRE(sleeps.wait(10.0));
    CHECK(sleeps.fate() == "was killed by signal 9 (SIGKILL)");
    CHECK_FALSE(sleeps.exit_code().has_value());
}

TEST_CASE("Ctrl-C or SIGTERM ends a launched program, but one that has them held only when it is ready for them", "[exchange][process]") {
    const bool held = GENERATE(false, true);
    const int signal = GENERATE(SIGINT, SIGTERM);
    LaunchedProcess program({"sleep", "0.3"}, held ? Interrupts::held : Interrupts::at_once);
    kill(program.pid(), signal);
    REQUIRE(program.wait(10.0));
    CHECK(program.fate() == (held ? "exited with code 0" : signal == SIGINT ? "was killed by signal 2 (SIGINT)" : "was killed by signal 15 (SIGTERM)"));
}

TEST_CASE("A Ctrl-C that a launcher held back is not lost: watch_interrupts() lets it through", "[exchange][process]") {
    sigset_t held, before;
    sigemptyset(&held);
    sigaddset(&held, SIGINT);
    sigprocmask(SIG_BLOCK, &held, &before);
    forget_interrupts();
    std::raise(SIGINT);
    CHECK_FALSE(interrupted());
    watch_interrupts();
    CHECK(interrupting_signal() == SIGINT);
    forget_interrupts();
    for (int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
    sigprocmask(SIG_SETMASK, &before, nullptr);
}

TEST_CASE("What the launcher ignores (nohup), the launched program ignores", "[exchange][process]") {
    const auto before = std::signal(SIGHUP, SIG_IGN);
    LaunchedProcess program({"sh", "-c", "sleep 0.3; exit 5"});
    std::signal(SIGHUP, before);
    kill(program.pid(), SIGHUP);
    REQUIRE(program.wait(10.0));
    CHECK(program.fate() == "exited with code 5");
}

TEST_CASE("A program that does not exist is an error at once", "[exchange][process]") {
    CHECK(contains(error_text([] { LaunchedProcess({"/no/such/program"}); }), "cannot start '/no/such/program': No such file"));
}

TEST_CASE("A launched program ends with its owner, even while it is stopped", "[exchange][process]") {
    const bool stopped = GENERATE(false, true);
    int pid = 0;
    {
        LaunchedProcess sleeps({"sleep", "30"});
        pid = sleeps.pid();
        if (stopped) kill(pid, SIGSTOP);
    }
    CHECK(process_state(pid) == '?'); // ended and reaped
}

TEST_CASE("A launched program does not outlive a launcher that is killed", "[exchange][process]") {
    int report[2];
    REQUIRE(pipe(report) == 0);
    Child launcher([&] {
        LaunchedProcess sleeps({"sleep", "30"});
        const int pid = sleeps.pid();
        if (write(report[1], &pid, sizeof pid) != sizeof pid) _exit(1);
        std::raise(SIGKILL);
    });
    int pid = 0;
    REQUIRE(read(report[0], &pid, sizeof pid) == sizeof pid);
    launcher.exit_code();
    const auto begin = Clock::now();
    const auto ended = [&] { return process_state(pid) == '?' || process_state(pid) == 'Z'; }; // Z: whoever adopts it may be slow
    while (!ended() && seconds_since(begin) < 5.0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    CHECK(ended());
    close(report[0]);
    close(report[1]);
}

TEST_CASE("A process is told from a later one with its number, and a zombie from the living", "[exchange][process]") {
    ProcessIdentity self = this_process();
    CHECK(process_exists(self));
    CHECK(ProcessWatch(self, -1, 0).alive());
    self.start_time += 1;
    CHECK_FALSE(process_exists(self));
    CHECK_FALSE(ProcessWatch(self, -1, 0).alive());
    const pid_t pid = fork();
    if (pid == 0) pause();
    const ProcessIdentity other = identity_of(pid);
    const ProcessWatch watch(other, -1, 0);
    CHECK(watch.alive());
    kill(pid, SIGKILL);
    siginfo_t info;
    waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOWAIT); // dead, and not yet reaped
    CHECK_FALSE(watch.alive());
    CHECK_FALSE(process_exists(other));
    waitpid(pid, nullptr, 0);
}

TEST_CASE("A signal that comes while the partner is looked at does not make it dead", "[exchange][process]") {
    const auto before = std::signal(SIGUSR1, [](int) {});
    const ProcessWatch watch(this_process(), -1, 0);
    const pthread_t looker = pthread_self();
    std::atomic<bool> stop{false};
    std::thread signals([&] {
        while (!stop) pthread_kill(looker, SIGUSR1);
    });
    int deaths = 0;
    for (int look = 0; look < 20'000; ++look) deaths += !watch.alive(); // some thousand of them are cut short
    stop = true;
    signals.join();
    std::signal(SIGUSR1, before);
    CHECK(deaths == 0);
}
