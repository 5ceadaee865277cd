#pragma once
// Both ends of an exchange in one process, for tests: the same semantics as shared memory by the plainest means.
#include <memory>
#include <utility>

#include "exchange/channel.hpp"

namespace talik::exchange {

// first: the driver's end, second: the farm's; capacity: bytes under way in each direction. Destroying an end is leaving.
std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> loopback_pair(std::size_t capacity, const WaitLimits& limits);

} // namespace talik::exchange
