#pragma once
// What makes the exchange idempotent: of each RVE, its last step and answer. A step already done is answered again with
// the same bits; so a farm that wrote its checkpoint and died before answering does not wedge the pair, and a driver may
// replay its requests to a farm that came back from an older checkpoint.
#include <cstdint>
#include <vector>

#include "exchange/batch.hpp"
#include "common/io/byte_stream.hpp"

namespace talik::exchange {

class AnswerMemory {
public:
    AnswerMemory() = default;
    // RVE ids run from 0 to rve_count - 1.
    AnswerMemory(int rve_count, const ColumnTable& answer_columns);

    // Fills the rows of `answer` that are remembered, and lists in `rows` those that are to be computed. A step before
    // the last one of an RVE, another request for its last step, an unknown id or an id twice is an error.
    void recall(const Batch& request, Batch& answer, std::vector<int>& rows);
    // After the rows were computed, and only then.
    void remember(const Batch& request, const Batch& answer, const std::vector<int>& rows);

    std::uint64_t last_step(std::uint32_t id) const { return last_[id].step; } // 0 = none yet

    // In checkpoints.
    void save(ByteWriter& out) const;
    void load(ByteReader& in);
    // One RVE's row from another memory, where it stood under another id.
    void take(std::uint32_t id, const AnswerMemory& from, std::uint32_t id_there);

private:
    struct Last {
        std::uint64_t step = 0;
        std::uint64_t request = 0; // checksum of the request's row: the same step must ask for the same
    };
    std::vector<Last> last_;
    std::vector<double> answers_; // [id][component]
    std::vector<std::uint64_t> seen_; // [id]: the call of recall() that met it last
    std::uint64_t calls_ = 0;
    int components_ = 0;
};

} // namespace talik::exchange
