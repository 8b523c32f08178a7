// SPDX-License-Identifier: BSD-3-Clause
// Stiff and extreme cases: each has the method of this repository, the naive one, and a bound that tells them
// apart. catalogue.cpp is the table of them.
#pragma once

#include <span>
#include <string>

namespace sortie::bench {

/// What both methods made of a case, in the case's unit. Not a number and infinity are outside every bound.
struct StabilityFigures {
  double ours{};
  double naive{};
};

/// One case of the catalogue.
struct StabilityCase {
  const char* group;  ///< folder whose code is tried
  const char* name;
  const char* why;      ///< it is hard
  const char* naive;    ///< what the mutant does; it is run
  const char* ours;     ///< what ours does
  const char* measure;  ///< what the figures say, with the unit
  double bound;         ///< most that is good
  StabilityFigures (*run)();
  bool heavy{false};  ///< takes seconds in a debug build
};

/// All cases, group by group. Cost of running them all: seconds.
std::span<const StabilityCase> stability_cases();

/// Whether a figure is good. Written so that what is not a number is not.
constexpr bool within(double figure, double bound) { return figure <= bound; }

/// The catalogue as Markdown, what docs/stability.md holds below its introduction.
std::string stability_catalogue();

}  // namespace sortie::bench
