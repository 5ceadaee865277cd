#pragma once
// Nothing is thrown across the C interface: an exception becomes an exit code and the text of talik_last_error().
#include <string>

#include "common/base/error.hpp"
#include "exchange/c_api.h"
#include "exchange/columns.hpp"

namespace talik::exchange::c {

std::string& last_error(); // of this thread

template <class Body>
int guarded(Body&& body) noexcept {
    try {
        last_error().clear();
        body();
        return 0;
    } catch (const Error& error) {
        last_error() = error.what();
        return static_cast<int>(error.code());
    } catch (const std::bad_alloc&) {
        last_error() = "out of memory (use fewer RVEs)";
        return static_cast<int>(ExitCode::out_of_resource);
    } catch (const std::exception& error) {
        last_error() = error.what();
        return static_cast<int>(ExitCode::failed);
    } catch (...) {
        last_error() = "an exception of a foreign kind";
        return static_cast<int>(ExitCode::failed);
    }
}

std::vector<Column> columns_of(const talik_column* columns, std::size_t count);
std::string address(const char* exchange); // "shm:NAME" or "file:FOLDER", checked

// A structure from outside: the size it says must be one that this library knows.
template <class Structure>
void require_known(const Structure* given, const char* name) {
    require(given != nullptr && given->size == sizeof(Structure), std::string(name) + " is missing, or not of this version of the library",
            "set its `size` to sizeof(" + std::string(name) + "), and compile against the c_api.h that came with the library");
}

} // namespace talik::exchange::c
