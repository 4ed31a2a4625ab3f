// Just enough Arduino to run the compensator's sketch on a PC: a clock that moves when it is read.
#pragma once
#include <cstdint>
#include <cstdio>

static uint32_t fake_us = 4294000000u;  // wraps after a second
static uint32_t micros() { return fake_us += 250; }

struct FakeSerial {
  void begin(long) {}
  void write(const uint8_t *data, size_t size) { fwrite(data, 1, size, stdout); }
};
static FakeSerial Serial;

struct FakeEsp {
  uint32_t cycles = 0;
  uint32_t getCycleCount() { return cycles += 4000000000u; }  // as many digits as there may be
};
static FakeEsp ESP;
