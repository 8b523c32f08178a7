// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/report/page_sections.hpp"
#include "toolchain/report/recognised_places.hpp"

namespace sortie::toolchain {
namespace {

// "7", or "7 to 12".
std::string span_of(const Extent& extent, int decimals) {
  const std::string low = firmware::format_fixed(extent.low, decimals),
                    high = firmware::format_fixed(extent.high, decimals);
  return low == high ? low : low + " to " + high;
}

// Answers of one verdict that followed one another.
std::string row_of(std::span<const RecognisedAnswer> answers) {
  Extent time_s, agree, rival, share, crossed;
  for (const RecognisedAnswer& answer : answers) {
    time_s.take(answer.time_s);
    agree.take(answer.place.agree);
    rival.take(answer.place.rival);
    share.take(100.0 * answer.place.share);
    crossed.take(100.0 * answer.place.crossed);
  }
  const std::uint8_t verdict = answers[0].place.verdict;
  const bool has_set = agree.high > 0.0;
  const bool has_scan =
      verdict == rt::RecognisedPlace::kRecognised || verdict == rt::RecognisedPlace::kRefused;
  const std::string colour = palette(verdict_colour(verdict));
  return "<tr>" + table_cell(span_of(time_s, 1)) + table_cell(firmware::group_digits(answers.size())) +
         "<td class=\"t\"><svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\" "
         "role=\"img\"><circle cx=\"4.5\" cy=\"4.5\" r=\"4\" fill=\"" +
         (has_set ? colour : std::string(palette(kGrey))) + "\"/></svg> " +
         escape_xml(verdict_words(verdict)) + "</td>" + table_cell(has_set ? span_of(agree, 0) : "-") +
         table_cell(has_set ? span_of(rival, 0) : "-") +
         table_cell(has_scan ? span_of(share, 0) + " %" : "-") +
         table_cell(has_scan ? span_of(crossed, 1) + " %" : "-") + "</tr>\n";
}

}  // namespace

RecognisedReport report_of(const RecognisedPlaces& places, std::span<const firmware::TimedPose> path) {
  RecognisedReport report{places.answers(), {}, {}};
  if (places.accepted()) report.accepted = plot_recognised(*places.accepted(), places.known(), path);
  if (places.refused()) report.refused = plot_recognised(*places.refused(), places.known(), path);
  return report;
}

std::string recognised_section(const RecognisedReport& report) {
  if (report.answers.empty()) return {};
  std::string out = "<h2>Recognised places</h2>\n";
  for (const Plot* plot : {&report.accepted, &report.refused}) {
    if (!plot->series.empty()) out += render(*plot);
  }
  out +=
      "<table class=\"recognised\"><thead><tr><th class=\"n\">time, s</th><th class=\"n\">answers</th>"
      "<th>verdict</th><th class=\"n\">segments agree</th><th class=\"n\">next place</th>"
      "<th class=\"n\">scan on surfaces</th><th class=\"n\">through them</th></tr></thead>\n<tbody>";
  const std::span<const RecognisedAnswer> all = report.answers;
  for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
    while (to < all.size() && all[to].place.verdict == all[from].place.verdict) ++to;
    out += row_of(all.subspan(from, to - from));
  }
  return out +
         "</tbody></table>\n<p class=\"note\">A row for answers of one verdict that follow one another. "
         "Segments agree: correspondences in the largest set, and in that of the next place. Scan: share of "
         "its returns on the map's surfaces, and of its rays that go through one.</p>\n";
}

}  // namespace sortie::toolchain
