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
    // "activate bonds": in all RVEs, or in those whose ids are the payload; "costs": of each RVE, the seconds of this farm that
    // it has taken since this was last asked
    std::vector<std::byte> command(const std::string& name, std::span<const std::byte> payload) override;
    void checkpoint(const std::string& path) override; // a file, which appears once it is whole
    void restore(const std::string& path) override;    // of a folder: the RVEs of this farm, from whichever files hold them

private:
    Farm& farm();
    std::size_t restore_from(const std::string& file, std::vector<std::uint8_t>& found); // the number of RVEs taken

    FarmOptions options_;
    bool books_energies_ = true;
    exchange::ColumnTable request_columns_, answer_columns_;
    std::vector<double (*)(const Answer&, const AssemblyNumbers&)> readers_; // of each component of the agreed answer columns
    std::optional<Farm> farm_;
    std::vector<std::uint32_t> run_ids_; // of each RVE of this farm, in the run
    std::vector<double> costs_;          // s, of each RVE
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
