// SPDX-License-Identifier: BSD-3-Clause
// What digests rest on: that a board computes with doubles as a desktop does. Prints a hash for each
// operation over the same 100,000 operands, with those that rounding finds hard among them.
#include <bit>
#include <cmath>
#include <cstdint>

#include "firmware_like/bare_metal/board.hpp"
#include "rt/math.hpp"

using namespace sortie;

namespace {

constexpr int kRounds = 10000;

// xorshift64 (Marsaglia 2003).
std::uint64_t draw() {
  static std::uint64_t state = 88172645463325252u;
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return state;
}

// Bits of all kinds: infinities, NaN, denormals, the far ends.
double anything() { return std::bit_cast<double>(draw()); }

// Size between 2^-40 and 2^40; every other one a power of two: a little less needs one digit more.
double middling() {
  const std::uint64_t bits = draw();
  const std::uint64_t fraction = (draw() & 1) != 0 ? 0 : bits & 0xfffffffffffffu;
  return std::bit_cast<double>((bits & (std::uint64_t{1} << 63)) | (983 + (bits >> 52) % 80) << 52 |
                               fraction);
}

std::uint64_t whole() { return draw() >> draw() % 64; }

double denormal() { return std::bit_cast<double>(draw() & 0x801fffffffffffffu); }

double neighbour(double x) { return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) + draw() % 7 - 3); }

struct Hash {
  std::uint64_t value{};
  void take(std::uint64_t word) {
    value = (value ^ word) * 0x9e3779b97f4a7c15u;
    value ^= value >> 29;
  }
  // Every NaN is one.
  void take(double x) { take(x != x ? std::uint64_t{0x7ff8} << 48 : std::bit_cast<std::uint64_t>(x)); }
};

void print_hash(const char* name, const Hash& hash) {
  char text[20] = "\":\"";
  for (int i = 0; i < 16; ++i) text[3 + i] = "0123456789abcdef"[hash.value >> (60 - 4 * i) & 15];
  bare::print(name);
  bare::print(text);
}

// Operands are read as volatile, so that no compiler computes for the board.
template <class Operation>
void over_pairs(const char* name, Operation operation) {
  Hash hash;
  for (int i = 0; i < kRounds; ++i) {
    const double first = middling();
    const double pairs[][2] = {{anything(), anything()},
                               {middling(), middling()},
                               {first, neighbour(first)},
                               {denormal(), denormal()},
                               {1.0, middling()}};
    for (const auto& pair : pairs) {
      volatile double a = pair[0];
      volatile double b = pair[1];
      hash.take(operation(a, b));
      hash.take(operation(b, a));
    }
  }
  print_hash(name, hash);
}

template <class Number, class Operation>
void over(Number (&next)(), const char* name, Operation operation) {
  Hash hash;
  for (int i = 0; i < kRounds; ++i) {
    volatile Number x = next();
    hash.take(operation(x));
  }
  print_hash(name, hash);
}

}  // namespace

int main() {
  over_pairs("{\"sum", [](double a, double b) { return a + b; });
  over_pairs("\",\"difference", [](double a, double b) { return a - b; });
  over_pairs("\",\"product", [](double a, double b) { return a * b; });
  over_pairs("\",\"quotient", [](double a, double b) { return a / b; });
  over_pairs("\",\"root", [](double a, double) { return std::sqrt(std::fabs(a)); });
  over_pairs("\",\"comparison", [](double a, double b) {
    return std::uint64_t{a < b} | std::uint64_t{a <= b} << 1 | std::uint64_t{a == b} << 2;
  });
  over(whole, "\",\"from 64 bits", [](std::uint64_t n) { return static_cast<double>(n); });
  over(whole, "\",\"from 64 bits with a sign",
       [](std::uint64_t n) { return static_cast<double>(static_cast<std::int64_t>(n)); });
  over(whole, "\",\"from 32 bits with a sign",
       [](std::uint64_t n) { return static_cast<double>(static_cast<std::int32_t>(n)); });
  over(whole, "\",\"from single precision", [](std::uint64_t n) {
    return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(n)));
  });
  over(middling, "\",\"to 64 bits",
       [](double x) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)); });
  over(middling, "\",\"floor", [](double x) { return rt::floor(x); });
  over(middling, "\",\"sine", [](double x) { return rt::sin(x); });
  over(middling, "\",\"arc tangent", [](double x) { return rt::atan2(x, 1.0); });
  over(middling, "\",\"exponential", [](double x) { return rt::exp(x); });
  over(middling, "\",\"logarithm", [](double x) { return rt::log(std::fabs(x)); });
  bare::print("\"}\n");
  bare::stop(0);
}
