// A compensated knitted sensor on an ESP32 (Arduino core): 20 times a second a line with what the sensor says.
//
//   compensation export pes.compensator.json --format c --name knit -o firmware/knitbench_compensator/knit.h
//
// The sensor is the upper half of a divider, read by an ADS1115 (channel A0, 128 SPS, +-4.096 V). Lines are
//
//   time_us,conductance_S,value,status,cycles
//
// value in the unit of the header, status as in docs/compensation.md (0 is good), cycles what the compensator took.
// A reading near either rail is an open or a shorted sensor; it goes in as 0 S, which the compensator leaves out.

#include <Arduino.h>
#include <Wire.h>
#include <stdio.h>

#include "knit.h"

// --- the bench -----------------------------------------------------------------------------------------------------
const uint8_t ADS1115 = 0x48;  // I2C address with ADDR to ground
const float SUPPLY_V = 3.3f, REFERENCE_OHM = 606e3f, LSB_V = 125e-6f, RAIL_V = 0.002f;
const uint32_t CONVERSION_US = 7813, SAMPLE_US = 50000;
const uint32_t PAUSE_US = 3000000000u;  // after a pause this long (50 min) memories mean nothing: begin anew

knit_state compensator;
int32_t code_sum = 0;
uint32_t code_count = 0, conversion_due_us = 0, sample_due_us = 0, good_us = 0;
bool begun = false;

void write_register(uint8_t address, uint16_t value) {
  Wire.beginTransmission(ADS1115);
  Wire.write(address);
  Wire.write((uint8_t)(value >> 8));
  Wire.write((uint8_t)(value & 0xFF));
  Wire.endTransmission();
}

void take_conversion_if_due() {
  if ((int32_t)(micros() - conversion_due_us) < 0) return;
  conversion_due_us += CONVERSION_US;
  Wire.requestFrom(ADS1115, (uint8_t)2);
  if (Wire.available() < 2) return;
  uint16_t high = Wire.read(), low = Wire.read();
  code_sum += (int16_t)((high << 8) | low);
  code_count++;
}

// Mean over the conversions since the last call; 0 where there is none, or it is at a rail.
float conductance_S() {
  if (code_count == 0) return 0.0f;
  float volts = (float)code_sum / (float)code_count * LSB_V;
  code_sum = 0, code_count = 0;
  if (volts < RAIL_V || volts > SUPPLY_V - RAIL_V) return 0.0f;
  return volts / (REFERENCE_OHM * (SUPPLY_V - volts));
}

void setup() {
  Serial.begin(115200);
  Wire.begin();
  Wire.setClock(400000);
  write_register(0x01, 0x4283);  // A0 against ground, +-4.096 V, continuous, 128 SPS, comparator off
  Wire.beginTransmission(ADS1115);
  Wire.write(0x00);  // point at the conversion register, for all reads to come
  Wire.endTransmission();
  knit_reset(&compensator);
  conversion_due_us = micros() + 2 * CONVERSION_US;  // until then its register holds no conversion
  sample_due_us = conversion_due_us + SAMPLE_US;
}

void loop() {
  take_conversion_if_due();
  uint32_t now = micros();
  if ((int32_t)(now - sample_due_us) < 0) return;
  sample_due_us = now + SAMPLE_US;
  float reading = conductance_S();
  if (begun && now - good_us > PAUSE_US) knit_reset(&compensator), begun = false;
  uint32_t cycles = ESP.getCycleCount();
  float value = knit_update(&compensator, reading, (float)(now - good_us) * 1e-6f);
  cycles = ESP.getCycleCount() - cycles;
  if ((compensator.status & (KNIT_BAD_READING | KNIT_BAD_STEP)) == 0) good_us = now, begun = true;
  char line[112];  // the longest line has 97: a float may be -3.4e38, written out
  int size = snprintf(line, sizeof line, "%lu,%.8e,%.5f,%lu,%lu\n", (unsigned long)now, (double)reading, (double)value,
                      (unsigned long)compensator.status, (unsigned long)cycles);
  if (size >= (int)sizeof line) size = (int)sizeof line - 1;  // snprintf says what it would have written
  if (size > 0) Serial.write((const uint8_t *)line, (size_t)size);
}
