#include "common/base/program.hpp"

#include <cstdio>
#include <exception>
#include <new>

#include "common/base/error.hpp"

namespace talik {
namespace {

int report(const char* text, ExitCode code) {
    std::fprintf(stderr, "error: %s\n", text);
    return static_cast<int>(code);
}

} // namespace

int run_program(const std::function<int()>& body) {
    try {
        return body();
    } catch (const Error& error) {
        return report(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return report("out of memory (use a smaller scene, or a machine with more memory: see `mpm-driver explain`)",
                      ExitCode::out_of_resource);
    } catch (const std::exception& error) {
        return report(error.what(), ExitCode::failed);
    }
}

} // namespace talik
