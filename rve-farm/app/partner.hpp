#pragma once
// How the subcommands that answer a driver meet it: serve and replay.
#include <functional>
#include <string>

#include "exchange/channel.hpp"

namespace CLI {
class App;
}

namespace talik::farm {

struct PartnerOptions {
    std::string exchange;
    double stall_seconds = 120.0, attach_seconds = 60.0;
    bool quiet = false;
    bool launched = false; // by a driver, which quotes what goes wrong here: on one terminal one fault is one line

    void add_to(CLI::App& command);
};

// Joins the exchange and runs `body` on it; the program's exit code.
int serve_driver(const PartnerOptions& options, const std::function<void(exchange::Channel&)>& body);

} // namespace talik::farm
