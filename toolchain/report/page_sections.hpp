// SPDX-License-Identifier: BSD-3-Clause
// The sections of the page that have files of their own, and what all sections share.
#pragma once

#include <string>
#include <vector>

#include "toolchain/report/html.hpp"

namespace sortie::toolchain {

/// A cell of a table. `kind`: "n" number, "t" text, "u" unit, of the page's style.
inline std::string table_cell(const std::string& text, const char* kind = "n") {
  return std::string("<td class=\"") + kind + "\">" + escape_xml(text) + "</td>";
}

/// What the page calls a run.
inline std::string scene_name(const ReportInput& input) {
  return input.results.scene.empty() ? "run" : input.results.scene;
}

/// A table of all findings of the doctor, worst first, with why and cure of what is not good; empty when
/// nobody looked.
std::string doctor_section(const firmware::DoctorReport& report);

/// The declared table and the chains, what was computed beside what was measured; each empty where there is
/// nothing to show.
std::string schedule_section(const firmware::Results& results);

/// What a page about several runs begins with: a table with a row a run, each with a link to `run1`, `run2`,
/// ... on the same page.
std::string overview(const std::vector<ReportInput>& inputs);

/// The ways of all runs from above, over the dots of `ground`; it may be empty.
Plot plot_ways(const std::vector<ReportInput>& inputs, const Plot& ground);

}  // namespace sortie::toolchain
