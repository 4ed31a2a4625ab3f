// Runs the sketch for some 2 s of its own time; its lines go to stdout.
#include "knitbench_rig.ino"

int main() {
  setup();
  for (int i = 0; i < 60000; i++) {
    loop();
    if (i % 100 == 0) edges[0]();  // both pins low: a step forward
  }
}
