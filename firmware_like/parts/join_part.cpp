// SPDX-License-Identifier: BSD-3-Clause
// Where the vehicle is on the cloud of another robot: searched by planes, cells and lines of sight, until
// clouds that were gathered one after the other agree.
#include "firmware_like/parts/join_output.hpp"
#include "firmware_like/parts/kept_maps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::firmware {
namespace {

using mapping::RigidPose;

struct JoinPartConfig {
  std::uint32_t units{4'000'000};
  std::uint32_t views{24};
  std::uint32_t more_views{8};
  std::uint32_t clouds{2};
  double agree_m{0.15};
  double agree_rad{0.0175};
  double guess_m[3]{};
  double guess_yaw_rad{};
  double guess_sigma_m{3.0};
  double guess_sigma_yaw_rad{0.105};
  double tilt_sigma_rad{0.0087};
  double scale_sigma{};

  SORTIE_KEYS(c, key) {
    key("units", c.units, {10'000, 1e9, "units", "of work a job; 4,000,000 are about 20 ms"});
    key("views", c.views, {1, 10'000, "views", "of a cloud before it is matched"});
    key("more_views", c.more_views,
        {0, 10'000, "views", "that are added to one that was refused; 0: another one is gathered"});
    key("clouds", c.clouds, {1, 8, "clouds", "one after the other, that have to agree"});
    key("agree_m", c.agree_m, {0.01, 5, "m", "apart at most, at the vehicle"});
    key("agree_deg", c.agree_rad, {0.05, 45, rt::kDegInRad, "apart at most"});
    constexpr const char* kGuess = "where the vehicle's own frame is taken to be on the map";
    key("x_m", c.guess_m[0], {-4000, 4000, "m", kGuess});
    key("y_m", c.guess_m[1], {-4000, 4000, "m", kGuess});
    key("z_m", c.guess_m[2], {-4000, 4000, "m", kGuess});
    key("yaw_deg", c.guess_yaw_rad, {-360, 360, rt::kDegInRad, kGuess});
    key("sigma_m", c.guess_sigma_m, {0, 1000, "m", "standard deviation of that; 0: nothing is known"});
    key("sigma_yaw_deg", c.guess_sigma_yaw_rad,
        {0, 180, rt::kDegInRad, "of its yaw, as of a compass; 0: nothing is known"});
    key("sigma_tilt_deg", c.tilt_sigma_rad,
        {0.01, 10, rt::kDegInRad, "of the vertical: both maps know gravity"});
    key("sigma_scale", c.scale_sigma, {0, 0.3, "", "of the cloud's scale; 0: it is 1"});
  }
};

/// Group `mapping`, task `join`, behind `cloud`. While a cloud is matched it stays as it is. Does nothing
/// without a kept cloud, and nothing more once the vehicle is placed.
class JoinPart final : public Part {
 public:
  explicit JoinPart(VehicleBuilder& builder) : access_(builder.find<CloudAccess>()) {
    mapping::CloudMatchConfig config;
    builder.profile().read("join", config.registration);
    builder.profile().read("join", config);
    builder.profile().read("join", config_);
    kept_ = load_kept_cloud(builder);
    if (kept_.layer != nullptr)
      match_ = std::make_unique<mapping::CloudMatch>(
          config, access_->cloud, mapping::SensedCloud{kept_.layer.get(), kept_.sensor}, builder.arena());
    task_ = builder.task<JoinOutput>(builder.group("mapping", 10), "join",
                                     TaskDefaults{50'000, rt::Criticality::b},
                                     [this](rt::JobContext& context, JoinOutput& output) {
                                       work(context);
                                       output_.stamp_ns = context.release_ns;
                                       output = output_;
                                     });
    builder.offer(*task_);
    builder.remembers(task_, *this);
    builder.counter("join_placed", [this] { return std::uint64_t{output_.placed}; });
    builder.counter("join_matches", [this] { return output_.matches; });
    builder.counter("join_accepted", [this] { return output_.accepted; });
    builder.counter("join_disagreed", [this] { return output_.disagreed; });
  }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "join")
        .base<Part>()
        .fixed(config_, access_, kept_, task_)
        .by_hand(match_)
        .state(wanted_views_, agreed_, place_, output_);
    if (match_ != nullptr) archive.value(*match_);
    mapping::check_pose(archive, place_);
  }

 private:
  void work(rt::JobContext& context) {
    if (match_ == nullptr || output_.placed || access_->renew) return;
    if (!match_->works()) {
      if (access_->views < wanted()) return;
      match_->begin(estimate());
      access_->held = true;
    }
    std::uint64_t units = config_.units;
    if (match_->run(units)) end();
    const std::uint64_t spent = config_.units - units;
    output_.units += spent;
    context.add_units(static_cast<std::uint32_t>(spent));
  }

  std::uint64_t wanted() const { return wanted_views_ != 0 ? wanted_views_ : config_.views; }

  mapping::PlaneEstimate estimate() const {
    mapping::PlaneEstimate estimate;
    estimate.T_target_source = {rt::from_yaw_pitch_roll(config_.guess_yaw_rad, 0, 0),
                                rt::to_vector(config_.guess_m), 1.0};
    estimate.sigma_position_m = config_.guess_sigma_m;
    estimate.sigma_yaw_rad = config_.guess_sigma_yaw_rad;
    estimate.sigma_tilt_rad = config_.tilt_sigma_rad;
    estimate.sigma_scale = config_.scale_sigma;
    return estimate;
  }

  void end() {
    access_->held = false;
    ++output_.matches;
    const mapping::CloudResult& result = match_->result();
    put(result);
    if (!result.placed()) {
      wanted_views_ = access_->views + config_.more_views;
      if (config_.more_views == 0) renew();
      return;
    }
    ++output_.accepted;
    const RigidPose place{result.T_target_source.p_target_source_m, result.T_target_source.q_target_source};
    if (agreed_ > 0 && !agrees(place)) {
      ++output_.disagreed;
      agreed_ = 0;
    }
    place_ = place;
    ++agreed_;
    if (agreed_ >= config_.clouds) {
      output_.placed = true;
      rt::store(place_.p, output_.p_map_own_m);
      rt::store(place_.q, output_.q_map_own);
      return;
    }
    // The next one is gathered anew: what misled this one shall not mislead it, too.
    renew();
  }

  void renew() {
    access_->renew = true;
    wanted_views_ = 0;
  }

  /// Compared where the vehicle is, near which its cloud lies: far from there a small turn moves much.
  bool agrees(const RigidPose& place) const {
    const RigidPose apart = mapping::after(mapping::inverse(place_), place);
    const auto cells = access_->cloud.layer->cells();
    const rt::Vector3 here = cells.empty() ? rt::Vector3{} : cells.front().from_m;
    const rt::Vector3 off = apart.p + rt::rotate(apart.q, here) - here;
    return rt::norm(off) < config_.agree_m && rt::norm(rt::log_rotation(apart.q)) < config_.agree_rad;
  }

  void put(const mapping::CloudResult& result) {
    output_.verdict = static_cast<std::uint8_t>(result.verdict);
    output_.refusal = static_cast<std::uint8_t>(result.refusal);
    rt::store(result.T_target_source.p_target_source_m, output_.p_map_match_m);
    rt::store(result.T_target_source.q_target_source, output_.q_map_match);
    output_.scale = result.T_target_source.scale;
    output_.sigma_m = result.sigma_m;
    output_.sigma_rad = result.sigma_rad;
    output_.lead = result.lead;
    output_.cells = result.cells;
    output_.on = result.on;
    output_.through = result.through;
  }

  JoinPartConfig config_;
  CloudAccess* access_;
  KeptCloud kept_;
  std::unique_ptr<mapping::CloudMatch> match_;  // null without a kept cloud
  rt::Task<JoinOutput>* task_{};
  std::uint64_t wanted_views_{};  ///< of this cloud before the next match; 0: join.views
  std::uint32_t agreed_{};        ///< clouds that place_ holds for
  RigidPose place_;               ///< of the newest accepted match
  JoinOutput output_;
};

}  // namespace

std::unique_ptr<Part> make_join(VehicleBuilder& builder) { return std::make_unique<JoinPart>(builder); }

}  // namespace sortie::firmware
