#include "common/base/error.hpp"

#include <cstdio>

namespace talik {

std::string one_line(const std::string& text) {
    std::string line;
    line.reserve(text.size());
    for (const char letter : text) {
        const auto code = static_cast<unsigned char>(letter);
        char escape[8];
        if (code >= 0x20 && code != 0x7f) line += letter; // bytes of UTF-8 beyond ASCII stay
        else if (letter == '\n') line += "\\n";
        else if (letter == '\t') line += "\\t";
        else if (letter == '\r') line += "\\r";
        else std::snprintf(escape, sizeof escape, "\\u%04X", static_cast<unsigned>(code)), line += escape;
    }
    return line;
}

namespace {

std::string sentence(const std::string& where, const std::string& problem, const std::string& remedy) {
    std::string text = where.empty() ? problem : where + ": " + problem;
    if (!remedy.empty()) text += " (" + remedy + ")";
    return one_line(text);
}

} // namespace

Error::Error(ExitCode code, std::string where, std::string problem, std::string remedy)
    : std::runtime_error(sentence(where, problem, remedy)), code_(code), where_(std::move(where)),
      problem_(std::move(problem)), remedy_(std::move(remedy)) {}

void fail(ExitCode code, const std::string& problem, const std::string& remedy) {
    throw Error(code, "", problem, remedy);
}

void ensure_failed(const char* condition, const char* place) {
    throw Error(ExitCode::failed, place, std::string("internal check failed: ") + condition,
                "this is a defect of Talik: please report it with the scene");
}

} // namespace talik
