// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/recognition_trials.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/recognition/local_run.hpp"
#include "tests/bench/recognition/owned_sets.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;
using testing::Draws;

constexpr double kSameMove = 1.0;  ///< m and rad: a scan fits where the segments say
constexpr double kSameTurn = 0.2;
constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;
constexpr RegistrationMemory kSurfaces{65'536, 256, 64};

/// T_known_odom.
RigidPose pose_of(const LevelPlace& place) {
  return {{place.x_m, place.y_m, place.z_m},
          rt::from_yaw_pitch_roll(std::atan2(place.sine, place.cosine), 0, 0)};
}

PoseError error_of(const RigidPose& told, const RigidPose& truth) {
  const double turn = rt::norm(rt::log_rotation(told.q * rt::conjugate(truth.q)));
  return {rt::norm(told.p - truth.p), turn * 180.0 / M_PI};
}

/// What was kept, and who recognises on it.
class Recognition {
 public:
  explicit Recognition(const TrialConfig& config)
      : memory_(80),
        config_(config),
        keeper_({}, {}, memory_.arena),
        images_({}, memory_.arena),
        image_search_(config.image_search),
        registration_({}, memory_.arena, kSurfaces),
        recogniser_(config.recogniser, memory_.arena),
        judge_(config.judge, registration_, memory_.arena) {
    memory_.check();
  }

  void keep(const std::vector<HallAt>& places, const HallLidar& lidar, Draws& draws) {
    LocalRun run(config_.radius_m);
    for (const HallAt& place : places) {
      bool even = false;
      for (const HallScan& scan : visit_scans(place.hall, 0, lidar, draws)) {
        const RigidPose pose = after(place.T_world_hall, scan.pose);
        if (run.scan(scan.points, pose)) {
          keeper_.keep(run.segments(), run.grid(), {}, run.now_ns());
          if (config_.images && draw_image(run))
            (void)images_.put(imager_.image(), {imager_.image().middle, {}}, 0, 0);
        }
        even = !even;
        if (!even) continue;
        registration_.take(scan.points);
        registration_.insert(pose);
      }
    }
    std::uint64_t units = kAll;
    keeper_.run(units);
  }

  RecognitionTrial recognise(const HallAt& place, const HallLidar& lidar, Draws& draws) {
    RecognitionTrial trial;
    trial.targets = keeper_.store().kept();
    trial.images = static_cast<std::uint32_t>(images_.images().size());
    LocalRun run(config_.radius_m);
    PlaceLooks looks{{config_.second_look_m, config_.second_look_m}};
    PlaceLooks image_looks = looks;
    const RigidPose T_odom_world{{draws.uniform(-20, 20), draws.uniform(-20, 20), draws.uniform(-1, 1)},
                                 rt::from_yaw_pitch_roll(draws.uniform(-M_PI, M_PI), 0, 0)};
    double way_m = 0.0, looked_m = 0.0;
    const std::vector<HallScan> scans = visit_scans(place.hall, 1, lidar, draws);
    for (std::size_t i = 0; i < scans.size(); ++i) {
      if (i > 0) way_m += rt::norm(scans[i].pose.p - scans[i - 1].pose.p);
      const RigidPose truth = after(place.T_world_hall, scans[i].pose);
      const RigidPose odom = after(T_odom_world, truth);
      const bool round = run.scan(scans[i].points, odom);
      if (way_m > config_.most_way_m) break;
      const bool last = i + 2 >= scans.size();
      if (!round || (way_m < looked_m + config_.look_m && !last)) continue;
      looked_m = way_m;
      RecognitionLook look = search(run, odom, truth);
      look.way_m = way_m;
      if (config_.images) search_images(run, odom, truth, look.image);
      const bool images_found = look.image.verdict == ImageVerdict::found;
      if (look.segments == SetVerdict::found || images_found) {
        const rt::Quaternion error = rt::exp_rotation({0.006 * draws.normal(), 0.006 * draws.normal(), 0});
        registration_.take(scans[i].points);
        const SampleScan scan{{registration_.sample().begin(), registration_.sample().end()},
                              rt::normalised(error * odom.q),
                              odom,
                              truth};
        if (look.segments == SetVerdict::found)
          judge(
              scan, [this] { return places(); }, [this] { refuse(); }, look);
        if (images_found)
          judge(
              scan, [this] { return image_places(); }, [this] { image_search_.refuse(images_); }, look.image);
      }
      look.judged.sure = false;
      look.confirmed = look.placed && looks.take(look.judged, odom);
      look.image.judged.sure = false;
      look.image.confirmed = look.image.placed && image_looks.take(look.image.judged, odom);
      trial.looks.push_back(look);
    }
    return trial;
  }

 private:
  RecognitionLook search(const LocalRun& run, const RigidPose& odom, const RigidPose& truth) {
    RecognitionLook look;
    const std::vector<SpeakingSegment> speaking = run.speaking(recogniser_.config().segments);
    look.speaking = static_cast<std::uint32_t>(speaking.size());
    recogniser_.begin(speaking, {});
    go_on();
    look.segments = recogniser_.verdict();
    const auto found = recogniser_.found();
    if (!found.empty()) look.agree = found[0].count;
    if (found.size() > 1) look.rival = found[1].count;
    if (look.segments == SetVerdict::found)
      look.found = error_of(after(pose_of(found[0].fit.place), odom), truth);
    return look;
  }

  /// Where a search that found a place, and only that, says that the local map lies; the best one first.
  std::vector<LevelPlace> places() const {
    std::vector<LevelPlace> list;
    if (recogniser_.verdict() != SetVerdict::found) return list;
    for (const SetHypothesis& one : recogniser_.found()) list.push_back(one.fit.place);
    return list;
  }
  std::vector<LevelPlace> image_places() const {
    std::vector<LevelPlace> list;
    if (image_search_.verdict() != ImageVerdict::found) return list;
    for (const ImageHypothesis& one : image_search_.found()) list.push_back(one.place);
    return list;
  }
  void refuse() {
    recogniser_.refuse();
    go_on();
  }

  bool draw_image(const LocalRun& run) {
    imager_.begin(run.grid());
    while (imager_.is_working()) (void)imager_.run(run.grid(), ~std::uint32_t{0});
    return imager_.stage() == ImageStage::drawn;
  }

  void search_images(const LocalRun& run, const RigidPose& odom, const RigidPose& truth, ImageLook& look) {
    look.verdict = ImageVerdict::few;
    if (!draw_image(run)) return;
    const double begin = set_cpu_ms();
    image_search_.begin(imager_.image());
    std::uint64_t units = kAll;
    (void)image_search_.run(images_, units);
    look.ms = set_cpu_ms() - begin;
    look.units = kAll - units;
    look.verdict = image_search_.verdict();
    const auto found = image_search_.found();
    if (found.empty()) return;
    look.best = error_of(after(pose_of(found[0].place), odom), truth);
    look.agree = found[0].score.agree;
    if (found.size() > 1) look.rival = static_cast<double>(found[1].score.total()) / found[0].score.total();
  }

  /// A scan that places are held against.
  struct SampleScan {
    std::vector<SamplePoint> sample;
    rt::Quaternion q_level_sensor;
    RigidPose odom, truth;
  };

  template <class Places, class Refuse, class Look>
  void judge(const SampleScan& scan, const Places& places, const Refuse& refuse, Look& look) {
    for (std::vector<LevelPlace> list = places(); !list.empty(); list = places()) {
      if (!judge_.begin(scan.sample, scan.q_level_sensor)) return;
      for (const LevelPlace& place : list) judge_.add(after(pose_of(place), scan.odom));
      std::uint64_t units = kAll;
      (void)judge_.run(units, look.judged);
      look.scan = look.judged.verdict;
      const RigidPose told = after(pose_of(list[0]), scan.odom);
      if (look.scan == RelocateVerdict::placed &&
          !are_apart(look.judged.T_map_sensor, told, kSameMove, kSameTurn)) {
        look.placed = error_of(look.judged.T_map_sensor, scan.truth);
        return;
      }
      refuse();
    }
  }

  void go_on() {
    std::uint64_t units = kAll;
    (void)recogniser_.run(keeper_.store(), units);
  }

  TrialMemory memory_;
  TrialConfig config_;
  TargetKeeper keeper_;
  ImageStore images_;
  HeightImager imager_;
  ImageSearch image_search_;
  ScanRegistration registration_;
  Recogniser recogniser_;
  PlaceJudge judge_;
};

}  // namespace

RecognitionTrial try_recognition(const RecognitionWorld& world, const TrialConfig& config, Draws& draws) {
  Recognition recognition(config);
  const auto lidar = [&] { return config.sparse ? sparse_lidar(draws) : hall_lidar(draws); };
  const HallLidar first = lidar(), second = lidar();
  recognition.keep(world.kept, first, draws);
  RecognitionTrial trial = recognition.recognise(world.now, second, draws);
  trial.is_kept = world.is_kept;
  trial.moved = world.moved;
  return trial;
}

}  // namespace sortie::bench
