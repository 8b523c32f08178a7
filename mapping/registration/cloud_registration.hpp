// SPDX-License-Identifier: BSD-3-Clause
// Where a cloud lies in another one, of another sensor and of another scale: planes say where it may lie,
// cells and lines of sight which of these places is the right one.
#pragma once

#include <cstdint>

#include "mapping/registration/cloud_config.hpp"
#include "mapping/registration/plane_registration.hpp"
#include "mapping/registration/sight_fit.hpp"
#include "mapping/registration/sight_layer.hpp"
#include "mapping/registration/sight_votes.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::mapping {

/// Registers planes, then looks at the places that these lead to with the cells of both clouds: at each, and
/// at shifts of it along the directions that walls face, and upwards. A box's top fits a floor as well as the
/// floor does; only what stands on the floor tells. Each place is fitted with the cells.
///
/// A hall may look the same from another place, and less of it may be seen in common there. So the best place
/// is turned by quarters and halves, and mirrored; shifts at which many cells may lie on surfaces are looked
/// at, too. The best place counts where few lines of sight go through surfaces, every direction is held, and
/// every other place that little speaks against explains clearly less. Without a yaw planes alone must place
/// it there as well.
///
/// Each fit and each look costs a fixed number of units; what a budget leaves is kept for the next one. 4 MB;
/// no heap; stack below 80 kB.
class CloudRegistration {
 public:
  /// Most cells of a cloud that are looked at: of more, evenly spread ones.
  static constexpr std::uint32_t kMostCells = 4096;

  explicit CloudRegistration(const CloudRegistrationConfig& config);

  /// Starts anew. Both layers as prepared; they must stay as they are until the end. Errors are those of
  /// PlaneRegistration::begin(): then nothing is done and the verdict is `none`.
  Status begin(const PlaneSet& source_planes, const SightLayer& source, const PlaneSet& target_planes,
               const SightLayer& target, const PlaneEstimate& estimate);
  /// Works on for at most `units` (of about 5 ns), and takes what it used off. True when there is nothing
  /// left to do.
  bool run(std::uint64_t& units);

  const CloudResult& result() const { return result_; }
  /// Of the source's cells.
  const rt::Vector3& middle_m() const { return middle_m_; }
  /// What the planes alone make of it.
  const PlaneRegistrationResult& planes() const { return planes_result_; }

 private:
  enum class Stage : std::uint8_t { done, planes, vote, fit, look, hold };
  static constexpr std::uint32_t kWords = kMostCells / 64;
  static constexpr int kFitSteps = 6;  ///< most of a fit: what every one is charged with
  static constexpr std::uint32_t kMostPlaces = 24;
  /// The places that planes lead to; then those of the best one turned by quarters, and of its mirror image.
  static constexpr std::uint32_t kFirstMirror = 5;
  static constexpr std::uint32_t kPasses = 9;
  /// A pose and which cells speak for it and against it: the source's first.
  struct Place {
    PlanePose pose;
    bool mirrored{};
    std::uint32_t pairs{};  ///< of its fit
    std::uint32_t on{};
    std::uint32_t through{};
    std::uint64_t on_bits[2 * kWords]{};
    std::uint64_t off_bits[2 * kWords]{};
    std::uint64_t through_bits[2 * kWords]{};
    double value() const;
  };

  void take_cells(const SightLayer& from, SightCell (&cells)[kMostCells], std::uint32_t& count);
  void find_axes();
  std::uint64_t next_cost() const;
  void step();
  void end_planes();
  bool next_pass();
  void vote();
  void fit();
  void settle();
  void keep_place();
  void end_start();
  void end_pass();
  void hold();
  void judge();
  void look(const PlanePose& pose, Place& place);
  PlanePose shifted(const PlanePose& pose, std::uint32_t k, const double (&by_m)[8]) const;
  bool contends(const Place& place) const;
  void compare(const Place& best, const Place& other, bool apart);
  bool in_mirror() const { return pass_ >= kFirstMirror; }

  /// Mirrored in those passes.
  std::span<const SightCell> source_cells() const {
    return {in_mirror() ? image_cells_ : source_cells_, source_count_};
  }
  std::span<const SightCell> target_cells() const { return {target_cells_, target_count_}; }

  CloudRegistrationConfig config_;
  PlaneRegistration plane_registration_;
  PlaneEstimate estimate_;
  const SightLayer* source_{};
  const SightLayer* target_{};
  Stage stage_{Stage::done};
  UnitCredit credit_;
  std::uint32_t pass_{};
  SightVotes votes_;
  rt::FixedVector<PlanePose, kMostSightPeaks * kMostSightPeaks> starts_;  ///< that wait to be settled
  std::uint32_t start_{};
  std::uint32_t round_{};
  std::uint32_t shift_{};  ///< 0: the start itself; then its neighbours; then the best of them
  PlanePose fitted_;       ///< that is looked at next
  std::uint32_t fitted_pairs_{};
  rt::Vector3 axis_[3];   ///< directions that the target's walls face, and the upright
  rt::Vector3 mirror_;    ///< axis of the source's mirror image
  rt::Vector3 middle_m_;  ///< of the source's cells
  Place places_[kMostPlaces];
  std::uint32_t place_count_{};
  std::uint32_t best_{};
  Place here_;   ///< that is being settled
  Place ahead_;  ///< the best of its neighbours
  Place look_;
  SightCell source_cells_[kMostCells];
  SightCell target_cells_[kMostCells];
  SightCell image_cells_[kMostCells];
  SightCell scratch_[kMostCells];
  std::uint32_t source_count_{};
  std::uint32_t target_count_{};
  PlaneRegistrationResult planes_result_;
  CloudResult result_;
};

}  // namespace sortie::mapping
