// SPDX-License-Identifier: BSD-3-Clause
// How a file of a run comes to be. The rule for whatever this program writes: nobody ever finds half a file,
// and what stood there stays until what replaces it is worth more.
//
// - A file is made beside its place, as PATH.part, and takes the place by a rename: at once there, and whole.
// - It takes the place when it holds something: the log and the flight ring of a run with its first job, a
//   table or a report when it is complete. A start that is refused or dies before has touched nothing.
// - What may be the only witness of a run (log, truth of a plant, unfinished ring) is kept as PATH.previous.
// - PATH.part of a program that died is nobody's: the next one takes it. That of a living one is locked.
#pragma once

#include <string>

namespace sortie::rt::posix {

/// PATH, or where it leads as a symbolic link: a rename must not replace the link itself. Takes heap.
std::string place_of(const std::string& path);
/// True when a device, a pipe or a socket stands there: no rename may replace it, it is written directly.
bool is_special_file(const std::string& path) noexcept;

/// True while a process that makes or writes the file at `path` holds its lock.
bool is_being_written(const std::string& path) noexcept;

/// True when an open file lies in memory (tmpfs, ramfs, hugetlbfs): no store into its map waits for a disk.
bool on_memory_file_system(int file) noexcept;

/// What becomes of what stood at the place.
enum class FormerFile {
  replaced,  ///< gone
  kept,      ///< as PATH.previous; the one that was called so before is gone
};

/// A file in the making. Not for real-time threads; no call blocks on anything but the file system.
class FilePlace {
 public:
  /// Makes PATH.part, empty and locked (flock) as long as the descriptor lives; a device or pipe at PATH is
  /// opened itself. `mode` as of open(). Throws std::runtime_error (path, system's reason, cure): the folder
  /// cannot be written, PATH or PATH.part belongs to a process that still writes it.
  explicit FilePlace(const std::string& path, unsigned mode = 0644);
  /// Removes PATH.part unless it has taken its place.
  ~FilePlace();
  FilePlace(const FilePlace&) = delete;
  FilePlace& operator=(const FilePlace&) = delete;

  /// Open for reading and writing (a device: writing). Belongs to this object.
  int descriptor() const noexcept { return file_; }
  /// Another descriptor of the same file, for somebody who closes it himself; -1 when there is none left.
  int second_descriptor() const noexcept;
  /// Renames it to PATH; once, afterwards nothing happens. There is no moment without a file at PATH, where
  /// the file system has hard links. Empty, or what the system refused: then the file stays as PATH.part.
  std::string take(FormerFile former);
  /// True once take() was good, and for a device at once.
  bool taken() const noexcept { return taken_; }
  /// True when take() has kept a file that stood there.
  bool former_kept() const noexcept { return former_kept_; }
  /// True when something stands at PATH now.
  bool occupied() const noexcept;

  const std::string& path() const noexcept { return path_; }
  std::string part() const { return path_ + ".part"; }
  std::string previous() const { return path_ + ".previous"; }

 private:
  void open_part(unsigned mode);
  bool keep_former() noexcept;

  std::string path_;
  int file_{-1};
  bool taken_{};
  bool refused_{};
  bool former_kept_{};
};

}  // namespace sortie::rt::posix
