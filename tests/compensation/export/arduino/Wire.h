// An ADS1115 that reads one code after another from stdin; at the end of them nothing is available.
#pragma once
#include <cstdint>
#include <cstdio>

struct FakeWire {
  int code = 0, left = 0;
  bool over = false;
  void begin() {}
  void setClock(long) {}
  void beginTransmission(uint8_t) {}
  void write(uint8_t) {}
  void endTransmission() {}
  void requestFrom(uint8_t, uint8_t) {
    over = scanf("%d", &code) != 1;
    left = over ? 0 : 2;
  }
  int available() { return left; }
  int read() { return left-- == 2 ? (code >> 8) & 255 : code & 255; }
};
static FakeWire Wire;
