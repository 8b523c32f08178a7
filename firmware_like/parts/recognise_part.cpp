// SPDX-License-Identifier: BSD-3-Clause
// Segments of the local map become targets that may be recognised, and are recognised on a known map.
#include <algorithm>
#include <cmath>

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/kept_maps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "mapping/recognition/local_segments.hpp"
#include "mapping/recognition/recogniser.hpp"
#include "mapping/registration/pose_algebra.hpp"
#include "rt/math.hpp"

namespace sortie::firmware {
namespace {

using mapping::PlaceCm;
using mapping::RigidPose;
using mapping::SetVerdict;

struct RecognisePartConfig {
  rt::Nanoseconds period_ns{rt::kNanosecondsPerSecond};
  std::uint32_t units{1'000'000};
  std::uint32_t described{64};
  std::uint32_t robot{0};
  double key_frame_m{5.0};

  SORTIE_KEYS(c, key) {
    key("period_s", c.period_ns, {0.1, 60, rt::kSInNs, "between two searches, at least"});
    key("units", c.units, {1'000, 1e9, "units", "of work a job, of some 2 ns each", rt::kKnob});
    key("limits.described", c.described, {1, 1024, "segments", "that are described at a time; 280 B each"});
    key("robot", c.robot, {0, 255, "", "number of this robot in its targets"});
    key("key_frame_m", c.key_frame_m, {0.5, 100, "m", "of way between two key frames that targets hang on"});
  }
};

struct RecogniseOutput {
  rt::Nanoseconds stamp_ns{};  ///< when the segments of the newest answer were looked at
  std::uint8_t verdict{};      ///< mapping::SetVerdict of the newest answer
  double p_known_odom_m[3]{};  ///< best pose: the odometry's world on the known map
  double q_known_odom[4]{1, 0, 0, 0};
  double covariance[16]{};   ///< of it: x, y, z, yaw, by rows, m and rad
  std::uint32_t speaking{};  ///< segments that were asked for
  std::uint32_t pairs{};     ///< correspondences
  std::uint32_t agree{};     ///< of them, in the best set
  std::uint32_t rival{};     ///< in the next one
  double rms_m{};            ///< of the best pose
  double spread_m{};         ///< of its segments, where it is least
  bool proved{};             ///< no larger set
  std::uint64_t units{};     ///< of work so far
  std::uint32_t targets{};   ///< that this run has made
  std::uint32_t key_frames{};
  mapping::RecogniserCounts counts;
  SORTIE_FIELDS(stamp_ns, verdict, p_known_odom_m, q_known_odom, covariance, speaking, pairs, agree, rival,
                rms_m, spread_m, proved, units, targets, key_frames, counts)
};

/// Group `mapping`, task `recognise`, behind map and `locate`. Once a period the segments are watched and
/// described; those that are new become targets, and with known targets a search begins that goes on over as
/// many jobs as its units need. Targets lie on the map of `locate` where the scene has that part, else in the
/// odometry's world.
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
    store_ = std::make_unique<mapping::TargetStore>(store, builder.arena());
    known_ = load_kept_targets(builder, store);
    if (known_ != nullptr) {
      recogniser_ = std::make_unique<mapping::Recogniser>(recogniser, builder.arena());
      speaking_ = builder.arena().make_array<mapping::SpeakingSegment>("recognition speaking", watch.watched);
    }
    task_ = builder.task<RecogniseOutput>(builder.group("mapping", 10), "recognise",
                                          TaskDefaults{50'000, rt::Criticality::b},
                                          [this](rt::JobContext& context, RecogniseOutput& output) {
                                            work(context);
                                            output = output_;
                                          });
    builder.remembers(task_, *this);
    builder.counters("recognise_", output_.counts);
    builder.counters("recognise_segments_", local_->counts());
    builder.counters("recognise_targets_", store_->counts());
    builder.pool("targets", [this] {
      return PoolLevel{store_->capacity(), store_->kept(), store_->counts().evicted};
    });
  }

  const mapping::TargetStore* targets() const override { return store_.get(); }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "recognise")
        .base<Part>()
        .fixed(config_, map_, access_, task_, speaking_)
        .by_hand(local_, store_, known_, recogniser_)
        .state(next_ns_, frame_, output_);
    archive.value(*local_);
    archive.value(*store_);
    if (recogniser_ != nullptr) recogniser_->archive(archive, *known_);
  }

 private:
  void work(rt::JobContext& context) {
    local_->note(*map_->labelling());
    const auto now_ns = static_cast<rt::Nanoseconds>(context.job) * context.period_ns;
    if (now_ns >= next_ns_ && map_->done() && (recogniser_ == nullptr || !recogniser_->is_searching())) {
      next_ns_ = now_ns + config_.period_ns;
      round(context, now_ns);
    }
    std::uint64_t units = config_.units;
    static_cast<void>(store_->run(units));
    if (recogniser_ != nullptr && recogniser_->is_searching() && recogniser_->run(*known_, units)) answer();
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
    return to_cm(map_->grid().to_world({0.01 * of_grid.x, 0.01 * of_grid.y, 0.01 * of_grid.z}));
  }
  static PlaceCm to_cm(const rt::Vector3& m) {
    const auto whole = [](double v) {
      return static_cast<std::int32_t>(rt::floor(100.0 * std::clamp(v, -4e6, 4e6) + 0.5));
    };
    return {whole(m.x), whole(m.y), whole(m.z)};
  }

  /// T_map_odom, or none where the place on the map is not known.
  bool find_tie(RigidPose& tie) const {
    tie = {};
    if (access_ == nullptr) return true;
    tie = access_->locator->located().T_map_odom;
    return access_->locator->has_begun();
  }

  /// A key frame where the middle of the local map is, when that is far from the one before.
  bool find_key_frame(const RigidPose& tie) {
    const mapping::RollingGrid& grid = map_->grid();
    const double edge_m = 4.0 * grid.config().voxel_size_m;
    const mapping::BlockAt& at = grid.centre();
    const rt::Vector3 middle = grid.to_world({edge_m * at.x, edge_m * at.y, edge_m * at.z});
    mapping::KeyFramePose pose;
    pose.place = to_cm(tie.p + rt::rotate(tie.q, middle));
    const rt::Vector3 ahead = rt::rotate(tie.q, {1, 0, 0});
    if (!mapping::heading_of(ahead.x, ahead.y, pose.heading)) return false;
    const double least_cm = 100.0 * config_.key_frame_m;
    const bool has_one = output_.key_frames > 0;
    if (has_one && static_cast<double>(mapping::square_apart(frame_.place, pose.place)) < least_cm * least_cm)
      return true;
    if (output_.key_frames == store_->config().key_frames) return has_one;  // the last one takes what comes
    if (store_->set_key_frame(static_cast<std::uint16_t>(output_.key_frames), pose) != Status::ok)
      return has_one;
    frame_ = pose;
    ++output_.key_frames;
    return true;
  }

  /// Segments with a version of this round become targets.
  void keep_new(rt::Nanoseconds now_ns) {
    RigidPose tie;
    if (!find_tie(tie) || !find_key_frame(tie)) return;
    for (const mapping::WatchedSegment& segment : local_->segments()) {
      if (!segment.speaks || segment.version_at_ns != now_ns) continue;
      mapping::TargetSighting sighting;
      sighting.id = segment.id;
      sighting.stamp_ms = static_cast<std::uint32_t>(now_ns / 1'000'000);
      sighting.voxels = segment.described.voxels;
      sighting.key_frame = static_cast<std::uint16_t>(output_.key_frames - 1);
      sighting.version = static_cast<std::uint16_t>(segment.version);
      sighting.robot = static_cast<std::uint8_t>(config_.robot);
      const PlaceCm odom = in_world(segment.place);
      const rt::Vector3 on_map = tie.p + rt::rotate(tie.q, {0.01 * odom.x, 0.01 * odom.y, 0.01 * odom.z});
      sighting.offset = mapping::offset_of(frame_, to_cm(on_map));
      sighting.descriptor = segment.descriptor;
      static_cast<void>(store_->put(sighting));  // what is refused is counted
    }
    output_.targets = store_->kept();
  }

  void begin(rt::JobContext& context) {
    std::uint32_t count = 0;
    for (const mapping::WatchedSegment& segment : local_->segments()) {
      if (!segment.speaks || count == speaking_.size()) continue;
      speaking_[count++] = {segment.id, segment.version, in_world(segment.place), segment.descriptor};
    }
    // The nearest ones, should there be more than take part.
    const mapping::BlockAt& at = map_->grid().centre();
    const double edge_m = 4.0 * map_->grid().config().voxel_size_m;
    const PlaceCm middle = to_cm(map_->grid().to_world({edge_m * at.x, edge_m * at.y, edge_m * at.z}));
    std::sort(speaking_.begin(), speaking_.begin() + count, [&](const auto& a, const auto& b) {
      const std::int64_t x = mapping::square_apart(a.place, middle),
                         y = mapping::square_apart(b.place, middle);
      return x != y ? x < y : a.id < b.id;
    });
    count = std::min(count, recogniser_->config().segments);
    output_.stamp_ns = context.release_ns;
    output_.speaking = count;
    recogniser_->begin(speaking_.first(count), {});
  }

  void answer() {
    output_.verdict = static_cast<std::uint8_t>(recogniser_->verdict());
    output_.counts = recogniser_->counts();
    output_.pairs = static_cast<std::uint32_t>(recogniser_->pairs().size());
    const auto found = recogniser_->found();
    output_.agree = found.empty() ? 0 : found[0].count;
    output_.rival = found.size() < 2 ? 0 : found[1].count;
    if (found.empty()) return;
    const mapping::LevelFit& fit = found[0].fit;
    const mapping::LevelPlace& place = fit.place;
    output_.p_known_odom_m[0] = place.x_m;
    output_.p_known_odom_m[1] = place.y_m;
    output_.p_known_odom_m[2] = place.z_m;
    // Half the turn, from its cosine and sine.
    const double half_cosine = std::sqrt(std::max(0.5 * (1.0 + place.cosine), 0.0));
    const double half_sine = std::sqrt(std::max(0.5 * (1.0 - place.cosine), 0.0));
    output_.q_known_odom[0] = half_cosine;
    output_.q_known_odom[3] = place.sine < 0.0 ? -half_sine : half_sine;
    const auto covariance = mapping::level_covariance(fit, std::max(fit.rms_m, 0.05));
    std::copy(covariance.begin(), covariance.end(), output_.covariance);
    output_.rms_m = fit.rms_m;
    output_.spread_m = fit.spread_m;
    output_.proved = recogniser_->proved();
  }

  RecognisePartConfig config_;
  ChosenMap* map_;
  LocateAccess* access_;
  std::unique_ptr<mapping::LocalSegments> local_;
  std::unique_ptr<mapping::TargetStore> store_;      ///< what this run has seen
  std::unique_ptr<mapping::TargetStore> known_;      ///< what it began with, or null
  std::unique_ptr<mapping::Recogniser> recogniser_;  ///< null without known targets
  std::span<mapping::SpeakingSegment> speaking_;
  const rt::Task<RecogniseOutput>* task_{};
  rt::Nanoseconds next_ns_{};
  mapping::KeyFramePose frame_;  ///< the newest
  RecogniseOutput output_;
};

}  // namespace

std::unique_ptr<Part> make_recognise(VehicleBuilder& builder) {
  return std::make_unique<RecognisePart>(builder);
}

}  // namespace sortie::firmware
