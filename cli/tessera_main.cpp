#include "cli/command_line.h"

int main(int argc, char** argv) {
  using namespace tessera;
  constexpr AddCommand kCommands[] = {add_render_command, add_studio_command,  add_serve_command,
                                      add_worker_command, add_keygen_command,  add_submit_command,
                                      add_job_commands,   add_fetch_command,   add_convert_command,
                                      add_info_command,   add_compare_command, add_bench_command};
  return run_program(kCommands, argc, argv);
}
