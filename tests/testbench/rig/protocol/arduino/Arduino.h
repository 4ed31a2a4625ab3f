// Just enough Arduino to run the reference firmware on a PC: a clock that moves when it is read, pins that follow a script.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstdio>

#define IRAM_ATTR
enum { LOW, HIGH, INPUT, OUTPUT, INPUT_PULLUP, CHANGE };

static uint32_t fake_us = 4294000000u;  // wraps after a second
static uint32_t micros() { return fake_us += 7; }
static void delayMicroseconds(uint32_t us) { fake_us += us; }

// The load cell: data goes low when a conversion is ready, then gives 24 bits, highest first. The first conversion
// takes a while, and there is none once the chip has stopped.
static const uint32_t FIRST_CONVERSION_US = 52000;
static const uint32_t begun_us = fake_us;
static bool cell_stopped = false;
static const int32_t CELL_CODE = -123456;
static int cell_bit = -1, clock_level = LOW;
static void digitalWrite(int, int level) {
  if (level == HIGH && clock_level == LOW) cell_bit++;
  clock_level = level;
}
static int digitalRead(int pin) {
  if (pin != 21) return LOW;
  if (cell_bit < 0) return cell_stopped || fake_us - begun_us < FIRST_CONVERSION_US ? HIGH : LOW;
  if (cell_bit >= 24) return cell_bit = -1, HIGH;
  return (CELL_CODE >> (23 - cell_bit)) & 1 ? HIGH : LOW;
}
static void pinMode(int, int) {}
static int digitalPinToInterrupt(int pin) { return pin; }
static void (*edges[2])();
static int edge_count = 0;
static void attachInterrupt(int, void (*edge)(), int) { edges[edge_count++] = edge; }

struct FakeSerial {
  void begin(long) {}
  void write(const uint8_t *data, size_t size) { fwrite(data, 1, size, stdout); }
};
static FakeSerial Serial;
