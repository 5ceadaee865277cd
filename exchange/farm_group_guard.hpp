#pragma once
// What both halves of the group (farm_group.cpp, farm_recovery.cpp) do where a farm may be lost.
#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "exchange/farm_group.hpp"

namespace talik::exchange {

// After it the member's farm lives and stands where `act` found or left it, or the loss ends the run.
template <class Act>
void FarmGroup::guard(Member& member, Act act) {
    try {
        act();
    } catch (const Error& error) {
        if (error.code() != ExitCode::partner_lost || reviving_ || interrupted()) throw;
        revive(member, error);
    }
}

} // namespace talik::exchange
