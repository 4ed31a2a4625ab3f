/* Reads samples as numbers, writes them as lines. */
#include <inttypes.h>
#include <stdio.h>

#include "kb_line.h"

int main(void) {
  kb_sample s;
  unsigned force, resistance, temperature;
  while (scanf("%" SCNu32 " %" SCNu32 " %" SCNu32 " %u %" SCNd32 " %u %" SCNu64 " %" SCNd32 " %u %" SCNd32, &s.boot,
               &s.sequence, &s.micros, &force, &s.force_uN, &resistance, &s.resistance_mohm, &s.displacement_nm,
               &temperature, &s.temperature_mC) == 10) {
    char line[KB_LINE_MAX];
    s.has_force = (uint8_t)force, s.has_resistance = (uint8_t)resistance, s.has_temperature = (uint8_t)temperature;
    fwrite(line, 1, kb_line(line, &s), stdout);
  }
  return 0;
}
