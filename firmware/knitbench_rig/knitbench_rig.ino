// Reference firmware of knitbench's rig, for an Adafruit HUZZAH32 (ESP32) with the Arduino core.
//
//   load cell (10 kg, 2 mV/V at 5 V)  ->  ADS1231, SPEED pin high (80 SPS), bit-banged
//   sensor in a 606 kOhm divider      ->  ADS1115 channel A0, 128 SPS, +-4.096 V, averaged over 25 ms
//   quadrature encoder                ->  two interrupts, 1.25 um a count
//
// Everything that another bench has different is in the block of constants below. The loop asks for a line as often as
// it comes round; nothing here waits, so a slow host only makes lines wait in the UART's buffer.

#include <Arduino.h>
#include <Wire.h>
#include <esp_random.h>

#include "kb_line.h"

// --- the bench -----------------------------------------------------------------------------------------------------
const int PIN_CELL_DATA = 21, PIN_CELL_CLOCK = 17;   // ADS1231 DRDY/DOUT and SCLK
const int PIN_ENCODER_A = 14, PIN_ENCODER_B = 32;
const uint8_t ADS1115 = 0x48;                        // I2C address with ADDR to ground
const double UN_PER_CELL_CODE = 22.83;               // micronewton: 19.53 mV / 2^23 over 0.102 mV/N
const int32_t CELL_ZERO_CODE = 0;                    // reading of the unloaded cell
const bool HAS_CELL = true;                          // false: a bench without a load cell
const double SUPPLY_V = 3.3, REFERENCE_OHM = 606e3, LSB_V = 125e-6;
const int32_t NM_PER_COUNT = 1250;
const uint32_t LINE_EVERY_US = 24096;                // 41.5 lines a second
const uint32_t AVERAGE_US = 25000;
const uint32_t CONVERSION_US = 1000000 / 128;        // of the ADS1115
const uint32_t CELL_STALE_US = 250000;               // 20 conversions of the cell's ADC: it does not answer any more
const uint64_t OPEN_MOHM = 1000000000000000ull - 1;  // what an open circuit reads as

// --- encoder -------------------------------------------------------------------------------------------------------
volatile int32_t encoder_count = 0;

void IRAM_ATTR encoder_edge_a() {
  encoder_count += digitalRead(PIN_ENCODER_A) == digitalRead(PIN_ENCODER_B) ? 1 : -1;
}

void IRAM_ATTR encoder_edge_b() {
  encoder_count += digitalRead(PIN_ENCODER_A) == digitalRead(PIN_ENCODER_B) ? -1 : 1;
}

// --- load cell: ADS1231 data sheet, figure "24-bit retrieval" ------------------------------------------------------
int32_t cell_code = 0;
uint32_t cell_us = 0;
bool cell_known = false;

void read_cell_if_ready() {
  if (digitalRead(PIN_CELL_DATA) == HIGH) return;  // low: a conversion is ready
  uint32_t code = 0;
  for (int bit = 0; bit < 24; bit++) {
    digitalWrite(PIN_CELL_CLOCK, HIGH);
    delayMicroseconds(1);
    code = (code << 1) | (digitalRead(PIN_CELL_DATA) == HIGH);
    digitalWrite(PIN_CELL_CLOCK, LOW);
    delayMicroseconds(1);
  }
  digitalWrite(PIN_CELL_CLOCK, HIGH);  // a 25th pulse forces the data line high until the next conversion
  delayMicroseconds(1);
  digitalWrite(PIN_CELL_CLOCK, LOW);
  cell_code = (int32_t)(code << 8) >> 8;  // sign-extend 24 bits
  cell_us = micros();
  cell_known = true;
}

// A force that stands still, or one that was never read, would be taken for a measured one: no line is sent then.
bool cell_answers(uint32_t now) {
  if (!HAS_CELL) return true;
  cell_known = cell_known && now - cell_us <= CELL_STALE_US;
  return cell_known;
}

// --- divider: ADS1115 in continuous mode, the last conversions in a ring -------------------------------------------
const int RING = 8;  // at 128 SPS 25 ms hold 3 or 4
int16_t ring_code[RING];
uint32_t ring_us[RING], ring_next = 0, ring_filled = 0, adc_due_us = 0;

void write_register(uint8_t address, uint16_t value) {
  Wire.beginTransmission(ADS1115);
  Wire.write(address);
  Wire.write((uint8_t)(value >> 8));
  Wire.write((uint8_t)(value & 0xFF));
  Wire.endTransmission();
}

void read_divider_if_due() {
  if ((int32_t)(micros() - adc_due_us) < 0) return;
  adc_due_us += CONVERSION_US;
  Wire.requestFrom(ADS1115, (uint8_t)2);
  if (Wire.available() < 2) return;
  uint16_t high = Wire.read(), low = Wire.read();
  ring_code[ring_next] = (int16_t)((high << 8) | low);
  ring_us[ring_next] = micros();
  ring_next = (ring_next + 1) % RING;
  if (ring_filled < (uint32_t)RING) ring_filled++;
}

bool resistance(uint64_t *mohm) {
  uint32_t now = micros();
  double sum = 0;
  int count = 0;
  for (uint32_t i = 0; i < ring_filled; i++) {
    if (now - ring_us[i] <= AVERAGE_US) sum += ring_code[i], count++;
  }
  if (!count) return false;
  double volts = sum / count * LSB_V;
  if (volts < LSB_V / 4) volts = LSB_V / 4;
  if (volts > SUPPLY_V - LSB_V / 4) volts = SUPPLY_V - LSB_V / 4;
  double value = REFERENCE_OHM * (SUPPLY_V - volts) / volts * 1e3;
  *mohm = value < (double)OPEN_MOHM ? (uint64_t)(value + 0.5) : OPEN_MOHM;
  return true;
}

// --- the line ------------------------------------------------------------------------------------------------------
kb_sample sample;
uint32_t line_due_us = 0;

void setup() {
  Serial.begin(115200);
  pinMode(PIN_CELL_DATA, INPUT);
  pinMode(PIN_CELL_CLOCK, OUTPUT);
  pinMode(PIN_ENCODER_A, INPUT_PULLUP);
  pinMode(PIN_ENCODER_B, INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(PIN_ENCODER_A), encoder_edge_a, CHANGE);
  attachInterrupt(digitalPinToInterrupt(PIN_ENCODER_B), encoder_edge_b, CHANGE);
  Wire.begin();
  Wire.setClock(400000);
  write_register(0x01, 0x4283);  // A0 against ground, +-4.096 V, continuous, 128 SPS, comparator off
  Wire.beginTransmission(ADS1115);
  Wire.write(0x00);  // point at the conversion register, for all reads to come
  Wire.endTransmission();
  sample.boot = esp_random();
  sample.has_force = HAS_CELL;
  line_due_us = micros();
  adc_due_us = line_due_us + 2 * CONVERSION_US;  // until then its register holds no conversion
}

void loop() {
  read_cell_if_ready();
  read_divider_if_due();
  uint32_t now = micros();
  if ((int32_t)(now - line_due_us) < 0) return;
  line_due_us = now + LINE_EVERY_US;
  // The first line comes when both chips have finished a conversion.
  if (!cell_answers(now) || !resistance(&sample.resistance_mohm)) return;
  sample.has_resistance = 1;
  sample.micros = now;
  sample.force_uN = (int32_t)lround((cell_code - CELL_ZERO_CODE) * UN_PER_CELL_CODE);
  sample.displacement_nm = encoder_count * NM_PER_COUNT;
  char line[KB_LINE_MAX];
  Serial.write((const uint8_t *)line, kb_line(line, &sample));
  sample.sequence++;
}
