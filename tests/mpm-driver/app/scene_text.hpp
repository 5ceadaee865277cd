#pragma once
// A scene as text, and what its check says when a piece of it is exchanged for a wrong one.
#include <string>

#include "common/io/text_file.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary_file.hpp"

namespace talik::driver::tests {

struct SceneText {
    std::string path, sound;

    SceneText(const char* file_name, std::string text) : path(test_file(file_name)), sound(std::move(text)) {}

    std::string faults_of(const std::string& text) const {
        write_file_atomically(path, text);
        std::string lines;
        for (const auto& fault : check_scene(path)) lines += fault.text() + "\n";
        return lines;
    }
    std::string broken(const std::string& from, const std::string& to) const {
        const auto at = sound.find(from);
        REQUIRE(at != std::string::npos);
        return faults_of(std::string(sound).replace(at, from.size(), to));
    }
};

} // namespace talik::driver::tests
