#pragma once
// The status of an RVE as a user reads it: "RVE 3 ...".
#include <string>

#include <fmt/format.h>

#include "rve-farm/assembly/answer.hpp"

namespace talik::farm {

inline std::string in_words(const Answer& answer) {
    switch (answer.status) {
    case Status::ok: return "is sound";
    case Status::not_finite: return "flew apart (discs moved a good part of their radius within one sub-step)";
    case Status::contact_list_full: return "was pressed so far that discs have more neighbours than there is room for";
    case Status::unstable_step: return fmt::format("has become too stiff for its sub-step: the largest stable one is {:.3g} s", answer.largest_stable_step);
    case Status::bad_request: return "was asked for a strain that is no number, or too large for one step";
    }
    return "failed";
}

} // namespace talik::farm
