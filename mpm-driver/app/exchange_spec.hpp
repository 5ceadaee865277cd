#pragma once
// What a scene's file says about its run and not about the ground: it changes no result, and is no part of the scene's hash.

namespace talik::driver {

// What is done about a farm that is lost.
struct ExchangeSpec {
    int replace_farm = 0;           // farms that may be replaced in a run; 0 = report, keep the checkpoint, exit code 3
    double replace_interval = 60.0; // s of wall time: the work that a lost farm can cost
};

} // namespace talik::driver
