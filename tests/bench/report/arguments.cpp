// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/report/arguments.hpp"

#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace sortie::bench {

double number(const char* option, const char* text, double low, double high) {
  char* end = nullptr;
  const double value = text != nullptr ? std::strtod(text, &end) : 0;
  if (text == nullptr || end == text || *end != '\0' || !(value >= low && value <= high)) {
    throw std::invalid_argument(std::string(option) + " takes a number from " + std::to_string(low) + " to " +
                                std::to_string(high));
  }
  return value;
}

std::string load_average() {
  std::ifstream in("/proc/loadavg");
  std::string one;
  in >> one;
  return one;
}

}  // namespace sortie::bench
