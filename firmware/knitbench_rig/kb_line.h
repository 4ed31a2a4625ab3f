/* One line of knitbench's wire protocol K1 (docs/wire.md): integers in, characters out.
 *
 * No floating-point printing, no heap, no printf: it costs about 20 us on an ESP32. Plain C, so that the same file is
 * compiled on a PC and tested against the Python decoder (tests/testbench/rig/test_firmware.py).
 */
#ifndef KB_LINE_H
#define KB_LINE_H

#include <stddef.h>
#include <stdint.h>

#define KB_LINE_MAX 96 /* the longest line, with its line feed */

typedef struct {
  uint32_t boot;            /* random at every boot */
  uint32_t sequence;        /* 0, 1, 2, ... since boot */
  uint32_t micros;          /* micros(), wraps */
  int32_t force_uN;         /* used if has_force */
  uint64_t resistance_mohm; /* used if has_resistance; below 10^15 */
  int32_t displacement_nm;
  int32_t temperature_mC;   /* used if has_temperature */
  uint8_t has_force, has_resistance, has_temperature;
} kb_sample;

static char *kb_unsigned(char *at, uint64_t value) {
  char digits[20];
  int count = 0;
  do {
    digits[count++] = (char)('0' + value % 10);
    value /= 10;
  } while (value);
  while (count) *at++ = digits[--count];
  return at;
}

static char *kb_signed(char *at, int32_t value) {
  if (value < 0) *at++ = '-';
  return kb_unsigned(at, value < 0 ? 0u - (uint32_t)value : (uint32_t)value);
}

static char *kb_hex32(char *at, uint32_t value) {
  for (int shift = 28; shift >= 0; shift -= 4) *at++ = "0123456789abcdef"[(value >> shift) & 15];
  return at;
}

/* CRC-32 as in zlib, PNG and Ethernet. */
static uint32_t kb_crc32(const char *data, size_t size) {
  uint32_t crc = 0xFFFFFFFFu;
  for (size_t i = 0; i < size; i++) {
    crc ^= (uint8_t)data[i];
    for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

/* Write the line of `s` into `out` (at least KB_LINE_MAX characters, not terminated) and return its length. */
static size_t kb_line(char *out, const kb_sample *s) {
  char *at = out;
  *at++ = '$', *at++ = 'K', *at++ = '1', *at++ = ',';
  at = kb_hex32(at, s->boot);
  *at++ = ',';
  at = kb_unsigned(at, s->sequence);
  *at++ = ',';
  at = kb_unsigned(at, s->micros);
  *at++ = ',';
  if (s->has_force) at = kb_signed(at, s->force_uN);
  *at++ = ',';
  if (s->has_resistance) at = kb_unsigned(at, s->resistance_mohm);
  *at++ = ',';
  at = kb_signed(at, s->displacement_nm);
  if (s->has_temperature) {
    *at++ = ',';
    at = kb_signed(at, s->temperature_mC);
  }
  uint32_t crc = kb_crc32(out + 1, (size_t)(at - out - 1));
  *at++ = '*';
  at = kb_hex32(at, crc);
  *at++ = '\n';
  return (size_t)(at - out);
}

#endif
