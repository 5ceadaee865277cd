#pragma once
// Log lines for people: spdlog to stderr, so that stdout stays free for what a command answers.
#include <spdlog/spdlog.h>

namespace talik::log {

using spdlog::debug;
using spdlog::info;
using spdlog::warn;

// Called once by main(). quiet: warnings only.
void start(const std::string& program, bool quiet);

} // namespace talik::log
