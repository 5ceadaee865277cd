#pragma once
// OpenMP's threads spin for a while after every parallel region before they sleep. Here two programs share the cores in
// turn, so a spinning thread takes a core from the partner: they are to sleep at once. libgomp reads its setting before
// main() only, so a program that was started without it starts itself anew with it.

namespace talik {

// Called first thing in main(). Returns at once where OMP_WAIT_POLICY is set, whatever it says.
void let_idle_threads_sleep(char** argv);

} // namespace talik
