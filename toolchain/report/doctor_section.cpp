// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "toolchain/report/page_sections.hpp"

namespace sortie::toolchain {
namespace {

int rank(firmware::Health health) {
  return health == firmware::Health::bad       ? 0
         : health == firmware::Health::warn    ? 1
         : health == firmware::Health::unknown ? 2
                                               : 3;
}

}  // namespace

std::string doctor_section(const firmware::DoctorReport& report) {
  if (!report.present) return {};
  std::string out = "<h2>Board</h2>\n";
  if (report.findings.empty()) return out + "<p class=\"note\">" + escape_xml(report.note) + "</p>\n";
  std::vector<const firmware::Finding*> order;
  for (const firmware::Finding& finding : report.findings) order.push_back(&finding);
  std::stable_sort(order.begin(), order.end(), [](const firmware::Finding* a, const firmware::Finding* b) {
    return rank(a->verdict) < rank(b->verdict);
  });
  out.append("<p>").append(escape_xml(report.summary())).append(". <span class=\"u\">");
  out.append(escape_xml(report.machine)).append("</span></p>\n");
  if (!report.note.empty()) out += "<p class=\"note\">" + escape_xml(report.note) + "</p>\n";
  out += "<table class=\"doctor\"><thead><tr><th></th><th>finding</th><th></th></tr></thead>\n<tbody>";
  for (const firmware::Finding* finding : order) {
    const std::string verdict = to_string(finding->verdict);
    const bool ill = finding->verdict == firmware::Health::bad || finding->verdict == firmware::Health::warn;
    out.append("<tr><td><span class=\"health ").append(verdict).append("\">").append(verdict);
    out.append("</span></td><td>")
        .append(escape_xml(finding->name))
        .append("</td><td>")
        .append(escape_xml(finding->value));
    if (ill) out.append("<br/><span class=\"u\">").append(escape_xml(finding->why)).append("</span>");
    if (ill && !finding->cure.empty())
      out.append("<br/><code>").append(escape_xml(finding->cure)).append("</code>");
    out += "</td></tr>\n";
  }
  return out + "</tbody></table>\n";
}

}  // namespace sortie::toolchain
