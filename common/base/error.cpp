#include "common/base/error.hpp"

namespace talik {
namespace {

std::string sentence(const std::string& where, const std::string& problem, const std::string& remedy) {
    std::string text = where.empty() ? problem : where + ": " + problem;
    if (!remedy.empty()) text += " (" + remedy + ")";
    return text;
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
