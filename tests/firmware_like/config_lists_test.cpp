// SPDX-License-Identifier: BSD-3-Clause
// The lists of keys at the config structs: each holds what its members can hold.
#include "rt/keys.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/emergency_inputs.hpp"
#include "firmware_like/parts/odometry_part.hpp"
#include "firmware_like/parts/uav_config.hpp"
#include "firmware_like/parts/ugv_drive_config.hpp"
#include "firmware_like/parts/ugv_motors.hpp"
#include "firmware_like/parts/ugv_ssl_config.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/units.hpp"
#include "mapping/grid/sweep.hpp"

using namespace sortie;
using namespace sortie::firmware;

namespace {

// What holds of every list: names once, meanings, and limits that the member holds and gives back.
template <rt::Keyed Config>
void check_list(Config config = {}) {
  std::set<std::string> names;
  Config::keys(config, [&]<class T>(const char* name, T& member, const rt::KeySpec& spec, auto&&...) {
    INFO(name);
    CHECK(names.insert(name).second);
    CHECK_FALSE(std::string(spec.meaning).empty());
    if constexpr (!std::is_same_v<T, rt::Vector3>) {
      const rt::KeyKind kind = rt::kind_of<T>(spec);
      if (kind == rt::KeyKind::choice) {
        bool known = false;
        for (std::size_t i = 0; i < spec.count; ++i)
          known = known || spec.choices[i].value == static_cast<int>(member);
        CHECK(known);
      } else if (kind != rt::KeyKind::flag) {
        CHECK(spec.low < spec.high);
        for (const double limit : {spec.low, spec.high})
          CHECK(rt::as_written(rt::from_written<T>(limit, spec), spec) == limit);
      }
    }
  });
  CHECK(names.size() > 0);
}

}  // namespace

TEST_CASE("every config's list holds what its members can hold") {
  check_list<estimators::AttitudeConfig>();
  check_list<estimators::TrackOdometryConfig>();
  check_list<estimators::TrackProfile>();
  check_list<estimators::UavEstimatorConfig>();
  check_list<mapping::RollingGridConfig>();
  check_list<mapping::SweepConfig>();
  check_list(mapping::FlipperOutline{.pivot_m = {}, .length_m = 1});
  check_list<mapping::WrittenOccupancy>();
  check_list<ChosenMapConfig>();
  check_list<ScanLimits>();
  check_list(SensorMount{.place = "place", .turn = "turn"});
  check_list<OccupancyUse>();
  check_list<planner::SslChoiceConfig>();
  check_list<planner::FlipperConfig>();
  check_list<planner::UavPilotConfig>();
  check_list<planner::RegularMultirotor>();
  check_list<planner::FlightMapConfig>();
  check_list<GuideConfig>();
  check_list(DriveSetup{{}, {}, true});
  check_list<drivers::canopen::UgvNodesConfig>();
  check_list<drivers::odrive::UgvAxesConfig>();
  check_list<drivers::EmergencyButtonConfig>();
  check_list<drivers::GpioLineConfig>();
  check_list<rt::posix::LiveOptions>();
  check_list<RunOutlets>();
}
