// SPDX-License-Identifier: BSD-3-Clause
// A vehicle's own cloud on a kept one: planes are grown over the cells of both, then the clouds are
// registered, a budget at a time, and the same with wider cells.
#pragma once

#include <optional>
#include <span>

#include "mapping/registration/cloud_registration.hpp"
#include "mapping/registration/plane_growing.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// A cloud, and by what its cells were seen.
struct SensedCloud {
  SightLayer* layer{};
  CloudSensor sensor{CloudSensor::laser};
};

/// Where a wall is cut by its cells decides which of them are flat, and so whether enough speaks for the
/// right place. So the finer cloud (the kept one, where both are as fine) is asked again in cells twice as
/// wide, on up to eight grids of them. A place counts when one grid places the cloud there and another has it
/// as its best place, too, to `most_sigma_m` and twice `most_sigma_rad`; none is asked after that. Without a
/// yaw two have to place it there.
///
/// From begin() until the end of its run() the own cloud has to stay as it is; the kept one for ever. The
/// result depends on both clouds and the estimate alone, not on how budgets cut the work. Memory: that of
/// CloudRegistration, and of an arena 150 bytes a cell of the larger cloud, 0.8 MB, and a layer like that of
/// the finer cloud. No heap; stack below 80 kB.
class CloudMatch {
 public:
  /// Set-up: prepares the kept cloud and grows its planes: 2 us a cell.
  CloudMatch(const CloudMatchConfig& config, const SensedCloud& own, const SensedCloud& kept,
             rt::Arena& arena);

  /// Starts anew. `estimate`: T_kept_own as it is known.
  void begin(const PlaneEstimate& estimate);
  /// Works on for at most `units` (of about 5 ns), and takes what it used off. True when there is nothing
  /// left to do. A step is paid before, by what budgets left, too: sixteen cells, one of CloudRegistration's,
  /// a sort of a cloud's cells (10 units each), or clearing what there is room for (5 units a cell).
  bool run(std::uint64_t& units);
  bool works() const { return stage_ != Stage::idle; }

  /// Of the last that ended: of the grid that placed it, with the work of all; where none did, of the clouds'
  /// own cells.
  const CloudResult& result() const { return result_; }
  /// What each grid that was asked made of it, the clouds' own cells first, in the clouds' own frames; work
  /// is summed up. No part of the state.
  std::span<const CloudResult> answers() const { return {found_, grid_ + 1}; }

  /// State to bytes and back, where the own cloud is as it was: reading repeats the work that was done.
  void archive(rt::Archive& archive);

 private:
  enum class Stage : std::uint8_t { idle, clear, widen, sort, cells, memory, planes, grow, match };
  static constexpr std::uint32_t kMostAsked = 1 + CloudMatchConfig::kMostGrids;
  static constexpr std::uint64_t kUnitsPerCleared = 5;  ///< a cell that there is room for; then a cell:
  static constexpr std::uint64_t kUnitsPerWidened = 25;
  static constexpr std::uint64_t kUnitsPerSorted = 10;
  static constexpr std::uint64_t kUnitsPerCell = 110;
  static constexpr std::uint64_t kUnitsPerPlaneCell = 200;
  static constexpr std::uint64_t kUnitsPerGrowing = 100;  ///< half a microsecond

  void clear_planes(const SensedCloud& cloud);
  void set_cells(const SightLayer& layer, std::span<const SurfelIndex> some);
  bool own_is_finer() const { return own_.layer->cell_m() < kept_.layer->cell_m(); }
  const SensedCloud& finer() const { return own_is_finer() ? own_ : kept_; }
  SightLayer& made() { return grid_ == 0 ? *own_.layer : wide_; }
  template <class F>
  bool pass(std::uint64_t cost, std::uint64_t& units, F&& take);
  rt::Vector3 widen(std::span<const SurfelIndex> some);
  bool begin_match();
  void end_match();
  PlanePose moved(const PlanePose& pose, double times) const;
  bool step(std::uint64_t& units);
  bool grow(std::uint64_t& units);

  CloudMatchConfig config_;
  SensedCloud own_;
  SensedCloud kept_;
  SightLayer wide_;  ///< the finer cloud in cells twice as wide
  PlaneGrowingMemory memory_;
  std::optional<PlaneGrowing> growing_;
  CloudRegistration registration_;
  PlaneSet own_planes_;
  PlaneSet kept_planes_;
  PlaneSet wide_planes_;
  Stage stage_{Stage::idle};
  UnitCredit credit_;
  PlaneEstimate estimate_;
  std::uint64_t spent_{};                ///< since begin()
  std::uint32_t grid_{};                 ///< that is asked; 0: both clouds' own
  std::span<const SurfelIndex> finest_;  ///< cells of the finer cloud, by key
  std::span<const SurfelIndex> cells_;   ///< that a pass takes
  std::size_t next_{};                   ///< of them
  rt::Vector3 moved_m_;                  ///< from the finer cloud's frame to that of wide_
  rt::Vector3 middle_m_;                 ///< of the own cloud
  CloudResult found_[kMostAsked];
  CloudResult result_;
};

}  // namespace sortie::mapping
