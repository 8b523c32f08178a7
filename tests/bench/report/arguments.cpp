// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/report/arguments.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
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

void read_arguments(int argc, char** argv, std::initializer_list<Argument> known) {
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i];
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&option](const Argument& argument) { return option == argument.name; });
    if (found == known.end()) throw std::invalid_argument("unknown option " + option);
    if (i + 1 == argc) throw std::invalid_argument(option + " needs a value");
    found->take(argv[i + 1]);
  }
}

int guarded_main(const char* program, const std::function<int()>& run) {
  try {
    return run();
  } catch (const std::invalid_argument& error) {
    std::cerr << program << ": " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << program << ": " << error.what() << "\n";
    return 3;
  }
}

std::string load_average() {
  std::ifstream in("/proc/loadavg");
  std::string one;
  in >> one;
  return one;
}

}  // namespace sortie::bench
