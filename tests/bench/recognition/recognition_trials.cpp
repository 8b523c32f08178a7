// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/recognition_trials.hpp"

#include <cmath>
#include <memory>
#include <set>

#include "mapping/registration/pose_algebra.hpp"
#include "tests/bench/recognition/image_trial.hpp"
#include "tests/bench/recognition/scan_check.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;
using testing::Draws;

constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;

/// Where a robot's odometry begins: anywhere.
RigidPose draw_frame(Draws& draws) {
  return {{draws.uniform(-20, 20), draws.uniform(-20, 20), draws.uniform(-1, 1)},
          rt::from_yaw_pitch_roll(draws.uniform(-M_PI, M_PI), 0, 0)};
}

/// What was kept, and who recognises on it.
class Recognition {
 public:
  explicit Recognition(const TrialConfig& config)
      : memory_(16),
        config_(config),
        keeper_({}, {}, memory_.arena),
        recogniser_(config.recogniser, memory_.arena),
        surfaces_(config.judge) {
    memory_.check();
    if (config.images) images_ = std::make_unique<ImageTrial>(config.image_search, config.second_look_m);
  }

  /// Maps scans anew, and keeps what speaks in the world's frame.
  class Keeping {
   public:
    explicit Keeping(Recognition& own) : own_(own), run_(own.config_.radius_m, own.config_.rest_ns) {}
    void take(const std::vector<HallScan>& scans, const RigidPose& T_world_hall) {
      int at = 0;
      for (const HallScan& scan : scans) {
        const RigidPose pose = after(T_world_hall, scan.pose);
        if (run_.scan(scan.points, pose)) {
          own_.keeper_.keep(run_.segments(), run_.grid(), {}, run_.now_ns());
          if (own_.images_) own_.images_->keep(run_.grid());
        }
        if (at++ % own_.config_.every != 0) continue;
        own_.surfaces_.registration.take(scan.points);
        own_.surfaces_.registration.insert(pose);
      }
    }
    void end() {
      std::uint64_t units = kAll;
      own_.keeper_.run(units);
    }

   private:
    Recognition& own_;
    LocalRun run_;
  };

  RecognitionTrial recognise(const std::vector<HallScan>& scans, const RigidPose& T_world_hall,
                             const RigidPose& T_odom_world, Draws& draws) {
    RecognitionTrial trial;
    trial.targets = keeper_.store().kept();
    if (images_) trial.images = images_->kept();
    LocalRun run(config_.radius_m, config_.rest_ns);
    PlaceLooks looks{{config_.second_look_m, config_.second_look_m}};
    double way_m = 0.0, looked_m = 0.0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      if (i > 0) way_m += rt::norm(scans[i].pose.p - scans[i - 1].pose.p);
      const RigidPose truth = after(T_world_hall, scans[i].pose);
      const RigidPose odom = after(T_odom_world, truth);
      const bool round = run.scan(scans[i].points, odom);
      if (way_m > config_.most_way_m) break;
      const bool last = i + 2 >= scans.size();
      if (!round || (way_m < looked_m + config_.look_m && !last)) continue;
      looked_m = way_m;
      RecognitionLook look = search(run, odom, truth);
      look.way_m = way_m;
      if (look.segments == SetVerdict::found) judge(scans[i].points, odom, truth, draws, look);
      look.judged.sure = false;
      look.confirmed = look.placed && looks.take(look.judged, odom);
      if (images_)
        images_->look(
            run.grid(), odom, truth, [&] { return scan_at(scans[i].points, odom, draws); }, surfaces_.judge,
            look.image);
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
    count_right(speaking, after(truth, inverse(odom)), look);
    look.segments = recogniser_.verdict();
    const auto found = recogniser_.found();
    if (!found.empty()) look.agree = found[0].count;
    if (found.size() > 1) look.rival = found[1].count;
    if (look.segments == SetVerdict::found)
      look.found = error_of(after(pose_of(found[0].fit.place), odom), truth);
    return look;
  }

  /// What could be found: before any place is refused.
  void count_right(const std::vector<SpeakingSegment>& speaking, const RigidPose& T_known_odom,
                   RecognitionLook& look) const {
    const auto is_same = [&](const PlaceCm& segment, const PlaceCm& target) {
      const rt::Vector3 at{0.01 * segment.x, 0.01 * segment.y, 0.01 * segment.z};
      const PlaceCm known = to_cm(T_known_odom.p + rt::rotate(T_known_odom.q, at));
      return static_cast<double>(square_apart(known, target)) <= 1e4 * kSamePlace_m * kSamePlace_m;
    };
    const TargetStore& store = keeper_.store();
    std::set<std::uint16_t> asked;
    for (const SweptPair& pair : recogniser_.pairs()) {
      if (is_same(pair.segment, pair.target)) asked.insert(pair.pair.segment);
    }
    look.asked_right = static_cast<std::uint32_t>(asked.size());
    for (const SpeakingSegment& one : speaking) {
      for (std::size_t t = 0; t < store.records().size(); ++t) {
        if (store.records()[t].state == TargetState::free || !is_same(one.place, store.places()[t])) continue;
        ++look.kept;
        break;
      }
    }
  }

  CheckedScan scan_at(const std::vector<rt::ScanPoint>& points, const RigidPose& odom, Draws& draws) {
    const rt::Quaternion error = rt::exp_rotation({0.006 * draws.normal(), 0.006 * draws.normal(), 0});
    surfaces_.registration.take(points);
    const auto taken = surfaces_.registration.sample();
    sample_.assign(taken.begin(), taken.end());
    return {sample_, odom, rt::normalised(error * odom.q)};
  }

  void judge(const std::vector<rt::ScanPoint>& points, const RigidPose& odom, const RigidPose& truth,
             Draws& draws, RecognitionLook& look) {
    const CheckedScan scan = scan_at(points, odom, draws);
    const bool placed = place_by_scan(
        scan, recogniser_, keeper_.store(), [this]() -> PlaceJudge& { return surfaces_.judge; }, look.judged);
    look.scan = look.judged.verdict;
    if (placed) look.placed = error_of(look.judged.T_map_sensor, truth);
  }

  void go_on() {
    std::uint64_t units = kAll;
    (void)recogniser_.run(keeper_.store(), units);
  }

  TrialMemory memory_;
  TrialConfig config_;
  TargetKeeper keeper_;
  Recogniser recogniser_;
  SurfaceMap surfaces_;
  std::vector<SamplePoint> sample_;
  std::unique_ptr<ImageTrial> images_;  ///< null: not asked for
};

}  // namespace

RecognitionTrial try_recognition(const RecognitionWorld& world, const TrialConfig& config, Draws& draws) {
  Recognition recognition(config);
  const auto lidar = [&] { return config.sparse ? sparse_lidar(draws) : hall_lidar(draws); };
  const HallLidar first = lidar(), second = lidar();
  Recognition::Keeping keeping(recognition);
  for (const HallAt& place : world.kept)
    keeping.take(visit_scans(place.hall, 0, first, draws), place.T_world_hall);
  keeping.end();
  const RigidPose T_odom_world = draw_frame(draws);
  const std::vector<HallScan> scans = visit_scans(world.now.hall, 1, second, draws);
  RecognitionTrial trial = recognition.recognise(scans, world.now.T_world_hall, T_odom_world, draws);
  trial.is_kept = world.is_kept;
  trial.moved = world.moved;
  return trial;
}

RecognitionTrial try_scans(const std::vector<HallScan>& kept, const std::vector<HallScan>& now,
                           const TrialConfig& config, Draws& draws) {
  Recognition recognition(config);
  Recognition::Keeping keeping(recognition);
  keeping.take(kept, {});
  keeping.end();
  const RigidPose T_odom_world = draw_frame(draws);
  RecognitionTrial trial = recognition.recognise(now, {}, T_odom_world, draws);
  trial.is_kept = true;
  return trial;
}

}  // namespace sortie::bench
