// Random text as a scene: whatever comes, `mpm-driver check` names faults or finds none; sanitizers watch the rest.
#include <cstdint>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

#include "mpm-driver/app/scene_schema.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const int file = memfd_create("scene", 0); // a file that touches no disk
    static const std::string name = "/proc/self/fd/" + std::to_string(file);
    if (ftruncate(file, 0) != 0 || pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) return 0;
    for (const talik::scene::Fault& fault : talik::driver::check_scene(name))
        if (fault.problem.empty() || fault.remedy.empty() || fault.text().find('\n') != std::string::npos) __builtin_trap(); // a fault is one line, with its mend
    return 0;
}
