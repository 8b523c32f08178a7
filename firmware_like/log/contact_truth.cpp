// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/contact_truth.hpp"

#include <algorithm>

#include "drivers/wire_truth.hpp"
#include "firmware_like/log/log_file.hpp"

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
  std::ranges::copy(truth.flipper_asked_rad, summary.flipper_asked_rad);
  std::ranges::copy(truth.flipper_angle_rad, summary.flipper_angle_rad);
  std::ranges::copy(truth.flipper_torque_n_m, summary.flipper_torque_n_m);
  return summary;
}

std::vector<ContactSummary> contact_summaries(const LogFile& log, std::int64_t offset_ns) {
  std::vector<ContactSummary> summaries;
  for_each_contact_truth(
      log, [&summaries](const rt::ContactTruth& truth) { summaries.push_back(summarise(truth)); }, offset_ns);
  return summaries;
}

}  // namespace sortie::firmware
