// An ADS1115 that reads one code after another from stdin; at the end of them nothing is available.
// Its register holds nothing before the first conversion.
#pragma once
#include <cstdint>
#include <cstdio>

#include "Arduino.h"

struct FakeWire {
  int code = 0, left = 0;
  bool over = false;
  uint32_t set_up_us = 0;
  void begin() { set_up_us = fake_us; }
  void setClock(long) {}
  void beginTransmission(uint8_t) {}
  void write(uint8_t) {}
  void endTransmission() {}
  void requestFrom(uint8_t, uint8_t) {
    code = 0, left = 2;
    if (fake_us - set_up_us < 7813) return;
    over = scanf("%d", &code) != 1;
    left = over ? 0 : 2;
  }
  int available() { return left; }
  int read() { return left-- == 2 ? (code >> 8) & 255 : code & 255; }
};
static FakeWire Wire;
