#pragma once
// A recording of a lockstep: every request and answer, by step, component and RVE, in HDF5 (docs/partners.md lists the
// arrays). It is whole up to its last flushed step at any moment, also after its writer was killed.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/io/hdf5_series.hpp"
#include "exchange/batch.hpp"

namespace talik::exchange {

struct RecordFacts {
    std::string driver, farm;       // programs, for people
    std::string scene_hash;
    std::string setup_checksum;     // of the payload of `configure`
    std::vector<Column> request_columns, answer_columns;
    std::size_t rves = 0;
    std::vector<double> initial;    // answers of all RVEs before the first step, [component][rve]
};

struct RecordedStep {
    std::int64_t step = 0, substeps = 0, asked = 0; // asked: number of RVEs
    double time_increment = 0.0;                    // s
};

struct RecordedCommand {
    std::int64_t after_step = 0;
    std::string name;
    std::vector<std::byte> payload, reply;
};

// What is on disk, to read.
class Record {
public:
    explicit Record(const std::string& file);

    const std::string& file() const { return file_.name(); }
    const RecordFacts& facts() const { return facts_; }
    const std::vector<RecordedStep>& steps() const { return steps_; }
    const std::vector<RecordedCommand>& commands() const { return commands_; }
    std::optional<std::size_t> find(std::uint64_t step) const; // its place in steps()

    // [component][rve]; numbers of RVEs that were not asked are NaN.
    void read_request(std::size_t place, std::span<double> out) const { request_.read(place, out); }
    void read_answer(std::size_t place, std::span<double> out) const { answer_.read(place, out); }
    void read_asked(std::size_t place, std::span<std::uint8_t> out) const; // by RVE: 1 = was asked

private:
    Hdf5File file_;
    RecordFacts facts_;
    std::vector<RecordedStep> steps_;
    std::vector<RecordedCommand> commands_;
    Hdf5Series<double> request_, answer_;
    Hdf5Series<std::uint8_t> asked_;
};

// Before a run begins: `file` replaces nothing but a recording.
void check_place_of_record(const std::string& file);

// To write: rows come in the order of the steps.
class RecordFile {
public:
    RecordFile(const std::string& file, const RecordFacts& facts);

    void add(const RecordedStep& step, std::span<const std::byte> packed_request, std::span<const std::byte> packed_answer,
             std::span<const std::uint8_t> asked); // asked: by RVE; empty = all
    void add(const RecordedCommand& command);
    void flush() { file_.flush(); }
    void close();

private:
    Hdf5File file_;
    std::optional<Hdf5Series<std::int64_t>> clock_, command_ends_;
    std::optional<Hdf5Series<double>> time_increment_, request_, answer_;
    std::optional<Hdf5Series<std::uint8_t>> asked_, command_bytes_;
    std::int64_t command_end_ = 0;
};

// Bytes of a recorded step before compression.
double bytes_per_step(const RecordFacts& facts);

} // namespace talik::exchange
