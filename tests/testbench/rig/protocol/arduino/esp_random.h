#pragma once
#include <cstdint>

static uint32_t esp_random() { return 0x5f3a9c01u; }
