#pragma once
// Scenes in TOML: the one table of keys that validates them, prints help and makes docs/scene.md.
#include <string>
#include <vector>

#include "common/scene/reading.hpp"
#include "mpm-driver/app/exchange_spec.hpp"
#include "mpm-driver/app/scene.hpp"

namespace talik::driver {

// The scene in SI units, checked; overrides are "key=value" with keys such as rve.contact.friction or stage.0.duration.
// Throws one Error with the first fault and the number of the others.
Scene read_scene(const std::string& file, const std::vector<std::string>& overrides = {});

// Of the same file: [exchange]. Faults are those of read_scene().
ExchangeSpec read_exchange(const std::string& file, const std::vector<std::string>& overrides = {});

// Every fault of the file at once (of TOML syntax: the first); empty = sound.
std::vector<scene::Fault> check_scene(const std::string& file, const std::vector<std::string>& overrides = {});

std::string scene_help();     // for --help-scene
std::string scene_markdown(); // docs/scene.md
std::string scene_dump(const Scene& scene); // canonical TOML, in SI: what the hash is made of

} // namespace talik::driver
