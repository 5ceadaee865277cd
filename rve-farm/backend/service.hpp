#pragma once
// The farm as the exchange sees it: strain increments in, stresses out, for any subset of RVEs; set up by one message,
// checkpointed as a whole, and idempotent (a step already done is answered again with the same bits).
#include <optional>

#include "exchange/answer_memory.hpp"
#include "exchange/farm_end.hpp"
#include "rve-farm/backend/farm.hpp"

namespace talik::farm {

class Service : public exchange::FarmService {
public:
    explicit Service(FarmOptions options) : options_(std::move(options)) {}

    std::vector<Column> understands() const override;
    std::vector<Column> offers() const override;
    void agreed(const exchange::Hello& driver) override;
    // Takes a FarmSetup; returns the answers of all RVEs as they stand, [component][id], in the agreed columns.
    std::vector<std::byte> configure(std::span<const std::byte> payload, exchange::Channel& progress) override;
    void answer(const exchange::Batch& request, exchange::Batch& answer, exchange::Channel& progress) override;
    // "activate bonds": in all RVEs, or in those whose ids are the payload
    std::vector<std::byte> command(const std::string& name, std::span<const std::byte> payload) override;
    void checkpoint(const std::string& path) override;
    void restore(const std::string& path) override;

private:
    Farm& farm();

    FarmOptions options_;
    bool books_energies_ = true;
    exchange::ColumnTable request_columns_, answer_columns_;
    std::vector<double (*)(const Answer&, const AssemblyNumbers&)> readers_; // of each component of the agreed answer columns
    std::optional<Farm> farm_;
    exchange::AnswerMemory memory_;
    exchange::Channel* progress_ = nullptr; // of the step under way
    std::uint64_t progress_total_ = 0;

    // Of the rows to be computed, sized by the largest batch so far.
    std::vector<int> rows_;
    std::vector<std::uint32_t> ids_;
    std::vector<double> increments_, ice_;
    std::vector<Answer> answers_;
};

} // namespace talik::farm
