// SPDX-License-Identifier: BSD-3-Clause
// Requests to a pilot on their way through the desk: admitted once, and everything else counted by its
// reason.
#include <catch2/catch.hpp>
#include <limits>

#include "tests/firmware_like/request_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

drivers::FlyRequestMessage fly_to(double x_m, std::int64_t counter) {
  drivers::FlyRequestMessage request;
  request.counter = counter;
  request.p_world_m[0] = x_m;
  request.p_world_m[2] = 1.5;
  return request;
}

}  // namespace

TEST_CASE("A request to fly is admitted once, with the right tag, and everything else is counted") {
  Runtime runtime(load_scene("uav_neo11", {"flight.remote=true"}), own_vehicles(), RuntimeStart{});
  FlyRequestDesk desk(runtime.vehicle().fly_requests());
  REQUIRE(desk.wanted());
  const drivers::SipKey secret{1, 2};
  const drivers::SipKey other{1, 3};
  desk.take(bytes_of(fly_to(1, 1), nullptr), at(1, &secret));
  desk.take(bytes_of(fly_to(1, 1), &other), at(1, &secret));
  CHECK(desk.counters().bad_tag == 2);
  CHECK(desk.counters().admitted == 0);
  const auto good = bytes_of(fly_to(1, 1), &secret);
  desk.take(good, at(1, &secret));
  CHECK(desk.counters().admitted == 1);
  desk.take(good, at(2, &secret));  // played again
  CHECK(desk.counters().repeated == 1);
  auto cut = bytes_of(fly_to(1, 2), &secret);
  cut.pop_back();
  desk.take(cut, at(3, &secret));
  CHECK(desk.counters().malformed == 1);
  desk.take(bytes_of(fly_to(std::numeric_limits<double>::quiet_NaN(), 2), &secret), at(4, &secret));
  CHECK(desk.counters().not_finite == 1);
  desk.take(bytes_of(fly_to(9000, 2), &secret), at(5, &secret));
  drivers::FlyRequestMessage odd = fly_to(1, 2);
  odd.mode = 5;
  desk.take(bytes_of(odd, &secret), at(5, &secret));
  CHECK(desk.counters().out_of_range == 2);
  desk.take(bytes_of(fly_to(1, 5'000'000), &secret), at(6, &secret));
  CHECK(desk.counters().jumped == 1);
  desk.take(bytes_of(fly_to(1, 2), &secret), {&secret, 7, 7, {}});
  CHECK(desk.counters().wrong_session == 1);
  for (std::int64_t i = 2; i < 40; ++i) desk.take(bytes_of(fly_to(1, i), &secret), at(8, &secret));
  CHECK(desk.counters().admitted == 16);       // as many as wait at most
  CHECK(desk.counters().full == 38 - 15 - 1);  // the newest waits at the desk
}

TEST_CASE("A scene that does not want requests to fly has no way in for them") {
  Runtime runtime(load_scene("uav_neo11"), own_vehicles(), RuntimeStart{});
  CHECK(runtime.vehicle().fly_requests().port == nullptr);
  for (const auto& port : runtime.parts().ports()) CHECK(port->channel() != "FLY");
}
