#pragma once
// Ctrl-C and SIGTERM as a question that loops and waits ask, so that both programs end in order: the driver finishes its
// step and writes a checkpoint; the farm serves it meanwhile. A second signal ends waits at once, a third kills.

namespace talik {

// Installs the handlers of SIGINT, SIGTERM, SIGHUP and SIGUSR1 (what batch systems and mpirun pass on before they kill), and lets through what a launcher held back until then (blocked: see
// exchange/process.hpp); called once by main().
void watch_interrupts();

bool interrupted() noexcept;
int interrupt_count() noexcept;
int interrupting_signal() noexcept;       // the first one; 0 where there was none
double seconds_since_interrupt() noexcept; // 0 where there was none
const char* interrupt_name() noexcept;    // "SIGINT"; "" where there was none

void forget_interrupts() noexcept; // for tests

} // namespace talik
