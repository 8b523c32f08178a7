// SPDX-License-Identifier: BSD-3-Clause
// Height images of the local map are kept, and recognised on those of a known map: places without segments.
#include "firmware_like/parts/recognise_images_output.hpp"

#include "firmware_like/parts/chosen_map.hpp"
#include "firmware_like/parts/kept_maps.hpp"
#include "firmware_like/parts/part.hpp"
#include "firmware_like/parts/part_access.hpp"
#include "firmware_like/parts/place_check.hpp"
#include "mapping/recognition/height_imager.hpp"
#include "mapping/recognition/target_keeper.hpp"

namespace sortie::firmware {
namespace {

using mapping::HeightImage;
using mapping::ImageVerdict;
using mapping::RigidPose;

struct RecogniseImagesConfig {
  rt::Nanoseconds period_ns{rt::kNanosecondsPerSecond};
  std::uint32_t units{6'000'000};
  std::uint32_t robot{0};
  double second_look_m{6.0};

  SORTIE_KEYS(c, key) {
    key("period_s", c.period_ns, {0.1, 60, rt::kSInNs, "between two images, at least"});
    key("units", c.units, {10'000, 1e9, "units", "of work a job, of some 0.5 ns each", rt::kKnob});
    key("robot", c.robot, {0, 255, "", "number of this robot in its images"});
    key("second_look_m", c.second_look_m,
        {0, 100, "m",
         "of way between two places that have to agree before a lost robot is placed; 0: one is enough"});
  }
};

/// Group `mapping`, task `recognise_images`, behind map, `locate` and `recognise`. Once a period an image of
/// the local map is drawn and kept; with known images a search begins that goes on over as many jobs as its
/// units need. What it finds is checked as segments' places are (PlaceCheck), by looks of its own: a robot is
/// never placed by an image and a segment that agree, nor by images that no scan was held against. Images lie
/// on the map of `locate` where the scene has that part, else in the odometry's world.
class RecogniseImagesPart final : public Part {
 public:
  explicit RecogniseImagesPart(VehicleBuilder& builder)
      : map_(builder.find<ChosenMap>()), access_(builder.find<LocateAccess>()) {
    Profile& profile = builder.profile();
    if (map_ == nullptr)
      profile.fail("tasks.recognise_images.enabled", "needs a map: tasks.map.enabled=true");
    mapping::ImageStoreConfig store;
    profile.read("recognise_images", config_);
    profile.read("recognise_images", store);
    own_ = std::make_unique<mapping::ImageStore>(store, builder.arena());
    known_ = load_kept_images(builder, store);
    if (known_ != nullptr) know(builder);
    task_ = builder.task<RecogniseImagesOutput>(
        builder.group("mapping", 10), "recognise_images", TaskDefaults{10'000, rt::Criticality::b},
        [this](rt::JobContext& context, RecogniseImagesOutput& output) {
          work(context);
          output = output_;
        });
    builder.remembers(task_, *this);
    // Answers of both channels go out in one queue, in the order of jobs.
    answers_ = builder.find<ReportQueue<rt::RecognisedPlace>>();
    if (answers_ == nullptr) {
      own_answers_ = builder.reports<rt::RecognisedPlace>("recognised", 8);
      answers_ = own_answers_.get();
      builder.offer(*answers_);
    }
    builder.counters("recognise_images_", output_.counts);
    builder.counters("recognise_images_", output_.draws);
    builder.counters("recognise_images_searches_", output_.searches);
    builder.counters("recognise_images_kept_", own_->counts());
    builder.pool("images", [this] {
      return PoolLevel{own_->capacity(), own_->images().size(), own_->counts().evicted};
    });
  }

  const mapping::ImageStore* images() const override { return own_.get(); }

  void archive(rt::Archive& archive) {
    rt::Members(archive, *this, "recognise images")
        .base<Part>()
        .fixed(config_, map_, access_, task_, answers_, own_answers_)
        .by_hand(own_, known_, search_, check_)
        .state(imager_, next_ns_, drawn_ns_, step_, T_grid_odom_, output_);
    mapping::check_pose(archive, T_grid_odom_);
    archive.value(*own_);
    if (search_ != nullptr) search_->archive(archive, *known_);
    if (check_ != nullptr) archive.value(*check_);
    if (archive.is_reading() && !can_be(step_)) {
      archive.fail(Status::malformed, "a step that cannot be");
      step_ = Step::rest;
    }
  }

 private:
  enum class Step : std::uint8_t { rest, draw, search, wait, judge };
  static constexpr std::uint32_t kVoxelUnits = 8;   ///< of this task's, one of HeightImager
  static constexpr std::uint32_t kJudgeUnits = 25;  ///< one of PlaceCheck

  void know(VehicleBuilder& builder) {
    Profile& profile = builder.profile();
    mapping::ImageSearchConfig search;
    profile.read("recognise_images", search);
    search_ = std::make_unique<mapping::ImageSearch>(search);
    if (access_ == nullptr || builder.kept_map("locate") == nullptr) return;
    if (access_->locator->registration().config().planar)
      profile.fail("tasks.recognise_images.enabled",
                   "a lidar of one row (locate.planar) sees too little to be held against a map: leave out "
                   "--map or --images");
    mapping::RelocateConfig judge;
    profile.read("recognise_images.scan", judge);
    check_ = std::make_unique<PlaceCheck>(judge, *access_, config_.second_look_m, builder.arena());
  }

  bool can_be(Step step) const {
    if (step == Step::rest) return true;
    if (step == Step::draw) return imager_.is_working();
    if (step == Step::search) return search_ != nullptr;
    return step <= Step::judge && check_ != nullptr && !search_->found().empty();
  }

  void work(rt::JobContext& context) {
    if (check_ != nullptr && check_->wait()) ++output_.counts.not_confirmed;
    const auto now_ns = static_cast<rt::Nanoseconds>(context.job) * context.period_ns;
    if (step_ == Step::rest && now_ns >= next_ns_) {
      next_ns_ = now_ns + config_.period_ns;
      imager_.begin(map_->grid());
      step_ = Step::draw;
    }
    std::uint64_t units = config_.units;
    if (step_ == Step::draw) draw(context, now_ns, units);
    if (step_ == Step::search && search_->run(*known_, units)) answer();
    if (step_ == Step::wait && check_->has_scan()) begin_judging();
    if (step_ == Step::judge) judge(units);
    const auto used = static_cast<std::uint32_t>(config_.units - units);
    context.add_units(used);
    output_.units += used;
  }

  void draw(rt::JobContext& context, rt::Nanoseconds now_ns, std::uint64_t& units) {
    const std::uint64_t used = std::uint64_t{kVoxelUnits} *
                               imager_.run(map_->grid(), static_cast<std::uint32_t>(units / kVoxelUnits));
    units -= std::min(units, used);  // at most a block more
    if (imager_.is_working()) return;
    step_ = Step::rest;
    if (imager_.stage() == mapping::ImageStage::floorless) {
      ++output_.draws.floorless;
      return;
    }
    ++output_.draws.drawn;
    keep(now_ns);
    if (search_ == nullptr) return;
    drawn_ns_ = context.release_ns;
    T_grid_odom_ = mapping::inverse(map_->grid().world_from_grid());
    search_->begin(imager_.image());
    step_ = Step::search;
  }

  /// On the map where the robot's place on it is known; without `locate` in the odometry's world.
  void keep(rt::Nanoseconds now_ns) {
    if (access_ != nullptr && !access_->locator->has_begun()) return;
    const RigidPose tie = access_ != nullptr ? access_->locator->located().T_map_odom : RigidPose{};
    const RigidPose T_map_grid = mapping::after(tie, map_->grid().world_from_grid());
    const mapping::PlaceCm& middle = imager_.image().middle;
    const rt::Vector3 of_grid{0.01 * middle.x, 0.01 * middle.y, 0.01 * middle.z};
    const rt::Vector3 ahead = rt::rotate(T_map_grid.q, {1, 0, 0});
    mapping::KeyFramePose pose;
    pose.place = mapping::to_cm(T_map_grid.p + rt::rotate(T_map_grid.q, of_grid));
    if (!mapping::heading_of(ahead.x, ahead.y, pose.heading)) return;
    // What the store refuses it counts.
    static_cast<void>(own_->put(imager_.image(), pose, static_cast<std::uint32_t>(now_ns / 1'000'000),
                                static_cast<std::uint8_t>(config_.robot)));
    output_.images = static_cast<std::uint32_t>(own_->images().size());
  }

  /// T_known_odom of a place that was found.
  RigidPose tie_of(const mapping::ImageHypothesis& place) const {
    return mapping::after(pose_of(place.place), T_grid_odom_);
  }

  void put() {
    const auto found = search_->found();
    put_answer(output_, *search_, static_cast<std::uint32_t>(known_->images().size()),
               found.empty() ? RigidPose{} : tie_of(found[0]), drawn_ns_);
  }

  /// The search came to an end.
  void answer() {
    output_.searches = search_->counts();
    const bool is_found = search_->verdict() == ImageVerdict::found;
    step_ = is_found && check_ != nullptr ? Step::wait : Step::rest;
    if (step_ == Step::wait) return;
    if (is_found) ++output_.counts.unverified;
    put();
    tell();
  }

  /// An answer is whole: out with it.
  void tell() {
    rt::RecognisedPlace* const report = answers_->claim();
    if (report == nullptr) return;
    *report = output_;
    answers_->publish();
  }

  /// The newest scan is held against the known map at the place that was found, and at those it is compared
  /// with.
  void begin_judging() {
    if (check_->begin()) {
      for (const mapping::ImageHypothesis& place : search_->found()) check_->add(tie_of(place));
      step_ = Step::judge;
      return;
    }
    step_ = Step::rest;
    ++output_.counts.unverified;
    put();
    tell();
  }

  void judge(std::uint64_t& units) {
    const std::uint64_t given = units / kJudgeUnits;
    std::uint64_t left = given;
    mapping::JudgedPlace judged;
    const bool done = check_->run(left, judged);
    units -= kJudgeUnits * (given - left);
    if (done) take(judged);
  }

  void take(const mapping::JudgedPlace& judged) {
    put();
    output_.share = judged.share;
    output_.crossed = judged.crossed;
    if (!check_->confirms(judged, tie_of(search_->found()[0]))) {
      output_.verdict = by_images(rt::RecognisedPlace::kRefused);
      ++output_.counts.refused;
      tell();
      search_->refuse(*known_);
      step_ = Step::search;  // which has ended: the next job takes its answer
      return;
    }
    step_ = Step::rest;
    output_.verdict = by_images(rt::RecognisedPlace::kRecognised);
    ++output_.counts.recognised;
    const RigidPose tie = check_->tie(judged);
    rt::store(tie.p, output_.p_known_odom_m);
    rt::store(tie.q, output_.q_known_odom);
    tell();
    if (check_->look(judged)) ++output_.counts.placed;
  }

  RecogniseImagesConfig config_;
  ChosenMap* map_;
  LocateAccess* access_;
  std::unique_ptr<mapping::ImageStore> own_;      ///< what this run has seen
  std::unique_ptr<mapping::ImageStore> known_;    ///< what it began with, or null
  std::unique_ptr<mapping::ImageSearch> search_;  ///< null without known images
  std::unique_ptr<PlaceCheck> check_;             ///< null without a map that they lie on
  mapping::HeightImager imager_;
  Step step_{Step::rest};
  RigidPose T_grid_odom_;  ///< as the image was drawn that is searched with
  const rt::Task<RecogniseImagesOutput>* task_{};
  std::unique_ptr<ReportQueue<rt::RecognisedPlace>> own_answers_;  ///< null where `recognise` has one
  ReportQueue<rt::RecognisedPlace>* answers_{};  ///< for telemetry; full: the next one tells
  rt::Nanoseconds next_ns_{};
  rt::Nanoseconds drawn_ns_{};  ///< release of the job that drew the image
  RecogniseImagesOutput output_;
};

}  // namespace

std::unique_ptr<Part> make_recognise_images(VehicleBuilder& builder) {
  return std::make_unique<RecogniseImagesPart>(builder);
}

}  // namespace sortie::firmware
