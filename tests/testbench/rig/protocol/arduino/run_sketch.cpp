// Runs the sketch for 4 s of its own time; its lines go to stdout. With a word behind its name, the load cell's chip
// stops in the middle.
#include "knitbench_rig.ino"

int main(int words, char **) {
  setup();
  for (uint32_t i = 0, run_us = 0; run_us < 4000000; i++, run_us = fake_us - begun_us) {
    cell_stopped = words > 1 && run_us >= 2000000;
    loop();
    if (i % 100 == 0) edges[0]();  // both pins low: a step forward
  }
}
