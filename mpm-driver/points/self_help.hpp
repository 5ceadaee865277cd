#pragma once
// What the program did by itself where it got rough: how often, when and where first and last, and how much at most. Part of
// the state, so that a restart goes on counting; told in summary.json.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/math/matrix.hpp"
#include "mpm-driver/points/state_column.hpp"

namespace talik::driver {

enum class Help : std::size_t { extra_sub_steps, retaken_chunks, lost_contacts, smaller_step, heat_sub_steps, shorter_heat_steps, cut_enthalpy, count };

struct HelpKind {
    const char* name;    // key in summary.json
    const char* meaning; // of an event, and of its amount
};
const HelpKind& kind_of(Help help);

class SelfHelp {
public:
    struct Record { // doubles only: it travels as a column of the state
        double count = 0.0, most = 0.0;
        double first_time = 0.0, first_step = 0.0, first_point = -1.0, first_x = 0.0, first_y = 0.0; // point -1: nowhere in particular
        double last_time = 0.0, last_step = 0.0, last_point = -1.0, last_x = 0.0, last_y = 0.0;
    };
    struct Moment {
        double time = 0.0; // s
        std::int64_t step = 0;
    };

    void note(Help help, const Moment& when, double amount, std::optional<std::uint32_t> point = {}, const Vector& where = Vector::Zero());
    const Record& record(Help help) const { return records_[static_cast<std::size_t>(help)]; }
    std::vector<StateColumn> state();

private:
    std::array<Record, static_cast<std::size_t>(Help::count)> records_;
};

} // namespace talik::driver
