// SPDX-License-Identifier: BSD-3-Clause
// Segments of the local map become targets that may be recognised, and are recognised on a known map.
#include <algorithm>

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/kept_maps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "firmware_like/parts/place_check.hpp"
#include "firmware_like/parts/recognise_output.hpp"
#include "mapping/recognition/local_segments.hpp"
#include "mapping/recognition/recogniser.hpp"
#include "mapping/recognition/target_keeper.hpp"

namespace sortie::firmware {
namespace {

using mapping::PlaceCm;
using mapping::RigidPose;
using mapping::SetVerdict;

struct RecognisePartConfig {
  rt::Nanoseconds period_ns{rt::kNanosecondsPerSecond};
  std::uint32_t units{1'000'000};
  std::uint32_t described{64};
  double second_look_m{6.0};

  SORTIE_KEYS(c, key) {
    key("period_s", c.period_ns, {0.1, 60, rt::kSInNs, "between two searches, at least"});
    key("units", c.units, {1'000, 1e9, "units", "of work a job, of some 2 ns each", rt::kKnob});
    key("limits.described", c.described, {1, 1024, "segments", "that are described at a time; 280 B each"});
    key("second_look_m", c.second_look_m,
        {0, 100, "m",
         "of way between two places that have to agree before a lost robot is placed; 0: one is enough"});
  }
};

/// Group `mapping`, task `recognise`, behind map and `locate`. Once a period the segments are watched and
/// described; those that are new become targets, and with known targets a search begins that goes on over as
/// many jobs as its units need. Where the run began with a kept map, too (of the same run as the targets), a
/// scan is held against it at each place that is found, and a robot that is lost is placed where two such
/// places agree. Targets lie on the map of `locate` where the scene has that part, else in the odometry's
/// world.
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
        if (access_->locator->registration().config().planar)
          profile.fail("tasks.recognise.enabled",
                       "a lidar of one row (locate.planar) sees too little to be held against a map: leave "
                       "out --map or --targets");
        mapping::RelocateConfig judge;
        profile.read("recognise", judge);
        check_ = std::make_unique<PlaceCheck>(judge, *access_, config_.second_look_m, builder.arena());
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
  std::optional<RecognitionView> recognition() const override {
    if (recogniser_ == nullptr) return {};
    return RecognitionView{told_, known_.get(), recogniser_.get(), &told_set_};
  }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "recognise")
        .base<Part>()
        .fixed(config_, map_, access_, task_, answers_, speaking_)
        .by_hand(local_, keeper_, known_, recogniser_, check_)
        .scratch(told_, told_set_)
        .state(next_ns_, searched_ns_, step_, output_);
    archive.value(*local_);
    archive.value(*keeper_);
    if (recogniser_ != nullptr) recogniser_->archive(archive, *known_);
    if (check_ != nullptr) archive.value(*check_);
    if (archive.is_reading() && !can_be(step_)) {
      archive.fail(Status::malformed, "a step that cannot be");
      step_ = Step::rest;
    }
  }

 private:
  enum class Step : std::uint8_t { rest, search, wait, judge };

  bool can_be(Step step) const {
    if (step == Step::rest) return true;
    if (step == Step::search) return recogniser_ != nullptr;
    return step <= Step::judge && check_ != nullptr && !recogniser_->found().empty();
  }

  void work(rt::JobContext& context) {
    if (check_ != nullptr && check_->wait()) ++output_.counts.not_confirmed;
    local_->note(*map_->labelling());
    const auto now_ns = static_cast<rt::Nanoseconds>(context.job) * context.period_ns;
    if (now_ns >= next_ns_ && map_->done() && step_ == Step::rest) {
      next_ns_ = now_ns + config_.period_ns;
      round(context, now_ns);
    }
    std::uint64_t units = config_.units;
    keeper_->run(units);
    if (step_ == Step::search && recogniser_->run(*known_, units)) answer();
    if (step_ == Step::wait && check_->has_scan()) begin_judging();
    mapping::JudgedPlace judged;
    if (step_ == Step::judge && check_->run(units, judged)) take(judged);
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
    searched_ns_ = context.release_ns;
    recogniser_->begin(speaking_.first(count), {});
    step_ = Step::search;
  }

  /// The search came to an end.
  void answer() {
    output_.searches = recogniser_->counts();
    const bool is_found = recogniser_->verdict() == SetVerdict::found;
    step_ = is_found && check_ != nullptr ? Step::wait : Step::rest;
    if (step_ == Step::wait) return;
    if (is_found) ++output_.counts.unverified;
    put_answer(output_, *recogniser_, searched_ns_);
    tell();
  }

  /// An answer is whole: out with it.
  void tell() {
    ++told_;
    const auto found = recogniser_->found();
    told_set_ = found.empty() ? mapping::SetHypothesis{} : found[0];
    rt::RecognisedPlace* const report = answers_->claim();
    if (report == nullptr) return;
    *report = output_;
    answers_->publish();
  }

  /// The newest scan is held against the known map at the place that was found. What else segments speak for,
  /// if less, it is compared with.
  void begin_judging() {
    const bool can_be_judged = check_->begin();
    step_ = can_be_judged ? Step::judge : Step::rest;
    if (can_be_judged) {
      for (const mapping::SetHypothesis& place : recogniser_->found()) check_->add(pose_of(place.fit.place));
      return;
    }
    ++output_.counts.unverified;
    put_answer(output_, *recogniser_, searched_ns_);
    tell();
  }

  void take(const mapping::JudgedPlace& judged) {
    put_answer(output_, *recogniser_, searched_ns_);
    output_.share = judged.share;
    output_.crossed = judged.crossed;
    if (!check_->confirms(judged, pose_of(recogniser_->found()[0].fit.place))) {
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
    const RigidPose tie = check_->tie(judged);
    rt::store(tie.p, output_.p_known_odom_m);
    rt::store(tie.q, output_.q_known_odom);
    tell();
    if (check_->look(judged)) ++output_.counts.placed;
  }

  RecognisePartConfig config_;
  ChosenMap* map_;
  LocateAccess* access_;
  std::unique_ptr<mapping::LocalSegments> local_;
  std::unique_ptr<mapping::TargetKeeper> keeper_;    ///< what this run has seen
  std::unique_ptr<mapping::TargetStore> known_;      ///< what it began with, or null
  std::unique_ptr<mapping::Recogniser> recogniser_;  ///< null without known targets
  std::unique_ptr<PlaceCheck> check_;                ///< null without a map that they lie on
  std::span<mapping::SpeakingSegment> speaking_;
  Step step_{Step::rest};
  const rt::Task<RecogniseOutput>* task_{};
  std::unique_ptr<ReportQueue<rt::RecognisedPlace>> answers_;  ///< for telemetry; full: the next one tells
  rt::Nanoseconds next_ns_{};
  rt::Nanoseconds searched_ns_{};  ///< release of the job that began the search
  RecogniseOutput output_;
  std::uint64_t told_{};  ///< answers, and what the newest one rests on: no job reads them
  mapping::SetHypothesis told_set_;
};

}  // namespace

std::unique_ptr<Part> make_recognise(VehicleBuilder& builder) {
  return std::make_unique<RecognisePart>(builder);
}

}  // namespace sortie::firmware
