#include "exchange/transport.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "exchange/file_channel.hpp"
#include "exchange/mpi_channel.hpp"
#include "exchange/shm_channel.hpp"

namespace talik::exchange {
namespace {

enum class Kind { shm, file, mpi };

struct Address {
    Kind kind;
    std::string name;
};

Address parse(const std::string& text) {
    if (text == "mpi") return {Kind::mpi, ""};
    for (const auto& [prefix, kind] : {std::pair{"shm:", Kind::shm}, std::pair{"file:", Kind::file}})
        if (text.starts_with(prefix) && text.size() > std::string(prefix).size()) return {kind, text.substr(std::string(prefix).size())};
    fail(ExitCode::bad_input, "--exchange " + text + ": no such transport",
         "give shm:NAME, file:FOLDER or mpi, the same to mpm-driver and to `rve-farm serve`; or leave it out: mpm-driver then starts a farm of its own");
}

} // namespace

bool is_mpi(const std::string& address) { return address == "mpi"; }

std::string address_of_farm(const std::string& address, int farm) {
    if (farm == 0) return address;
    return parse(address).kind == Kind::file ? fmt::format("{}/farm-{}", address, farm) : fmt::format("{}.{}", address, farm);
}

std::unique_ptr<Channel> make_exchange(const std::string& address, const WaitLimits& limits) {
    const Address at = parse(address);
    ensure(at.kind != Kind::mpi);
    return at.kind == Kind::shm ? make_shm_channel(at.name, limits) : make_file_channel(at.name, limits);
}

std::vector<std::unique_ptr<Channel>> make_exchange(const std::string& address, int farms, const WaitLimits& limits) {
    if (parse(address).kind == Kind::mpi) return make_mpi_channels(farms, limits);
    std::vector<std::unique_ptr<Channel>> channels;
    for (int farm = 0; farm < std::max(1, farms); ++farm) channels.push_back(make_exchange(address_of_farm(address, farm), limits));
    return channels;
}

std::unique_ptr<Channel> join_exchange(const std::string& address, const WaitLimits& limits) {
    const Address at = parse(address);
    if (at.kind == Kind::mpi) return join_mpi_channel(limits);
    return at.kind == Kind::shm ? join_shm_channel(at.name, limits) : join_file_channel(at.name, limits);
}

} // namespace talik::exchange
