// `tessera bench`, which starts this program with the same arguments.
#include "base/program_folder.h"
#include "cli/bench/bench_commands.h"

int main(int argc, char** argv) {
  using namespace tessera;
  set_program(program_folder() / "tessera");
  constexpr AddCommand kCommands[] = {add_bench_kinds};
  return run_program(kCommands, argc, argv);
}
