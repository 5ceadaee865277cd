#include "exchange/sealed_file.hpp"
#include "common/io/hdf5_file.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <fstream>
#include <vector>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

namespace fs = std::filesystem;

struct OwnFile {
    fs::path path = fs::temp_directory_path() / ("talik-" + unique_name("seal"));
    ~OwnFile() { fs::remove(path); }
    void write(const std::string& bytes) const { std::ofstream(path, std::ios::binary) << bytes; }
    std::string read() const {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
};

std::string seen(const fs::path& path) {
    ExitCode code = ExitCode::failed;
    const std::string text = error_text([&] { require_sealed(path); }, &code);
    CHECK((text == "no error" || code == ExitCode::bad_input));
    return text;
}

} // namespace

TEST_CASE("A sealed file passes: with any one bit turned, of content or seal, it is damaged", "[exchange][seal]") {
    const OwnFile file;
    file.write("state of 37 bytes, no multiple of 32.");
    seal(file.path);
    CHECK(seen(file.path) == "no error");
    const std::string sound = file.read();
    REQUIRE(sound.size() == 37 + 16);
    for (std::size_t bit = 0; bit < 8 * sound.size(); ++bit) {
        std::string turned = sound;
        turned[bit / 8] = static_cast<char>(turned[bit / 8] ^ (1 << (bit % 8)));
        file.write(turned);
        CAPTURE(bit);
        CHECK(contains(seen(file.path), "is damaged"));
    }
}

TEST_CASE("A file that is cut short, never was sealed, or is missing does not pass", "[exchange][seal]") {
    const OwnFile file;
    file.write(std::string(3'000'000, 'x')); // several of the pieces in which it is summed
    CHECK(contains(seen(file.path), "is damaged"));
    seal(file.path);
    CHECK(seen(file.path) == "no error");
    const std::string sound = file.read();
    for (const std::size_t size : {0u, 7u, 16u, 1'048'576u, 3'000'000u, 3'000'015u}) {
        file.write(sound.substr(0, size));
        CAPTURE(size);
        CHECK(contains(seen(file.path), "is damaged"));
    }
    fs::remove(file.path);
    CHECK(contains(seen(file.path), "cannot be read"));
}

TEST_CASE("A sealed HDF5 file is read as one without a seal", "[exchange][seal]") {
    const OwnFile file;
    const std::vector<double> values = {1.0, -2.5, 3e300};
    Hdf5File out = Hdf5File::create(file.path.string(), "test", "test 1");
    out.write("/values", values);
    out.close();
    seal(file.path);
    require_sealed(file.path);
    CHECK(Hdf5File::open(file.path.string()).read<double>("/values").values == values);
}
