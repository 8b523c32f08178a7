// SPDX-License-Identifier: BSD-3-Clause
// What the random campaign found, reduced by it: each sequence failed once, and holds since.
#include <catch2/catch.hpp>
#include <string>

#include "mapping/segments/segmentation_policy.hpp"
#include "tests/bench/campaign/campaign.hpp"

namespace {
using namespace sortie;

std::string fault_of(const std::string& text) {
  std::string name;
  const auto ops = bench::read_sequence(text, name);
  const bench::CampaignModule* module = bench::find_campaign_module(name);
  return module == nullptr ? "no module " + name : bench::try_sequence(*module, ops).fault;
}
}  // namespace

TEST_CASE("A heading's deviation beyond 1e154 rad leaves the covariance finite") {
  CHECK(fault_of("module attitude\nop 4 5000000 0 -0x1.fffffffffffffp+1023 0 0 0 0 1\n") == "");
}

TEST_CASE("An attitude that turns at 1e308 rad/s leaves the pose finite") {
  CHECK(fault_of("module odometry\n"
                 "op 3 10000000 0 0 0 0 0 0 0\n"
                 "op 0 10000000 0 0 0 0 -0x1.fffffffffffffp+1023 0 0\n"
                 "op 2 10000000 0 0 0 0 0 0 0\n") == "");
}

TEST_CASE("A first fix without a place or a heading is refused and counted") {
  CHECK(fault_of("module flight\n"
                 "op 2 5000000 0 0 0 0 0 0 0\n"
                 "op 1 295000000 0 0 0 0 0 0 0\n"
                 "op 0 5000000 0 0 0 0 0 0 0\n") == "");
}

TEST_CASE("Stamps years apart leave the flight's state finite") {
  CHECK(fault_of("module flight\n"
                 "op 1 5000000 0 0 0 0 0 0 0\n"
                 "op 1 -9223372036854775808 0 0 0 0 0 0 0\n"
                 "op 3 31557600000000000 0 0 0 0 0 0 0\n"
                 "op 1 -9223372036854775808 0 0 0 0 1 0 0\n"
                 "op 1 1078829932266297230 0 1 1 0 0 0 0\n"
                 "op 0 5000000 0 0 0 0 0 1 0\n"
                 "op 1 31557600000000000 0 0 0 0 nan:7ff8000000000000 0 0\n"
                 "op 1 5000000 1 0 0 0 0 0 0\n"
                 "op 2 31557600000000000 0 0 0 1 0 0 0\n"
                 "op 0 5000000 0 0 0 0 0 0 0\n"
                 "op 3 5000000 0 0 0 0 0 0 0\n") == "");
}

TEST_CASE("A turn rate of 1e-323 rad/s leaves speed and turn rate finite") {
  CHECK(fault_of("module drive\nop 3 10000000 1 0x0.0000000000001p-1022 0 0 0 0 0\n") == "");
}

TEST_CASE("A core that lost its normal while its block waits takes nobody in, and divides by nothing") {
  const mapping::SmoothnessPolicy policy;
  mapping::SmoothnessPolicy::Voxel flat{};
  flat.z = 100;
  const mapping::SmoothnessPolicy::Voxel lost{};
  CHECK(policy.affinity(flat, lost) == -1);
  CHECK(policy.affinity(lost, flat) == -1);
  CHECK(policy.affinity(flat, flat) > 0);
}
