// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/result/finding.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {
namespace {

constexpr std::array<std::string_view, 4> kHealthNames{"good", "warn", "bad", "unknown"};  // by Health

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  if (!found->is_string()) throw std::runtime_error(std::string("doctor: ") + key + " is not a text");
  return found->get<std::string>();
}

Health health_of(const std::string& word) {
  const auto found = std::ranges::find(kHealthNames, word);
  if (found == kHealthNames.end()) throw std::runtime_error("doctor: no verdict is called '" + word + "'");
  return static_cast<Health>(found - kHealthNames.begin());
}

}  // namespace

const char* to_string(Health health) { return kHealthNames[static_cast<std::size_t>(health)].data(); }

Health DoctorReport::verdict() const {
  Health worst = Health::unknown;
  for (const Finding& finding : findings) {
    if (finding.verdict == Health::unknown) continue;
    if (worst == Health::unknown || finding.verdict > worst) worst = finding.verdict;
  }
  return worst;
}

std::string DoctorReport::summary() const {
  if (findings.empty()) return note;
  std::array<std::size_t, kHealthNames.size()> count{};
  std::string bad;
  for (const Finding& finding : findings) {
    ++count[static_cast<std::size_t>(finding.verdict)];
    if (finding.verdict == Health::bad) bad += (bad.empty() ? "" : ", ") + finding.name;
  }
  std::string text;
  const auto add = [&text](std::size_t n, const char* what) {
    if (n > 0) text += (text.empty() ? "" : ", ") + std::to_string(n) + what;
  };
  add(count[static_cast<std::size_t>(Health::warn)], " to improve");
  add(count[static_cast<std::size_t>(Health::good)], " good");
  add(count[static_cast<std::size_t>(Health::unknown)], " unknown");
  if (!bad.empty()) text = "bad: " + bad + (text.empty() ? "" : "; ") + text;
  return text;
}

Json to_json(const DoctorReport& report) {
  Json findings = Json::array();
  for (const Finding& f : report.findings) {
    findings.push_back({{"name", f.name},
                        {"value", f.value},
                        {"verdict", to_string(f.verdict)},
                        {"why", f.why},
                        {"cure", f.cure}});
  }
  Json object{
      {"verdict", to_string(report.verdict())}, {"summary", report.summary()}, {"machine", report.machine}};
  if (!report.note.empty()) object["note"] = report.note;
  object["findings"] = std::move(findings);
  return object;
}

DoctorReport doctor_from_json(const Json& object) {
  if (!object.is_object()) throw std::runtime_error("doctor: is no JSON object");
  DoctorReport report;
  report.present = true;
  report.machine = text_of(object, "machine");
  report.note = text_of(object, "note");
  const auto findings = object.find("findings");
  if (findings == object.end()) return report;
  if (!findings->is_array()) throw std::runtime_error("doctor: findings is not a list");
  for (const Json& one : *findings) {
    if (!one.is_object()) throw std::runtime_error("doctor: a finding is no JSON object");
    report.findings.push_back({text_of(one, "name"), text_of(one, "value"),
                               health_of(text_of(one, "verdict")), text_of(one, "why"),
                               text_of(one, "cure")});
  }
  return report;
}

}  // namespace sortie::firmware
