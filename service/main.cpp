#include <malloc.h>

#include "service/cli/command_line.h"

int main(int argc, char** argv) {
  // One arena for two threads, not eight for each core: a thousand requests do not fragment memory.
  mallopt(M_ARENA_MAX, 2);
  return caustic::service::run_command_line(argc, argv);
}
