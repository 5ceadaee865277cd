#pragma once
#include "rve-farm/assembly/stretch.hpp"

namespace talik::farm {

struct ChunkRequest {
    Stretch stretch;        // of the first sub-step, in the frame
    int substeps = 0;       // 0: forces and sums of the present state
    double sub_step = 0;    // s
    double first_kick = 0;  // time over which the forces act at the first sub-step, s; afterwards sub_step
    double beta = 1;        // beta_b of Eq. (8), -
    double displacement_allowed = 0; // of any disc, non-affine, m: beyond it the chunk is not given back
    bool give_back = true;  // the state; else only the sums
    bool ledger = true;       // book work and dissipation
    bool time_stages = false;
};

} // namespace talik::farm
