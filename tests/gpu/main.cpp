// The entry point of the tests that need a GPU: without one it ends with 77, which ctest counts as skipped.
#include <cstdio>

#include "rve-farm/block/device.hpp"
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_session.hpp>
#else
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#endif

int main(int argc, char** argv) {
    Catch::Session session;
    if (const int wrong = session.applyCommandLine(argc, argv); wrong != 0) return wrong;
    const auto& asked = session.configData();
#if __has_include(<catch2/catch_all.hpp>)
    const bool runs = !asked.listTests && !asked.listTags && !asked.listReporters;
#else
    const bool runs = !asked.listTests && !asked.listTags && !asked.listReporters && !asked.listTestNamesOnly;
#endif
    const talik::farm::Gpus gpus = talik::farm::open_gpus();
    if (runs && gpus.devices.empty()) {
        std::printf("skipped: %s\n", gpus.reason.c_str());
        return 77;
    }
    return session.run() == 0 ? 0 : 1; // not the number of failures, which may be 77
}
