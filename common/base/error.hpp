#pragma once
// The one error type: what is wrong, and what to do about it.
#include <stdexcept>
#include <string>

namespace talik {

// Exit codes of both programs (docs/interface.md).
enum class ExitCode { done = 0, failed = 1, bad_input = 2, partner_lost = 3, out_of_resource = 4 };

// Text on one line, whatever a user's value holds: control characters as TOML writes them (\n, \t, \u001B).
std::string one_line(const std::string& text);

// what() reads "WHERE: PROBLEM (REMEDY)", on one line; WHERE is "FILE:LINE: KEY", or empty.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, std::string where, std::string problem, std::string remedy);

    ExitCode code() const { return code_; }
    const std::string& where() const { return where_; }
    const std::string& problem() const { return problem_; }
    const std::string& remedy() const { return remedy_; }

private:
    ExitCode code_;
    std::string where_, problem_, remedy_;
};

// For the user: the input or the machine is at fault. Both texts are mandatory.
inline void require(bool holds, const std::string& problem, const std::string& remedy) {
    if (!holds) throw Error(ExitCode::bad_input, "", problem, remedy);
}

// Plain texts cost nothing where all is well: for what is asked in every step.
inline void require(bool holds, const char* problem, const char* remedy) {
    if (!holds) [[unlikely]] throw Error(ExitCode::bad_input, "", problem, remedy);
}

[[noreturn]] void fail(ExitCode code, const std::string& problem, const std::string& remedy);

// For us: a broken promise between two pieces of our own code.
#define TALIK_STRINGIFY_(x) #x
#define TALIK_STRINGIFY(x) TALIK_STRINGIFY_(x)
#define ensure(...) \
    ((__VA_ARGS__) ? void() : ::talik::ensure_failed(#__VA_ARGS__, __FILE__ ":" TALIK_STRINGIFY(__LINE__)))
[[noreturn]] void ensure_failed(const char* condition, const char* place);

} // namespace talik
