#include "exchange/hello.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/byte_stream.hpp"

namespace talik::exchange {
namespace {

void put_columns(ByteWriter& out, const std::vector<Column>& columns) {
    out.put(static_cast<std::uint32_t>(columns.size()));
    for (const Column& column : columns) {
        out.text(column.name);
        out.put(static_cast<std::int32_t>(column.components));
        out.text(column.unit);
        out.text(column.meaning);
    }
}

std::vector<Column> get_columns(ByteReader& in) {
    std::vector<Column> columns;
    for (auto left = in.get<std::uint32_t>(); left > 0; --left) { // a false count ends at the end of the payload
        Column column;
        column.name = in.text();
        column.components = in.get<std::int32_t>();
        column.unit = in.text();
        column.meaning = in.text();
        columns.push_back(std::move(column));
    }
    return columns;
}

} // namespace

std::vector<std::byte> encode(const Hello& hello) {
    ByteWriter out;
    out.put(static_cast<std::uint32_t>(hello.role));
    out.text(hello.program);
    out.put(hello.run_id);
    out.put(hello.epoch);
    out.text(hello.scene_hash);
    out.put(hello.dimension);
    put_columns(out, hello.request_columns);
    put_columns(out, hello.answer_columns);
    return out.take();
}

Hello decode_hello(std::span<const std::byte> payload) {
    ByteReader in(payload, "hello");
    Hello hello;
    hello.role = in.get<std::uint32_t>() == 0 ? Role::driver : Role::farm;
    hello.program = in.text();
    hello.run_id = in.get<std::uint64_t>();
    hello.epoch = in.get<std::uint64_t>();
    hello.scene_hash = in.text();
    hello.dimension = in.get<std::uint32_t>();
    hello.request_columns = get_columns(in);
    hello.answer_columns = get_columns(in);
    in.finish();
    return hello;
}

void check_agreement(const Hello& driver, const Hello& farm) {
    std::vector<std::string> faults;
    const auto add = [&](std::vector<std::string> more) { faults.insert(faults.end(), more.begin(), more.end()); };
    if (driver.role == farm.role) faults.push_back(fmt::format("role: both say they are {}", name_of(driver.role)));
    if (driver.dimension != farm.dimension)
        faults.push_back(fmt::format("dimension: the driver has {}, the farm {}", driver.dimension, farm.dimension));
    add(missing(driver.request_columns, mandatory_request_columns()));
    add(missing(driver.answer_columns, mandatory_answer_columns()));
    add(mismatches(driver.request_columns, farm.request_columns));
    add(mismatches(driver.answer_columns, farm.answer_columns));
    require(faults.empty(),
            fmt::format("{} and {} do not fit together: {}", driver.program, farm.program, fmt::join(faults, "; ")),
            "use driver and farm of the same version, or a farm that offers what the scene calls for");
    (void)ColumnTable(driver.request_columns); // names twice
    (void)ColumnTable(driver.answer_columns);
}

std::vector<std::byte> encode_error(const std::exception& error) {
    const Error foreign(ExitCode::failed, "", error.what(), ""); // of a library below: no remedy is known
    const auto* ours = dynamic_cast<const Error*>(&error);
    const Error& told = ours ? *ours : foreign;
    ByteWriter out;
    out.put(static_cast<std::int32_t>(told.code()));
    out.text(told.where());
    out.text(told.problem());
    out.text(told.remedy());
    return out.take();
}

void rethrow_error(std::span<const std::byte> payload, Role reporter) {
    ByteReader in(payload, "error");
    const auto code = in.get<std::int32_t>();
    const std::string where = in.text(), problem = in.text(), remedy = in.text();
    in.finish();
    const bool known = code >= static_cast<std::int32_t>(ExitCode::failed) && code <= static_cast<std::int32_t>(ExitCode::out_of_resource);
    throw Error(known ? static_cast<ExitCode>(code) : ExitCode::failed, where,
                fmt::format("{} reports: {}", name_of(reporter), problem), remedy);
}

} // namespace talik::exchange
