// Runs the sketch until the codes on stdin are used up; its lines go to stdout.
#include "knitbench_compensator.ino"

int main() {
  setup();
  while (!Wire.over) loop();
}
