// SPDX-License-Identifier: BSD-3-Clause
// A cell of a table on a page.
#pragma once

#include <string>

#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// `kind`: "n" number, "t" text, "u" unit, of the page's style.
inline std::string table_cell(const std::string& text, const char* kind = "n") {
  return std::string("<td class=\"") + kind + "\">" + escape_xml(text) + "</td>";
}

}  // namespace sortie::toolchain
