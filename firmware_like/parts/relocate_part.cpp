// SPDX-License-Identifier: BSD-3-Clause
// Where a robot is on a kept map that knows nothing of it: searched while it is unplaced, a little a job.
#include <string>

#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/vehicle_builder.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/place_looks.hpp"
#include "mapping/registration/relocaliser.hpp"

namespace sortie::firmware {
namespace {

using mapping::RelocateVerdict;

struct RelocatePartConfig {
  std::uint32_t units{4'000'000};

  SORTIE_KEYS(c, key) {
    key("units", c.units, {10'000, 1e9, "units", "of work a job; 4,000,000 are about 50 ms"});
  }
};

struct RelocateOutput {
  std::uint8_t verdict{};      ///< mapping::RelocateVerdict of the newest search
  rt::Nanoseconds stamp_ns{};  ///< of the scan that is searched with
  double p_map_sensor_m[3]{};
  double q_map_sensor[4]{1, 0, 0, 0};
  double share{};
  double seen{};
  double crossed{};
  double lead{};
  double rival{};
  double unexplained{};
  std::uint8_t sure{};
  std::uint32_t candidates{};
  std::uint64_t units{};  ///< of this search so far
  mapping::RelocateCounts counts;
  std::uint64_t not_confirmed{};  ///< places that no later scan confirmed: searched again
  std::uint64_t first_looks{};    ///< places that wait for a second search that agrees
  std::uint64_t disagreed{};      ///< second searches that found another place
  SORTIE_FIELDS(verdict, stamp_ns, p_map_sensor_m, q_map_sensor, share, seen, crossed, lead, rival,
                unexplained, sure, candidates, units, counts, not_confirmed, first_looks, disagreed)
};

/// Group `mapping`, task `relocate`, behind `locate`. A search takes the newest scan, goes on over as many
/// jobs as its units need. A place that two searches from places apart agree in is handed to the locator,
/// which believes it when its next scan does.
class RelocatePart final : public Part {
 public:
  explicit RelocatePart(VehicleBuilder& builder) : access_(builder.find<LocateAccess>()) {
    mapping::RelocateConfig config;
    mapping::PlaceSearchConfig search;
    builder.profile().read("relocate", config);
    builder.profile().read("relocate", search);
    builder.profile().read("relocate", config_);
    mapping::PlaceLooksConfig looks;
    builder.profile().read("relocate", looks);
    looks_ = mapping::PlaceLooks(looks);
    if (access_->locator->registration().config().planar)
      builder.profile().fail("tasks.relocate.enabled",
                             "a lidar of one row (locate.planar) sees too little to be searched with: say "
                             "where the robot starts with locate.start_on_map = true");
    // A run that makes its own map has nobody to look for, and needs no memory for it.
    if (access_->locator->is_unplaced()) {
      relocaliser_ = std::make_unique<mapping::Relocaliser>(
          config, search, access_->memory, access_->locator->registration_to_match(), builder.arena());
      const bool taken = relocaliser_->take_map();
      const std::uint64_t wanted = relocaliser_->map().wanted_tops();
      if (!taken && wanted > 0)
        throw InputError("--map " + builder.kept_map("locate")->path +
                             ": there is no room for it to be searched; "
                             "cure: --set limits.tops=" +
                             std::to_string(wanted),
                         2);
    }
    task_ = builder.task<RelocateOutput>(builder.group("mapping", 10), "relocate",
                                         TaskDefaults{50'000, rt::Criticality::b},
                                         [this](rt::JobContext& context, RelocateOutput& output) {
                                           work(context);
                                           output = output_;
                                         });
    builder.remembers(task_, *this);
    builder.counters("relocate_", output_.counts);
    builder.counter("relocate_not_confirmed", [this] { return output_.not_confirmed; });
    builder.counter("relocate_first_looks", [this] { return output_.first_looks; });
    builder.counter("relocate_disagreed", [this] { return output_.disagreed; });
  }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "relocate")
        .base<Part>()
        .fixed(config_, access_, task_)
        .by_hand(relocaliser_)
        .state(searched_odometry_, T_odom_searched_, sigma_move_m_, sigma_turn_rad_, told_, waited_, looks_,
               output_);
    if (relocaliser_ != nullptr) archive.value(*relocaliser_);
    mapping::check_pose(archive, T_odom_searched_);
  }

 private:
  static constexpr std::uint32_t kPatience = 5;  ///< scans that may fail to confirm a place
  static constexpr double kLeastMove = 0.1;      ///< m: what the locator is told at least that a place is off
  static constexpr double kLeastTurn = 0.03;     ///< rad

  void work(rt::JobContext& context) {
    mapping::Locator& locator = *access_->locator;
    if (relocaliser_ == nullptr || !relocaliser_->has_map() || locator.has_begun()) return;
    if (told_) {
      waited_ += access_->scans;
      if (waited_ < kPatience) return;
      ++output_.not_confirmed;
      told_ = false;
    }
    // Somebody else said where it is.
    if (!locator.is_unplaced() && output_.not_confirmed == 0 && output_.counts.placed == 0) return;
    if (!relocaliser_->is_searching()) {
      if (access_->scans == 0) return;
      begin();
    }
    std::uint64_t units = config_.units;
    if (relocaliser_->run(units) && relocaliser_->result().verdict == RelocateVerdict::placed &&
        (!searched_odometry_ || looks_.take(relocaliser_->result(), T_odom_searched_)))
      place();
    context.add_units(config_.units - static_cast<std::uint32_t>(units));
    put();
  }

  void begin() {
    searched_odometry_ = access_->has_odometry;
    T_odom_searched_ = access_->hint.T_odom_sensor;
    sigma_move_m_ = access_->hint.sigma_move_m;
    sigma_turn_rad_ = access_->hint.sigma_turn_rad;
    output_.stamp_ns = access_->locator->located().stamp_ns;
    relocaliser_->begin(access_->locator->registration().sample(), access_->q_level_sensor);
  }

  void place() {
    double covariance[36];
    for (int i = 0; i < 36; ++i) covariance[i] = relocaliser_->result().covariance[i];
    for (int i = 0; i < 3; ++i) {
      covariance[7 * i] += kLeastMove * kLeastMove;
      covariance[7 * (i + 3)] += kLeastTurn * kLeastTurn;
    }
    const mapping::OdometryHint hint{searched_odometry_, T_odom_searched_, sigma_move_m_, sigma_turn_rad_};
    told_ = access_->locator->place(relocaliser_->result().T_map_sensor, covariance, hint) == Status::ok;
    waited_ = 0;
  }

  void put() {
    const mapping::Relocated& found = relocaliser_->result();
    output_.verdict = static_cast<std::uint8_t>(found.verdict);
    rt::store(found.T_map_sensor.p, output_.p_map_sensor_m);
    rt::store(found.T_map_sensor.q, output_.q_map_sensor);
    output_.share = found.share;
    output_.seen = found.seen;
    output_.crossed = found.crossed;
    output_.lead = found.lead;
    output_.rival = found.rival;
    output_.unexplained = found.unexplained;
    output_.sure = found.sure ? 1 : 0;
    output_.candidates = found.candidates;
    output_.units = found.units;
    output_.counts = found.counts;
    output_.first_looks = looks_.counts().first_looks;
    output_.disagreed = looks_.counts().disagreed;
  }

  RelocatePartConfig config_;
  LocateAccess* access_;
  std::unique_ptr<mapping::Relocaliser> relocaliser_;  // null without a kept map
  const rt::Task<RelocateOutput>* task_{};
  bool searched_odometry_{};  ///< of the scan that is searched with
  mapping::RigidPose T_odom_searched_;
  double sigma_move_m_{0.05};
  double sigma_turn_rad_{0.02};
  bool told_{};             ///< the locator was told a place, and has to see whether it is one
  std::uint32_t waited_{};  ///< scans since
  mapping::PlaceLooks looks_{{}};
  RelocateOutput output_;
};

}  // namespace

std::unique_ptr<Part> make_relocate(VehicleBuilder& builder) {
  return std::make_unique<RelocatePart>(builder);
}

}  // namespace sortie::firmware
