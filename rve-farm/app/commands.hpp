#pragma once
// The subcommands of rve-farm, one file each.
namespace CLI {
class App;
}

namespace talik::farm {

void add_pack(CLI::App& app);
void add_element(CLI::App& app);
void add_bench(CLI::App& app);
void add_serve(CLI::App& app, int& exit); // exit: the code that the program ends with
void add_replay(CLI::App& app, int& exit);
void add_status(CLI::App& app, int& exit);

} // namespace talik::farm
