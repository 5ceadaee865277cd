#pragma once
// A program launched by this one: the farm by the driver. It ends when this object does, and when this process dies.
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace talik::exchange {

// Ctrl-C reaches every process of the terminal, SIGTERM of a batch system every process of the job. A program that ends in order
// at them would die of them between its exec and the moment its handlers stand: `held` keeps all four signals of
// watch_interrupts() back until it is called.
enum class Interrupts { at_once, held };

class LaunchedProcess {
public:
    // arguments[0]: the program, found as the shell would. A program that cannot be started is an error here and now.
    // Launch it from the main thread: Linux ties "dies with its parent" to the thread that launched.
    explicit LaunchedProcess(const std::vector<std::string>& arguments, Interrupts interrupts = Interrupts::at_once);
    ~LaunchedProcess(); // asks it to end, waits a little, and then makes it
    LaunchedProcess(const LaunchedProcess&) = delete;
    LaunchedProcess& operator=(const LaunchedProcess&) = delete;

    int pid() const { return static_cast<int>(pid_); }
    bool running();
    // How it ended: "exited with code 4", "was killed by signal 9 (SIGKILL)"; empty while it runs.
    std::optional<std::string> fate();
    std::optional<int> exit_code(); // empty while it runs, and where a signal killed it
    void end_now();                 // by force; returns once it has ended
    bool wait(double seconds);      // until it has ended; false where it still runs

private:
    pid_t pid_ = -1;
    std::optional<int> status_; // of waitpid, once reaped
};

} // namespace talik::exchange
