#include "exchange/answer_memory.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

struct Memory {
    ColumnTable request_columns{{rve_columns::displacement_gradient_increment}}, answer_columns{{rve_columns::stress}};
    AnswerMemory memory{10, answer_columns};
    Batch request{request_columns, 10}, answer{answer_columns, 10};
    std::vector<int> rows;

    std::vector<int> ask(std::uint64_t step, std::vector<std::uint32_t> ids, double increment) {
        BatchHeader header;
        header.step = step;
        header.count = static_cast<std::uint32_t>(ids.size());
        request.start(header);
        answer.start(header);
        for (std::size_t i = 0; i < ids.size(); ++i) {
            request.ids()[i] = ids[i];
            for (int c = 0; c < 4; ++c) request.component(c)[i] = increment;
        }
        memory.recall(request, answer, rows);
        return rows;
    }
    void compute(double stress) {
        for (int row : rows)
            for (int c = 0; c < 3; ++c) answer.component(c)[static_cast<std::size_t>(row)] = stress + c;
        memory.remember(request, answer, rows);
    }
};

} // namespace

TEST_CASE("A step already done is answered from memory, RVE by RVE", "[exchange][memory]") {
    Memory m;
    CHECK(m.ask(1, {4, 7}, 0.1) == std::vector<int>{0, 1});
    m.compute(100.0);
    CHECK(m.ask(1, {7, 2, 4}, 0.1) == std::vector<int>{1}); // 2 has not done step 1 yet
    CHECK(m.answer.component(0, 1)[0] == 101.0);
    CHECK(m.answer.component(0, 2)[2] == 102.0);
}

TEST_CASE("RVEs may skip steps, but not go back", "[exchange][memory]") {
    Memory m;
    m.ask(1, {3}, 0.1);
    m.compute(1.0);
    CHECK(m.ask(5, {3}, 0.1) == std::vector<int>{0});
    m.compute(2.0);
    CHECK_THROWS_AS(m.ask(4, {3}, 0.1), Error);
}

TEST_CASE("A request that failed was not answered: it is computed when asked for again", "[exchange][memory]") {
    Memory m;
    CHECK(m.ask(1, {3}, 0.1) == std::vector<int>{0});
    CHECK(m.ask(1, {3}, 0.1) == std::vector<int>{0});
}

TEST_CASE("The same step with another increment, an unknown RVE, and one RVE twice are errors", "[exchange][memory]") {
    Memory m;
    m.ask(1, {3}, 0.1);
    m.compute(1.0);
    CHECK_THROWS_AS(m.ask(1, {3}, 0.2), Error);
    CHECK_THROWS_AS(m.ask(2, {10}, 0.1), Error);
    CHECK_THROWS_AS(m.ask(2, {5, 6, 5}, 0.1), Error);
}

TEST_CASE("The memory survives a checkpoint, to the bit", "[exchange][memory]") {
    Memory m, other;
    m.ask(6, {1, 9}, 0.1);
    m.compute(1.0 / 3.0);
    ByteWriter out;
    m.memory.save(out);
    ByteReader in(out.bytes(), "checkpoint");
    other.memory.load(in);
    in.finish();
    CHECK(other.ask(6, {9, 1, 0}, 0.1) == std::vector<int>{2});
    CHECK(other.answer.component(0)[0] == 1.0 / 3.0);
    CHECK(other.memory.last_step(1) == 6);
}
