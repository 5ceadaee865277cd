#pragma once
// The frame of every main(): one catch, one line on stderr, the exit code of docs/interface.md.
#include <functional>

namespace talik {

// Runs the body; an Error becomes "error: WHERE: PROBLEM (REMEDY)" and its exit code.
int run_program(const std::function<int()>& body);

} // namespace talik
