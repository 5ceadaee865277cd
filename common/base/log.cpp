#include "common/base/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>

namespace talik::log {

void start(const std::string& program, bool quiet) {
    auto logger = std::make_shared<spdlog::logger>(program, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    logger->set_pattern("[%n] %^%l%$: %v");
    logger->set_level(quiet ? spdlog::level::warn : spdlog::level::info);
    spdlog::set_default_logger(logger);
}

} // namespace talik::log
