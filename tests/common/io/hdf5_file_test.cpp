#include "common/io/hdf5_file.hpp"

#include <fstream>
#include <functional>

#include "common/base/error.hpp"
#include "common/base/version.hpp"
#include "tests/support/text.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;

namespace {

const std::string path = test_file("hdf5_test.h5");

Error error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& e) {
        return e;
    }
    return Error(ExitCode::done, "", "nothing was thrown", "");
}

} // namespace

TEST_CASE("an HDF5 file returns numbers, texts and attributes as they were written, bit by bit") {
    const std::vector<double> numbers = {0.1, -1e300, 3.0, 1.0 / 3.0, 5e-324, 6.0};
    const std::vector<std::int64_t> whole = {-1, 1LL << 60};
    {
        Hdf5File file = Hdf5File::create(path, "test", "talik-test 1");
        file.write("/a/b/numbers", numbers, 3);
        file.write("/whole", whole);
        file.write("/ids", std::vector<std::uint32_t>{7, 4294967295u});
        file.write("/bytes", std::vector<std::uint8_t>{0, 255});
        file.write("/none", std::vector<double>{});
        file.write_text("/text", "two\nlines");
        file.set_attribute("/a", "unit", std::string("Pa"));
        file.set_attribute("/a", "scale", 0.1);
        file.set_attribute("/a", "count", std::int64_t{1} << 60);
        file.close();
    }
    const Hdf5File file = Hdf5File::open(path);
    const auto read = file.read<double>("/a/b/numbers");
    CHECK(read.values == numbers);
    CHECK(read.rows == 2);
    CHECK(read.columns == 3);
    CHECK(file.read<std::int64_t>("/whole").values == whole);
    CHECK(file.read<std::uint32_t>("/ids").values == std::vector<std::uint32_t>{7, 4294967295u});
    CHECK(file.read<std::uint8_t>("/bytes").values == std::vector<std::uint8_t>{0, 255});
    CHECK(file.read<double>("/none").values.empty());
    CHECK(file.read_text("/text") == "two\nlines");
    CHECK(file.text_attribute("/a", "unit") == "Pa");
    CHECK(file.number_attribute("/a", "scale") == 0.1);
    CHECK(file.integer_attribute("/a", "count") == std::int64_t{1} << 60);
    CHECK(file.children("/") == std::vector<std::string>{"a", "bytes", "ids", "none", "text", "whole"});
}

TEST_CASE("every HDF5 file says which program and version wrote it, and in which format") {
    Hdf5File::create(path, "test", "talik-test 1").close();
    const Hdf5File file = Hdf5File::open(path);
    CHECK(file.text_attribute("/", "program") == "test");
    CHECK(file.text_attribute("/", "version") == version());
    CHECK_NOTHROW(file.require_format("talik-test 1"));
    CHECK_CONTAINS(error_of([&] { file.require_format("talik-other 1"); }).what(), "has the format \"talik-test 1\"");
}

TEST_CASE("a series grows by a row at a time, also after the file was closed") {
    {
        Hdf5File file = Hdf5File::create(path, "test", "talik-test 1");
        for (double t : {0.0, 1.0}) file.append<double>("/run/series", std::vector<double>{t, 10.0 * t});
        file.close();
    }
    {
        Hdf5File file = Hdf5File::extend(path);
        file.append<double>("/run/series", std::vector<double>{2.0, 20.0});
        file.close();
    }
    const auto read = Hdf5File::open(path).read<double>("/run/series");
    CHECK(read.rows == 3);
    CHECK(read.values == std::vector<double>{0, 0, 1, 10, 2, 20});
}

TEST_CASE("what was flushed can be read while the file is still open") {
    Hdf5File file = Hdf5File::create(path, "test", "talik-test 1");
    file.append<double>("/series", std::vector<double>{4.0});
    file.flush();
    // A copy, as a process sees the file after its writer was killed.
    std::ifstream from(path, std::ios::binary);
    std::ofstream(path + ".copy", std::ios::binary) << from.rdbuf();
    CHECK(Hdf5File::open(path + ".copy").read<double>("/series").values == std::vector<double>{4.0});
}

TEST_CASE("faults of HDF5 files name file and path, with the exit code of bad input") {
    const Error absent = error_of([] { Hdf5File::open("no/such/file.h5"); });
    CHECK(absent.code() == ExitCode::bad_input);
    CHECK_CONTAINS(absent.what(), "no/such/file.h5: does not exist");
    std::ofstream(path) << "this is text";
    CHECK_CONTAINS(error_of([] { Hdf5File::open(path); }).what(), "is not a readable HDF5 file");
    CHECK(error_of([] { Hdf5File::create("no/such/folder/file.h5", "t", "f"); }).code() == ExitCode::bad_input);
    Hdf5File file = Hdf5File::create(path, "test", "talik-test 1");
    file.write("/numbers", std::vector<double>{0.5});
    CHECK_CONTAINS(error_of([&] { file.read<double>("/number"); }).what(), "/number: is missing");
    CHECK_CONTAINS(error_of([&] { file.read<std::int64_t>("/numbers"); }).what(), "not an array of the expected kind");
    CHECK_CONTAINS(error_of([&] { file.number_attribute("/", "nothing"); }).what(), "the attribute is missing");
}

TEST_CASE("a full disk is named, with the exit code of a resource that ran out") {
    const Error full = error_of([] { // /dev/full takes no byte
        Hdf5File file = Hdf5File::create("/dev/full", "test", "talik-test 1");
        file.write("/numbers", std::vector<double>(100000, 1.0));
        file.close();
    });
    CHECK(full.code() == ExitCode::out_of_resource);
    CHECK_CONTAINS(full.what(), "the disk is full");
}
