// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/recognition_trials.hpp"

#include "mapping/registration/pose_algebra.hpp"

namespace sortie::bench {
namespace {
using namespace mapping;
using testing::Draws;

constexpr double kSameMove = 1.0;  ///< m and rad: a scan fits where the segments say
constexpr double kSameTurn = 0.2;
constexpr std::uint64_t kAll = ~std::uint64_t{0} >> 1;
constexpr RegistrationMemory kSurfaces{65'536, 256, 64};

/// What was kept, and who recognises on it.
class Recognition {
 public:
  explicit Recognition(const TrialConfig& config)
      : memory_(80),
        config_(config),
        keeper_({}, {}, memory_.arena),
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
        if (run.scan(scan.points, pose)) keeper_.keep(run.segments(), run.grid(), {}, run.now_ns());
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
    LocalRun run(config_.radius_m);
    PlaceLooks looks{{config_.second_look_m, config_.second_look_m}};
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
      if (look.segments == SetVerdict::found) judge(scans[i].points, odom, truth, draws, look);
      look.judged.sure = false;
      look.confirmed = look.placed && looks.take(look.judged, odom);
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

  void judge(const std::vector<rt::ScanPoint>& scan, const RigidPose& odom, const RigidPose& truth,
             Draws& draws, RecognitionLook& look) {
    const rt::Quaternion error = rt::exp_rotation({0.006 * draws.normal(), 0.006 * draws.normal(), 0});
    registration_.take(scan);
    const std::vector<SamplePoint> sample(registration_.sample().begin(), registration_.sample().end());
    while (recogniser_.verdict() == SetVerdict::found) {
      if (!judge_.begin(sample, rt::normalised(error * odom.q))) return;
      for (const SetHypothesis& place : recogniser_.found())
        judge_.add(after(pose_of(place.fit.place), odom));
      std::uint64_t units = kAll;
      (void)judge_.run(units, look.judged);
      look.scan = look.judged.verdict;
      const RigidPose told = after(pose_of(recogniser_.found()[0].fit.place), odom);
      if (look.scan == RelocateVerdict::placed &&
          !are_apart(look.judged.T_map_sensor, told, kSameMove, kSameTurn)) {
        look.placed = error_of(look.judged.T_map_sensor, truth);
        return;
      }
      recogniser_.refuse();
      go_on();
    }
  }

  void go_on() {
    std::uint64_t units = kAll;
    (void)recogniser_.run(keeper_.store(), units);
  }

  TrialMemory memory_;
  TrialConfig config_;
  TargetKeeper keeper_;
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
