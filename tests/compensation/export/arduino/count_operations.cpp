// The exported header with a float that counts what is done with it: operations of one sample in steady use.
// Its argument is the time step in s.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

static unsigned long multiplied, added, divided, compared;

struct Counted {
  double v;
  Counted() : v(0) {}
  Counted(double x) : v(x) {}
  Counted operator-() const { return Counted(-v); }
};
static Counted operator*(Counted a, Counted b) { return multiplied++, Counted(a.v * b.v); }
static Counted operator/(Counted a, Counted b) { return divided++, Counted(a.v / b.v); }
static Counted operator+(Counted a, Counted b) { return added++, Counted(a.v + b.v); }
static Counted operator-(Counted a, Counted b) { return added++, Counted(a.v - b.v); }
static Counted &operator+=(Counted &a, Counted b) { return a = a + b; }
static Counted &operator*=(Counted &a, Counted b) { return a = a * b; }
static bool operator<(Counted a, Counted b) { return compared++, a.v < b.v; }
static bool operator>(Counted a, Counted b) { return compared++, a.v > b.v; }
static bool operator<=(Counted a, Counted b) { return compared++, a.v <= b.v; }
static bool operator>=(Counted a, Counted b) { return compared++, a.v >= b.v; }

#define float Counted
#include "knit.h"
#undef float

int main(int, char **words) {
  knit_state state;
  knit_reset(&state);
  double conductance_S = 0;
  while (scanf("%lf", &conductance_S) == 1) {
    multiplied = added = divided = compared = 0;
    knit_update(&state, conductance_S, atof(words[1]));
  }
  printf("%lu %lu %lu %lu\n", multiplied, added, divided, compared);
}
