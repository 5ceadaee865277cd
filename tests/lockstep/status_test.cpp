// rve-farm status: what it says of a run that goes on, and that the run does not notice.
#include <csignal>
#include <regex>

#include "tests/lockstep/support.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

using namespace talik::lockstep;

namespace {

Finished status(const TemporaryFolder& folder, const std::string& name) { return run_to_end({"rve-farm", "status", name}, folder / "cache"); }

long step_in(const std::string& text) {
    std::smatch found;
    return std::regex_search(text, found, std::regex("step +([0-9]+), t = ")) ? std::stol(found[1]) : -1;
}

} // namespace

TEST_CASE("A running exchange is seen from outside: its step grows from look to look, and both sides tell who waits", "[lockstep][status]") {
    const TemporaryFolder folder;
    const fs::path scene = write_endless_scene(folder), output = folder / "out";
    Program program({"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet", "--threads", "1"}, folder / "cache");
    REQUIRE(appears(output / "history.csv", 30));
    pause(0.3);
    const Finished first = status(folder, output.string());
    INFO(first.text);
    REQUIRE(first.end.code == 0);
    const std::string pid = std::to_string(program.pid()); // a run answers to its process, too
    pause(0.2);
    const Finished second = status(folder, pid);
    INFO(second.text);
    REQUIRE(second.end.code == 0);
    CHECK(step_in(first.text) > 0);
    CHECK(step_in(second.text) > step_in(first.text));
    for (const char* part : {"tiny", "steps/s", "to go", "queue", "driver     process", "farm       process", "waiting"}) CHECK_CONTAINS(first.text, part);
    CHECK(program.running());
    program.send(SIGTERM);
    CHECK(program.wait(10).code == 1);
    program.orphans(10);
    const Finished gone = status(folder, output.string());
    CHECK(gone.end.code == 2);
    REQUIRE(gone.errors.size() == 1);
    CHECK_CONTAINS(gone.errors[0], "no run '");
}
