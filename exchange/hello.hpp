#pragma once
// The first message of each side. The driver asks for columns, the farm offers some; all else must agree.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "exchange/columns.hpp"
#include "exchange/wait.hpp"

namespace talik::exchange {

struct Hello {
    Role role = Role::driver;
    std::string program;           // "mpm-driver 0.1.0", for people
    std::uint64_t run_id = 0;      // of the run
    std::uint64_t epoch = 0;       // counts the restarts of the run
    std::string scene_hash;        // for people and records; the farm reads no scene
    std::uint32_t dimension = 2;
    std::vector<Column> request_columns; // driver: sends these; farm: understands these
    std::vector<Column> answer_columns;  // driver: wants these back; farm: can give these
};

std::vector<std::byte> encode(const Hello& hello);
Hello decode_hello(std::span<const std::byte> payload);

// Throws one error that names every field in which the driver's hello does not fit what the farm offers.
void check_agreement(const Hello& driver, const Hello& farm);

// An error as a payload: exit code, place, problem, remedy.
std::vector<std::byte> encode_error(const std::exception& error);
[[noreturn]] void rethrow_error(std::span<const std::byte> payload, Role reporter);

} // namespace talik::exchange
