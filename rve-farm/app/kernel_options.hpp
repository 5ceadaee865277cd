#pragma once
// The options that choose where and with what is computed, the same in every command that computes.
#include <CLI/CLI.hpp>

#include <string>

#include "rve-farm/backend/farm.hpp"

namespace talik::farm {

struct KernelOptions {
    std::string backend = "auto", precision, level = "auto";

    void add_to(CLI::App& command) {
        command.add_option("--backend", backend, "cpu, cuda, or auto: GPUs where there are any, and enough RVEs for them")->check(CLI::IsMember({"auto", "cpu", "cuda"}));
        command.add_option("--precision", precision, "single or double; else as the specification says")->check(CLI::IsMember({"single", "double"}));
        command.add_option("--simd", level, "instruction level of the CPU: auto, plain, sse4, avx2 or avx512")->check(CLI::IsMember({"auto", "plain", "sse4", "avx2", "avx512"}));
    }
    // Refuses (bad_input) a level that this machine lacks.
    void choose(FarmOptions& options) const {
        options.backend = backend == "cpu" ? Backend::cpu : backend == "cuda" ? Backend::cuda : Backend::automatic;
        if (!precision.empty()) options.precision = precision == "single" ? Precision::single_ : Precision::double_;
        options.level = level_named(level); // auto: none
        if (options.level) kernel(*options.level, Precision::double_);
    }
};

} // namespace talik::farm
