// SPDX-License-Identifier: BSD-3-Clause
// Contacts in a log: written as often as asked, read back, shown; and never seen by a task.
#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "drivers/wire_truth.hpp"
#include "firmware_like/log/contact_truth.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/export/truth_csv.hpp"
#include "toolchain/report/plots.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// The begin of the drive onto the pallet, with few rays.
LiveRunOutcome run_pallet(double seconds, const std::string& record, std::vector<std::string> more = {}) {
  LiveRunOptions options;
  options.scene = "ugv_pallet";
  options.overrides = {
      "hil.lidar_rows=2", "hil.lidar_columns=60",
      "mission.commands=[{at_s=0.2,posture=\"climb\"},{at_s=0.5,speed_m_s=0.3},{at_s=60.0}]"};
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = record;
  options.lcm_url = "none";
  return run_live(own_vehicles(), make_simulated_robot, options);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<rt::ContactTruth> contacts_of(const LogFile& log, std::int64_t offset_ns = 0) {
  std::vector<rt::ContactTruth> records;
  for_each_contact_truth(
      log, [&records](const rt::ContactTruth& truth) { records.push_back(truth); }, offset_ns);
  return records;
}

}  // namespace

TEST_CASE("no task sees the truth: digests are the same with it, without it and at any rate") {
  const TempFolder folder;
  const LiveRunOutcome usual = run_pallet(2, folder.file("a.lcm"));
  const LiveRunOutcome none = run_pallet(2, folder.file("b.lcm"), {"hil.contact_truth_hz=0"});
  const LiveRunOutcome every = run_pallet(2, folder.file("c.lcm"), {"hil.contact_truth_hz=1000"});
  const LiveRunOutcome unrecorded = run_pallet(2, "");
  CHECK(none.results.digest == usual.results.digest);
  CHECK(every.results.digest == usual.results.digest);
  CHECK(unrecorded.results.digest == usual.results.digest);
  CHECK(usual.contacts.size() == 200);
  CHECK(none.contacts.empty());
  CHECK(every.contacts.size() == 2000);
  CHECK(unrecorded.contacts.size() == usual.contacts.size());

  // Nor does a replay: with another truth in the log, every job is the same.
  rewrite_log(folder.file("a.lcm"), folder.file("d.lcm"), [](EditableEvent& event, std::size_t index) {
    if (event.channel == drivers::kChannelContacts && index % 2 == 0) return false;
    if (event.channel == drivers::kChannelContacts) event.bytes[30] ^= 0x55;
    if (event.channel == drivers::kChannelTruth || event.channel == drivers::kChannelSensorTruth)
      event.bytes[30] ^= 0x55;
    return true;
  });
  const ReplayOutcome replayed = replay_log(folder.file("d.lcm"));
  CHECK(complaint_of(replayed).empty());
  CHECK(replayed.results.digest == usual.results.digest);
  for (const std::string& warning : replayed.results.warnings) CHECK_FALSE(mentions(warning, "TRUTH"));
}

TEST_CASE("contacts come back from a log as the run knew them, by time and without the damaged ones") {
  const TempFolder folder;
  const LiveRunOutcome run = run_pallet(2.5, folder.file("a.lcm"), {"hil.contact_truth_hz=200"});
  const LogFile log(folder.file("a.lcm"));
  const std::vector<rt::ContactTruth> records = contacts_of(log);
  REQUIRE(records.size() == 500);
  REQUIRE(run.contacts.size() == records.size());
  const std::vector<ContactSummary> summaries = contact_summaries(log);
  double most_load = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    CHECK(records[i].stamp_ns == run.contacts[i].stamp_ns);
    double load = 0;
    for (std::uint32_t part = 0; part < rt::kVehicleParts; ++part) {
      CHECK(run.contacts[i].contacts[part] == records[i].count(static_cast<rt::VehiclePart>(part)));
      CHECK(summaries[i].contacts[part] == run.contacts[i].contacts[part]);
      load += summaries[i].load_n[part];
    }
    most_load = std::max(most_load, load);
  }
  CHECK(most_load > 9.81 * 20);  // a robot of 28 kg stands on them

  CHECK(contacts_of(log, 77).front().stamp_ns == records.front().stamp_ns + 77);

  rewrite_log(folder.file("a.lcm"), folder.file("b.lcm"), [](EditableEvent& event, std::size_t index) {
    if (event.channel == drivers::kChannelContacts && index % 10 == 0) event.bytes.pop_back();
    return true;
  });
  const LogFile damaged(folder.file("b.lcm"));
  std::size_t good = 0;
  CHECK(for_each_contact_truth(damaged, [&good](const rt::ContactTruth&) { ++good; }) == 50);
  CHECK(good == 450);
}

TEST_CASE("contacts are exported as tables, drawn in the report, and copied by a replay that records") {
  const TempFolder folder;
  static_cast<void>(run_pallet(1, folder.file("a.lcm")));
  const LogFile log(folder.file("a.lcm"));
  const std::vector<rt::ContactTruth> records = contacts_of(log);
  std::size_t contacts = 0;
  for (const rt::ContactTruth& record : records) contacts += record.contacts.size();
  std::ostringstream table;
  write_contacts_csv(table, log);
  const std::vector<std::string> rows = lines_of(table.str());
  REQUIRE(rows.size() == contacts + 1);
  CHECK(rows[0] ==
        "time,part,point_m_0,point_m_1,point_m_2,normal_0,normal_1,normal_2,normal_impulse_n_s,"
        "friction_impulse_n_s_0,friction_impulse_n_s_1,friction_impulse_n_s_2,penetration_m");
  std::ostringstream flippers;
  write_flippers_csv(flippers, log);
  CHECK(lines_of(flippers.str()).size() == records.size() + 1);
  CHECK(mentions(lines_of(flippers.str())[0], "contacts_flipper_rear_right,dropped"));

  const std::vector<Plot> plots = plot_contacts(contact_summaries(log));
  REQUIRE(plots.size() == 3);
  CHECK(plots[0].series.size() == rt::kVehicleParts);
  CHECK(plots[1].series.size() == 2 * rt::kFlippers);
  CHECK(plots[2].series.size() == rt::kFlippers);
  for (const Plot& plot : plots) {
    for (const Series& series : plot.series) CHECK(series.x.size() == records.size());
  }
  CHECK(plot_contacts({}).empty());

  ReplayOptions options;
  options.record = folder.file("b.lcm");
  CHECK(replay_log(folder.file("a.lcm"), options).contacts.size() == records.size());
  CHECK(contacts_of(LogFile(folder.file("b.lcm"))).size() == records.size());

  const LogFile hall(two_seconds().log);
  std::ostringstream none;
  CHECK_THROWS_AS(write_contacts_csv(none, hall), InputError);
  CHECK(mentions(message_of<ProfileError>([] { run_pallet(0.1, "", {"hil.contact_truth_hz=300"}); }),
                 "must divide 1000"));
}
