// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/evaluation/contact_truth.hpp"

#include <algorithm>

#include "drivers/wire_contacts.hpp"
#include "firmware_like/log_file.hpp"

namespace sortie::firmware {

std::size_t for_each_contact_truth(const LogFile& log,
                                   const std::function<void(const rt::ContactTruth&)>& visit,
                                   std::int64_t offset_ns) {
  std::size_t damaged = 0;
  rt::ContactTruth truth;
  for (const StoredEvent& stored : log.channel(std::string(drivers::kChannelContacts))) {
    if (drivers::decode(stored.message, truth) != Status::ok) {
      ++damaged;
      continue;
    }
    // Unsigned: a damaged stamp must not overflow.
    truth.stamp_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(truth.stamp_ns) +
                                               static_cast<std::uint64_t>(offset_ns));
    visit(truth);
  }
  return damaged;
}

std::vector<rt::ContactTruth> read_contact_truth(const LogFile& log, std::int64_t offset_ns) {
  std::vector<rt::ContactTruth> records;
  for_each_contact_truth(
      log, [&records](const rt::ContactTruth& truth) { records.push_back(truth); }, offset_ns);
  std::stable_sort(records.begin(), records.end(), [](const rt::ContactTruth& a, const rt::ContactTruth& b) {
    return a.stamp_ns < b.stamp_ns;
  });
  return records;
}

const rt::ContactTruth* contact_truth_at(std::span<const rt::ContactTruth> records, std::int64_t stamp_ns,
                                         std::int64_t most_apart_ns) {
  const auto after = std::lower_bound(
      records.begin(), records.end(), stamp_ns,
      [](const rt::ContactTruth& truth, std::int64_t stamp) { return truth.stamp_ns < stamp; });
  const rt::ContactTruth* nearest = nullptr;
  std::int64_t apart = most_apart_ns;
  // The earlier one first: of two that are as near it wins.
  if (after != records.begin() && stamp_ns - (after - 1)->stamp_ns <= apart) {
    nearest = &*(after - 1);
    apart = stamp_ns - nearest->stamp_ns - 1;
  }
  if (after != records.end() && after->stamp_ns - stamp_ns <= apart) nearest = &*after;
  return nearest;
}

ContactSummary summarise(const rt::ContactTruth& truth) {
  ContactSummary summary;
  summary.stamp_ns = truth.stamp_ns;
  summary.dropped = truth.dropped;
  const double step_s = rt::to_seconds(truth.step_ns);
  for (const rt::TruthContact& contact : truth.contacts) {
    const auto part = static_cast<std::size_t>(contact.part);
    ++summary.contacts[part];
    if (step_s > 0) summary.load_n[part] += contact.normal_impulse_n_s / step_s;
  }
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    summary.flipper_asked_rad[i] = truth.flipper_asked_rad[i];
    summary.flipper_angle_rad[i] = truth.flipper_angle_rad[i];
    summary.flipper_torque_n_m[i] = truth.flipper_torque_n_m[i];
  }
  return summary;
}

std::vector<ContactSummary> contact_summaries(const LogFile& log, std::int64_t offset_ns) {
  std::vector<ContactSummary> summaries;
  for_each_contact_truth(
      log, [&summaries](const rt::ContactTruth& truth) { summaries.push_back(summarise(truth)); }, offset_ns);
  return summaries;
}

}  // namespace sortie::firmware
