// driver EXCHANGE SPECIFICATION [elastic]: strains three RVEs, and checks what comes back.
#include <exchange/c_api.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <vector>

namespace {

int ended(const char* what, int code) {
    std::fprintf(stderr, "error: %s: %s\n", what, talik_last_error());
    return code;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) return 2;
    const bool elastic = argc > 3 && std::strcmp(argv[3], "elastic") == 0;
    const talik_column request[] = {{"displacement_gradient_increment", 4, "1", nullptr}};
    const talik_column answers[] = {{"stress", 3, "Pa", nullptr}, {"status", 1, "1", nullptr}, {"stored_energy", 1, "J", nullptr}};
    talik_driver_options options{};
    options.size = sizeof options;
    options.program = "driver of an outside project";
    options.request = request, options.request_columns = 1;
    options.answer = answers, options.answer_columns = 3;
    options.attach_seconds = 30;
    talik_driver* farm = nullptr;
    if (const int code = talik_driver_open(&farm, argv[1], &options)) return ended("open", code);
    constexpr std::size_t rves = 3;
    std::vector<double> initial(5 * rves), asked(4 * rves, 0.0), answer(5 * rves);
    int code = talik_driver_configure(farm, argv[2], rves, initial.data());
    const std::uint32_t ids[rves] = {2, 0, 1};
    for (std::size_t i = 0; i < rves; ++i) asked[3 * rves + i] = -1e-5; // yy
    for (std::uint64_t step = 1; code == 0 && step <= 20; ++step) code = talik_driver_step(farm, step, 1e-4, 0, rves, ids, asked.data(), answer.data());
    if (code == 0 && elastic) {
        const double expected = initial[rves + 2] - 20 * 1e-5 * 4e7; // yy of RVE 2, with lambda + 2 G = 4e7 Pa
        if (std::abs(answer[rves] - expected) > 1e-6 * std::abs(expected)) return std::fprintf(stderr, "error: %g Pa instead of %g Pa\n", answer[rves], expected), 1;
        asked[0] = 0.6; // beyond what that law takes: its own words come back
        if (talik_driver_step(farm, 21, 1e-4, 0, rves, ids, asked.data(), answer.data()) != 1 || !std::strstr(talik_last_error(), "stretched by more than a half"))
            return std::fprintf(stderr, "error: the law's fault did not come through: %s\n", talik_last_error()), 1;
        talik_driver_close(farm);
        return 0;
    }
    if (code == 0) code = talik_driver_bye(farm);
    if (code == 0) std::printf("stress %.6g %.6g %.6g Pa\n", answer[0], answer[rves], answer[2 * rves]);
    if (code == 0 && !(answer[rves] < initial[rves])) code = 1; // compressed along y: more compression
    if (code != 0) ended("run", code);
    talik_driver_close(farm);
    return code;
}
