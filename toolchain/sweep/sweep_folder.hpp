// SPDX-License-Identifier: BSD-3-Clause
// A sweep kept as files, so that it can be stopped, shared out and put together again: plan.json says what is
// to be run, cell-00042.json what one cell gave. A cell carries a key of everything its figures depend on; a
// cell with another key is taken for missing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_like/runtime/kept_map.hpp"
#include "toolchain/judge/map_volume.hpp"
#include "toolchain/sweep/sweep_plan.hpp"

namespace sortie::toolchain {

/// What all cells share, as a command line says it.
struct SweepRequest {
  std::vector<std::string> logs;
  std::string scene;
  firmware::KeptMapPaths maps;  ///< that each cell begins with
  std::vector<std::string> overrides;
  std::vector<std::string> knobs;  ///< "key=v1,v2" each, or "knobs" alone: each knob of a scene alone
  std::vector<std::string> tasks;
  std::string error;
  std::string align{"none"};
  double calibrate_s{};
  std::uint32_t repeat{1};
  bool instructions{};

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit("logs", self.logs);
    visit("scene", self.scene);
    firmware::KeptMapPaths::fields(self.maps, visit);
    visit("set", self.overrides);
    visit("sweep", self.knobs);
    visit("tasks", self.tasks);
    visit("error", self.error);
    visit("align", self.align);
    visit("repeat", self.repeat);
    visit("instructions", self.instructions);
    visit("calibrate_s", self.calibrate_s);
  }
};

/// The request as run_sweep() takes it. Throws ProfileError for knobs that cannot be read.
SweepOptions sweep_options(const SweepRequest& request);

/// One sweep of one log.
struct PlannedLog {
  std::string path;
  std::string identity;  ///< 16 hexadecimal digits: of its bytes, or of what it was simulated from
  bool simulated{};      ///< recorded for this sweep: its bytes hold run times, which differ every time
  SweepPlan plan;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit("path", self.path);
    visit("identity", self.identity);
    visit("simulated", self.simulated);
    visit("scene", self.plan.sweep.scene);
    visit("keys", self.plan.sweep.keys);
    visit("tasks", self.plan.sweep.tasks);
    visit("error", self.plan.sweep.error);
    visit("repeat", self.plan.sweep.repeat);
    visit("warnings", self.plan.sweep.warnings);
  }
};

/// All cells of all sweeps, numbered through: those of the first come first.
struct SweepFolderPlan {
  SweepRequest request;
  std::string program;  ///< digest of the program's own file
  std::vector<PlannedLog> logs;

  std::size_t cell_count() const;
  /// Log and place in it of a cell. Precondition: cell < cell_count().
  std::pair<std::size_t, std::size_t> locate(std::size_t cell) const;
  /// Digest of program, log, profile and settings of one cell.
  std::string key(std::size_t cell) const;
  /// "map.voxel_m=0.2 of hall.lcm".
  std::string title(std::size_t cell) const;
};

/// Figures of one cell that was run.
struct SweepCellResult {
  SweepCell cell;
  double duration_s{};  ///< of the log
  std::optional<MapVolume> map;
};

/// All of a file. Throws InputError with `cure`.
std::string whole_file(const std::string& path, const std::string& cure);
/// Digest of bytes, 16 hexadecimal digits.
std::string hex_digest(const std::string& bytes);
/// That of a file's. Throws InputError.
std::string digest_of_file(const std::string& path);

/// write_file() by way of a name that no other process uses: several may write the same file at a time, each
/// whole. Throws InputError.
void write_shared(const std::string& path, const std::string& text);
/// ".HOST.PID", the end of such a name.
std::string own_suffix();

/// Writes FOLDER/plan.json, whole or not at all. Throws InputError.
void write_plan(const std::string& folder, const SweepFolderPlan& plan);
/// Reads it. Throws InputError, with the cure where there is none.
SweepFolderPlan read_plan(const std::string& folder);

/// Writes one cell, whole or not at all, whoever else writes it at the same time. Throws InputError.
void write_cell(const std::string& folder, std::size_t number, const std::string& key,
                const SweepCellResult& result);
/// Reads one cell: nothing where it is missing, damaged or not that of the plan.
std::optional<SweepCellResult> read_cell(const std::string& folder, std::size_t cell,
                                         const SweepFolderPlan& plan);
/// "cell-00042.json".
std::string cell_file(std::size_t cell);

}  // namespace sortie::toolchain
