// SPDX-License-Identifier: BSD-3-Clause
// Segments of the local map become targets that may be recognised, and are recognised on a known map.
#include <algorithm>
#include <cmath>

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/kept_maps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "firmware_like/parts/recognise_output.hpp"
#include "mapping/recognition/local_segments.hpp"
#include "mapping/recognition/recogniser.hpp"
#include "mapping/recognition/target_keeper.hpp"
#include "mapping/registration/kept_pose.hpp"
#include "mapping/registration/place_judge.hpp"
#include "mapping/registration/pose_algebra.hpp"

namespace sortie::firmware {
namespace {

using mapping::PlaceCm;
using mapping::RigidPose;
using mapping::SetVerdict;

struct RecognisePartConfig {
  rt::Nanoseconds period_ns{rt::kNanosecondsPerSecond};
  std::uint32_t units{1'000'000};
  std::uint32_t described{64};

  SORTIE_KEYS(c, key) {
    key("period_s", c.period_ns, {0.1, 60, rt::kSInNs, "between two searches, at least"});
    key("units", c.units, {1'000, 1e9, "units", "of work a job, of some 2 ns each", rt::kKnob});
    key("limits.described", c.described, {1, 1024, "segments", "that are described at a time; 280 B each"});
  }
};

/// Group `mapping`, task `recognise`, behind map and `locate`. Once a period the segments are watched and
/// described; those that are new become targets, and with known targets a search begins that goes on over as
/// many jobs as its units need. Where the run began with a kept map, too (of the same run as the targets), a
/// scan is held against it at each place that is found, and a robot that is lost is placed there. Targets lie
/// on the map of `locate` where the scene has that part, else in the odometry's world.
class RecognisePart final : public Part {
 public:
  explicit RecognisePart(VehicleBuilder& builder)
      : map_(builder.find<ChosenMap>()), access_(builder.find<LocateAccess>()) {
    Profile& profile = builder.profile();
    if (map_ == nullptr || map_->labelling() == nullptr)
      profile.fail("tasks.recognise.enabled",
                   "needs a map with segments: tasks.map.enabled=true, map.segments=euclidean");
    mapping::SegmentWatchConfig watch;
    mapping::TargetStoreConfig store;
    mapping::RecogniserConfig recogniser;
    profile.read("recognise", config_);
    profile.read("recognise", watch);
    profile.read("recognise", store);
    profile.read("recognise", recogniser);
    local_ = std::make_unique<mapping::LocalSegments>(watch, map_->most_segments(), config_.described,
                                                      builder.arena());
    mapping::TargetKeeperConfig keeper;
    profile.read("recognise", keeper);
    keeper_ = std::make_unique<mapping::TargetKeeper>(keeper, store, builder.arena());
    known_ = load_kept_targets(builder, store);
    if (known_ != nullptr) {
      recogniser_ = std::make_unique<mapping::Recogniser>(recogniser, builder.arena());
      if (access_ != nullptr && builder.kept_map("locate") != nullptr) {
        mapping::RelocateConfig judge;
        builder.profile().read("recognise", judge);
        judge_ = std::make_unique<mapping::PlaceJudge>(judge, access_->locator->registration_to_match(),
                                                       builder.arena());
      }
      speaking_ = builder.arena().make_array<mapping::SpeakingSegment>("recognition speaking", watch.watched);
    }
    task_ = builder.task<RecogniseOutput>(builder.group("mapping", 10), "recognise",
                                          TaskDefaults{10'000, rt::Criticality::b},
                                          [this](rt::JobContext& context, RecogniseOutput& output) {
                                            work(context);
                                            output = output_;
                                          });
    builder.remembers(task_, *this);
    answers_ = builder.reports<rt::RecognisedPlace>("recognised", 8);
    builder.offer(*answers_);
    builder.counters("recognise_", output_.counts);
    builder.counters("recognise_searches_", output_.searches);
    builder.counters("recognise_segments_", local_->counts());
    builder.counters("recognise_targets_", targets()->counts());
    builder.pool("targets", [store = targets()] {
      return PoolLevel{store->capacity(), store->kept(), store->counts().evicted};
    });
  }

  const mapping::TargetStore* targets() const override { return &keeper_->store(); }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "recognise")
        .base<Part>()
        .fixed(config_, map_, access_, task_, answers_, speaking_)
        .by_hand(local_, keeper_, known_, recogniser_, judge_)
        .state(next_ns_, step_, T_odom_judged_, has_odometry_, sigma_move_m_, sigma_turn_rad_, output_);
    if (archive.is_reading() && step_ > Step::judge) {
      archive.fail(Status::malformed, "a step that cannot be");
      step_ = Step::rest;
    }
    mapping::check_pose(archive, T_odom_judged_);
    archive.value(*local_);
    archive.value(*keeper_);
    if (recogniser_ != nullptr) recogniser_->archive(archive, *known_);
    if (judge_ != nullptr) archive.value(*judge_);
  }

 private:
  enum class Step : std::uint8_t { rest, search, wait, judge };

  void work(rt::JobContext& context) {
    local_->note(*map_->labelling());
    const auto now_ns = static_cast<rt::Nanoseconds>(context.job) * context.period_ns;
    if (now_ns >= next_ns_ && map_->done() && step_ == Step::rest) {
      next_ns_ = now_ns + config_.period_ns;
      round(context, now_ns);
    }
    std::uint64_t units = config_.units;
    keeper_->run(units);
    if (step_ == Step::search && recogniser_->run(*known_, units)) answer();
    if (step_ == Step::wait && access_->scans > 0) begin_judging();
    mapping::JudgedPlace judged;
    if (step_ == Step::judge && judge_->run(units, judged)) take(judged);
    const auto used = static_cast<std::uint32_t>(config_.units - units);
    context.add_units(used);
    output_.units += used;
  }

  void round(rt::JobContext& context, rt::Nanoseconds now_ns) {
    std::uint32_t voxels = 0;
    const Status status = local_->round(map_->grid(), *map_->graph(), *map_->labelling(), now_ns, voxels);
    context.add_units(voxels);
    if (status != Status::ok) return;
    keep_new(now_ns);
    if (recogniser_ != nullptr) begin(context);
  }

  PlaceCm in_world(const PlaceCm& of_grid) const {
    return mapping::to_cm(map_->grid().to_world({0.01 * of_grid.x, 0.01 * of_grid.y, 0.01 * of_grid.z}));
  }

  /// On the map where the robot's place on it is known; without `locate` in the odometry's world.
  void keep_new(rt::Nanoseconds now_ns) {
    if (access_ != nullptr && !access_->locator->has_begun()) return;
    const RigidPose tie = access_ != nullptr ? access_->locator->located().T_map_odom : RigidPose{};
    keeper_->keep(local_->segments(), map_->grid(), tie, now_ns);
    output_.targets = keeper_->store().kept();
    output_.key_frames = keeper_->key_frames();
  }

  void begin(rt::JobContext& context) {
    std::uint32_t count = 0;
    for (const mapping::WatchedSegment& segment : local_->segments()) {
      if (!segment.speaks || count == speaking_.size()) continue;
      speaking_[count++] = {segment.id, segment.version, in_world(segment.place), segment.descriptor};
    }
    // The nearest ones, should there be more than take part.
    const PlaceCm middle = mapping::to_cm(mapping::middle_of(map_->grid()));
    std::sort(speaking_.begin(), speaking_.begin() + count, [&](const auto& a, const auto& b) {
      const std::int64_t x = mapping::square_apart(a.place, middle),
                         y = mapping::square_apart(b.place, middle);
      return x != y ? x < y : a.id < b.id;
    });
    count = std::min(count, recogniser_->config().segments);
    output_.stamp_ns = context.release_ns;
    output_.speaking = count;
    recogniser_->begin(speaking_.first(count), {});
    step_ = Step::search;
  }

  /// The search came to an end.
  void answer() {
    output_.verdict = verdict_of(recogniser_->verdict());
    output_.searches = recogniser_->counts();
    output_.pairs = static_cast<std::uint32_t>(recogniser_->pairs().size());
    output_.share = output_.crossed = 0.0;
    const auto found = recogniser_->found();
    const mapping::LevelFit fit = found.empty() ? mapping::LevelFit{} : found[0].fit;
    output_.agree = found.empty() ? 0 : found[0].count;
    output_.rival = found.size() < 2 ? 0 : found[1].count;
    put(pose_of(fit.place));
    const auto covariance = mapping::level_covariance(fit, std::max(fit.rms_m, kLeastSigma));
    std::copy(covariance.begin(), covariance.end(), output_.covariance);
    output_.rms_m = fit.rms_m;
    output_.spread_m = fit.spread_m;
    output_.proved = recogniser_->proved();
    const bool is_found = recogniser_->verdict() == SetVerdict::found;
    step_ = is_found && judge_ != nullptr ? Step::wait : Step::rest;
    if (step_ == Step::wait) return;
    if (is_found) ++output_.counts.unverified;
    tell();
  }

  /// An answer is whole: out with it.
  void tell() {
    rt::RecognisedPlace* const report = answers_->claim();
    if (report == nullptr) return;
    *report = output_;
    answers_->publish();
  }

  /// T_known_odom; half the turn from its cosine and sine.
  static RigidPose pose_of(const mapping::LevelPlace& place) {
    const double cosine = std::sqrt(std::max(0.5 * (1.0 + place.cosine), 0.0));
    const double sine = std::sqrt(std::max(0.5 * (1.0 - place.cosine), 0.0));
    return {{place.x_m, place.y_m, place.z_m},
            rt::normalised({cosine, 0, 0, place.sine < 0.0 ? -sine : sine})};
  }
  void put(const RigidPose& T_known_odom) {
    rt::store(T_known_odom.p, output_.p_known_odom_m);
    rt::store(T_known_odom.q, output_.q_known_odom);
  }

  /// The newest scan is held against the known map at the place that was found.
  void begin_judging() {
    T_odom_judged_ = access_->hint.T_odom_sensor;
    has_odometry_ = access_->has_odometry;
    sigma_move_m_ = access_->hint.sigma_move_m;
    sigma_turn_rad_ = access_->hint.sigma_turn_rad;
    const RigidPose tie = pose_of(recogniser_->found()[0].fit.place);
    step_ = Step::judge;
    if (!judge_->begin(access_->locator->registration().sample(), access_->q_level_sensor)) {
      step_ = Step::wait;  // too few returns: the next scan
      return;
    }
    judge_->add(mapping::after(tie, T_odom_judged_));
  }

  void take(const mapping::JudgedPlace& judged) {
    output_.share = judged.share;
    output_.crossed = judged.crossed;
    if (judged.verdict != mapping::RelocateVerdict::placed) {
      output_.verdict = rt::RecognisedPlace::kRefused;
      ++output_.counts.refused;
      tell();
      recogniser_->refuse();
      step_ = recogniser_->is_searching() ? Step::search : Step::rest;
      return;
    }
    step_ = Step::rest;
    output_.verdict = rt::RecognisedPlace::kRecognised;
    ++output_.counts.recognised;
    put(mapping::after(judged.T_map_sensor, mapping::inverse(T_odom_judged_)));
    tell();
    mapping::Locator& locator = *access_->locator;
    if (!locator.is_unplaced()) return;
    double covariance[36];
    for (int i = 0; i < 36; ++i) covariance[i] = judged.covariance[i];
    for (int i = 0; i < 3; ++i) {
      covariance[7 * i] += kLeastMove * kLeastMove;
      covariance[7 * (i + 3)] += kLeastTurn * kLeastTurn;
    }
    const mapping::OdometryHint hint{has_odometry_, T_odom_judged_, sigma_move_m_, sigma_turn_rad_};
    static_cast<void>(locator.place(judged.T_map_sensor, covariance, hint));  // its next scan decides
  }

  static constexpr double kLeastSigma = 0.05;  ///< m: of a target's place
  static constexpr double kLeastMove = 0.1;    ///< m: what the locator is told at least that a place is off
  static constexpr double kLeastTurn = 0.03;   ///< rad

  RecognisePartConfig config_;
  ChosenMap* map_;
  LocateAccess* access_;
  std::unique_ptr<mapping::LocalSegments> local_;
  std::unique_ptr<mapping::TargetKeeper> keeper_;    ///< what this run has seen
  std::unique_ptr<mapping::TargetStore> known_;      ///< what it began with, or null
  std::unique_ptr<mapping::Recogniser> recogniser_;  ///< null without known targets
  std::unique_ptr<mapping::PlaceJudge> judge_;       ///< null without a map that they lie on
  std::span<mapping::SpeakingSegment> speaking_;
  Step step_{Step::rest};
  RigidPose T_odom_judged_;  ///< of the scan that is judged
  bool has_odometry_{};
  double sigma_move_m_{0.05};
  double sigma_turn_rad_{0.02};
  const rt::Task<RecogniseOutput>* task_{};
  std::unique_ptr<ReportQueue<rt::RecognisedPlace>> answers_;  ///< for telemetry; full: the next one tells
  rt::Nanoseconds next_ns_{};
  RecogniseOutput output_;
};

}  // namespace

std::unique_ptr<Part> make_recognise(VehicleBuilder& builder) {
  return std::make_unique<RecognisePart>(builder);
}

}  // namespace sortie::firmware
