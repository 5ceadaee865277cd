// fuzz-seeds FOLDER: well-formed inputs of the message target, from which the fuzzer starts.
#include <cstring>
#include <filesystem>
#include <fstream>

#include "common/io/byte_stream.hpp"
#include "common/packing/farm_setup.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/batch.hpp"
#include "exchange/hello.hpp"

using namespace talik;
using namespace talik::exchange;

namespace {

using Bytes = std::vector<std::byte>;

void frame(Bytes& out, FrameType type, const Bytes& payload) {
    const auto length = static_cast<std::uint16_t>(payload.size());
    out.push_back(static_cast<std::byte>(type));
    const auto* bytes = reinterpret_cast<const std::byte*>(&length);
    out.insert(out.end(), bytes, bytes + 2);
    out.insert(out.end(), payload.begin(), payload.end());
}

void write(const std::filesystem::path& folder, const std::string& name, int choice, const Bytes& bytes) {
    std::ofstream out(folder / name, std::ios::binary);
    out.put(static_cast<char>(choice));
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

Bytes batch(const std::vector<Column>& columns, std::uint32_t first, std::uint32_t count, std::uint32_t chunk, std::uint32_t chunks, FrameType type) {
    Batch made(ColumnTable(columns), 8);
    made.start({7, 0, 1, 1e-3, chunk, chunks, 0, count});
    for (std::uint32_t i = 0; i < count; ++i) made.ids()[i] = first + i;
    for (int c = 0; c < made.columns().components(); ++c)
        for (double& value : made.component(c)) value = 1e-5;
    return made.frame(type, 0).payload;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const std::filesystem::path folder = argv[1];
    Hello hello;
    hello.program = "driver";
    hello.run_id = 7;
    hello.request_columns = {rve_columns::displacement_gradient_increment};
    hello.answer_columns = {rve_columns::stress, rve_columns::status};
    FarmSetup setup;
    Packing packing;
    packing.x = packing.y = {0.25, 0.75}, packing.radius = {0.25, 0.25};
    packing.contacts.push_back({0, 1, {0, 0}, 1.0, false});
    setup.packings = {packing};
    setup.packing_of_rve = {0, 0, 0, 0, 0, 0};
    ByteWriter command;
    command.text("activate bonds");
    ByteWriter ids;
    ids.array(std::vector<std::uint32_t>{1, 2});
    command.array(ids.bytes());

    Bytes to_farm;
    frame(to_farm, FrameType::hello, encode(hello));
    frame(to_farm, FrameType::configure, encode(setup));
    frame(to_farm, FrameType::step_request, batch(hello.request_columns, 0, 3, 0, 2, FrameType::step_request));
    frame(to_farm, FrameType::step_request, batch(hello.request_columns, 3, 3, 1, 2, FrameType::step_request));
    frame(to_farm, FrameType::command, command.bytes());
    frame(to_farm, FrameType::bye, {});
    write(folder, "to-farm", 0, to_farm);
    write(folder, "to-farm-with-checksums", 1, to_farm);

    Hello farm = hello;
    farm.role = Role::farm;
    Bytes to_driver;
    frame(to_driver, FrameType::hello, encode(farm));
    frame(to_driver, FrameType::ready, {});
    frame(to_driver, FrameType::step_answer, batch(hello.answer_columns, 0, 4, 0, 2, FrameType::step_answer));
    frame(to_driver, FrameType::step_answer, batch(hello.answer_columns, 4, 2, 1, 2, FrameType::step_answer));
    frame(to_driver, FrameType::error, encode_error(std::runtime_error("lost")));
    write(folder, "to-driver", 4, to_driver);
    write(folder, "hello", 12, encode(hello));
    write(folder, "setup", 13, encode(setup));
    write(folder, "error", 14, encode_error(std::runtime_error("lost")));
    return 0;
}
