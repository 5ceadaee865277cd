// talik_serve: a law behind C callbacks, as the farm of a driver.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "common/io/byte_stream.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/packing/farm_setup.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/answer_memory.hpp"
#include "exchange/c/guard.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/run_board.hpp"
#include "exchange/sealed_file.hpp"
#include "exchange/transport.hpp"

namespace talik::exchange::c {
namespace {

constexpr const char* format = "talik-law-checkpoint 1";

bool holds(const std::vector<Column>& columns, const Column& wanted) { return std::find(columns.begin(), columns.end(), wanted) != columns.end(); }

// What a law that knows no grains is taken to say of them: sums of what did not happen are 0, the rest is not known.
double silent_answer(const Column& column) {
    const bool sum = column.unit == "J" || column == rve_columns::status || column == rve_columns::bonds || column == rve_columns::broken_bonds || column == rve_columns::split_steps ||
                     column == rve_columns::retaken_chunks;
    return sum ? 0.0 : std::numeric_limits<double>::quiet_NaN();
}

class ForeignLaw : public FarmService {
public:
    ForeignLaw(const talik_law& law, void* user) : law_(law), user_(user), request_(columns_of(law.request, law.request_columns)), answer_(columns_of(law.answer, law.answer_columns)) {
        require(law.configure && law.answer_batch, "the law has no configure or no answer_batch", "set both");
        require(holds(request_, rve_columns::displacement_gradient_increment), "the law does not read displacement_gradient_increment[4]", "add that column, as talik_known_column() gives it");
        for (const Column& column : {rve_columns::stress, rve_columns::stiffness})
            require(holds(answer_, column), "the law does not give " + column.name, "add that column, as talik_known_column() gives it (stiffness: the P-wave modulus, for the time step)");
    }

    // Whatever a driver may send: what the law does not read is passed over.
    std::vector<Column> understands() const override { return joined(request_, rve_columns::requests()); }
    std::vector<Column> offers() const override { return joined(answer_, rve_columns::answers()); }

    void agreed(const Hello& driver) override {
        for (const Column& column : request_)
            require(holds(driver.request_columns, column), "the law reads '" + column.name + "', which the driver does not send", "turn on the effect in the scene that sends it, or read it no more");
        const ColumnTable sent(driver.request_columns), wanted(driver.answer_columns);
        request_from_.clear(), answer_from_.clear(), otherwise_.clear();
        for (const Column& column : request_)
            for (int c = 0; c < column.components; ++c) request_from_.push_back(sent.first_component(sent.index(column.name)) + c);
        const ColumnTable given(answer_);
        for (const Column& column : wanted.columns())
            for (int c = 0; c < column.components; ++c) {
                const int index = given.index(column.name);
                answer_from_.push_back(index < 0 ? -1 : given.first_component(index) + c);
                otherwise_.push_back(silent_answer(column));
            }
        wanted_ = wanted;
        given_components_ = static_cast<std::size_t>(given.components());
    }

    std::vector<std::byte> configure(std::span<const std::byte> payload, Channel&) override {
        const FarmSetup setup = decode_farm_setup(payload);
        const std::size_t count = setup.packing_of_rve.size();
        std::vector<double> stress(3 * count, 0.0), void_ratio, volume;
        for (std::size_t rve = 0; rve < count; ++rve) {
            const Packing& packing = setup.packings[static_cast<std::size_t>(setup.packing_of_rve[rve])];
            const bool k0 = packing.vertical_stress > 0.0;
            stress[rve] = -(k0 ? packing.lateral_stress : packing.pressure);
            stress[count + rve] = -(k0 ? packing.vertical_stress : packing.pressure);
            void_ratio.push_back(packing.void_ratio());
            volume.push_back(std::abs(packing.cell.determinant()) * setup.parameters.thickness);
        }
        const talik_setup told{sizeof(talik_setup), count, stress.data(), setup.parameters.thickness, setup.parameters.grain_density, void_ratio.data(), volume.data()};
        std::vector<double> own(given_components_ * count, 0.0);
        call([&] { return law_.configure(user_, &told, own.data()); }, "configure");
        memory_ = AnswerMemory(static_cast<int>(count), wanted_);
        std::vector<double> initial(answer_from_.size() * count);
        for (std::size_t c = 0; c < answer_from_.size(); ++c)
            for (std::size_t i = 0; i < count; ++i) initial[c * count + i] = answer_from_[c] < 0 ? otherwise_[c] : own[static_cast<std::size_t>(answer_from_[c]) * count + i];
        ByteWriter out;
        out.array(initial);
        return out.take();
    }

    void answer(const Batch& request, Batch& answer, Channel& progress) override {
        memory_.recall(request, answer, rows_);
        const std::size_t count = rows_.size();
        ids_.resize(count), asked_.resize(request_from_.size() * count), told_.resize(given_components_ * count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto row = static_cast<std::size_t>(rows_[i]);
            ids_[i] = request.ids()[row];
            for (std::size_t c = 0; c < request_from_.size(); ++c) asked_[c * count + i] = request.component(request_from_[c])[row];
        }
        const BatchHeader& clock = request.header();
        const talik_batch batch{sizeof(talik_batch), count, ids_.data(), clock.step, clock.time_increment, asked_.data(), told_.data()};
        if (count > 0) call([&] { return law_.answer_batch(user_, &batch); }, "answer_batch");
        for (std::size_t c = 0; c < answer_from_.size(); ++c) {
            const auto column = answer.component(static_cast<int>(c));
            for (std::size_t i = 0; i < count; ++i)
                column[static_cast<std::size_t>(rows_[i])] = answer_from_[c] < 0 ? otherwise_[c] : told_[static_cast<std::size_t>(answer_from_[c]) * count + i];
        }
        memory_.remember(request, answer, rows_);
        progress.advance_progress(done_ += count, 0);
    }

    std::vector<std::byte> command(const std::string& name, std::span<const std::byte>) override {
        require(law_.command != nullptr, "the law knows no command \"" + name + "\"", "take the effect out of the scene's stages, or give the law a `command`");
        call([&] { return law_.command(user_, name.c_str()); }, "command");
        return {};
    }

    void checkpoint(const std::string& path) override {
        ByteWriter memory;
        memory_.save(memory);
        Hdf5File file = Hdf5File::create(path, "talik-exchange", format);
        file.set_attribute("/", "law", std::string(law_.name ? law_.name : ""));
        file.write("/answers", std::span(reinterpret_cast<const std::uint8_t*>(memory.bytes().data()), memory.bytes().size()));
        file.close();
        seal(path);
        if (law_.checkpoint) call([&] { return law_.checkpoint(user_, (path + ".law").c_str()); }, "checkpoint");
    }

    void restore(const std::string& path) override {
        require_sealed(path);
        const Hdf5File file = Hdf5File::open(path);
        file.require_format(format);
        const auto bytes = file.read<std::uint8_t>("/answers").values;
        ByteReader memory({reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()}, path);
        memory_.load(memory);
        if (law_.restore) call([&] { return law_.restore(user_, (path + ".law").c_str()); }, "restore");
    }

private:
    static std::vector<Column> joined(std::vector<Column> own, const std::vector<Column>& known) {
        for (const Column& column : known)
            if (std::none_of(own.begin(), own.end(), [&](const Column& c) { return c.name == column.name; })) own.push_back(column);
        return own;
    }

    template <class Callback>
    static void call(Callback callback, const char* what) {
        last_error().clear();
        const int code = callback();
        if (code == 0) return;
        const std::string said = last_error().empty() ? fmt::format("its {} returned {}", what, code) : last_error();
        const bool known = code >= 1 && code <= 4;
        throw Error(known ? static_cast<ExitCode>(code) : ExitCode::failed, "", "the law fails: " + said, "mend the law");
    }

    talik_law law_;
    void* user_;
    std::vector<Column> request_, answer_;    // of the law, in its own order
    ColumnTable wanted_;                      // of the driver
    std::vector<int> request_from_, answer_from_; // by component: where it stands on the other side; -1 = the law does not give it
    std::vector<double> otherwise_;
    std::size_t given_components_ = 0;
    std::uint64_t done_ = 0;
    AnswerMemory memory_;
    std::vector<int> rows_;
    std::vector<std::uint32_t> ids_;
    std::vector<double> asked_, told_;
};

} // namespace
} // namespace talik::exchange::c

extern "C" int talik_serve(const char* exchange, const talik_law* law, void* user, double attach_seconds) {
    using namespace talik::exchange;
    return c::guarded([&] {
        c::require_known(law, "talik_law");
        c::ForeignLaw service(*law, user);
        WaitLimits limits;
        if (attach_seconds > 0.0) limits.attach_seconds = attach_seconds;
        const std::string address = c::address(exchange);
        publish_run_board(Role::farm, address);
        const auto channel = join_exchange(address, limits);
        with_cause(*channel, [&] { FarmEnd(*channel, service, law->name ? law->name : "a law").serve(); });
    });
}
