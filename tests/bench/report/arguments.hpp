// SPDX-License-Identifier: BSD-3-Clause
// What the benchmark programs read: numbers after options, and how busy the machine is.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>

namespace sortie::bench {

/// The number after an option. Throws std::invalid_argument with the range where there is none in it.
double number(const char* option, const char* text, double low, double high);

/// An option that has a value, and where that goes.
struct Argument {
  const char* name;
  std::function<void(const char*)> take;
  Argument(const char* option, std::string& text)
      : name(option), take([&text](const char* value) { text = value; }) {}
  /// A number from `low` to `high`; what is written behind the point of a whole one is dropped.
  template <class Number>
  Argument(const char* option, Number& into, double low, double high)
      : name(option), take([option, &into, low, high](const char* value) {
          into = static_cast<Number>(number(option, value, low, high));
        }) {}
};

/// Options with a value each, in any order. Throws std::invalid_argument where one is not known or has none.
void read_arguments(int argc, char** argv, std::initializer_list<Argument> known);

/// Runs a benchmark's main and turns what it throws into a line on stderr: exit code 2 for arguments, 3 for
/// the rest.
int guarded_main(const char* program, const std::function<int()>& run);

/// Mean number of processes that wanted to run in the last minute, as the kernel writes it.
std::string load_average();

}  // namespace sortie::bench
