// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/file_place.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace sortie::rt::posix {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw std::runtime_error(path + ": cannot be created: " + why);
}

bool is_locked(int file, int how) { return flock(file, how | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

/// What lies at `part` is a link, or another user's file that no process writes: removed if that is allowed.
bool clear_abandoned(const std::string& part) {
  const int file = open(part.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  const bool lives = file < 0 ? errno != ELOOP : is_locked(file, LOCK_SH);
  if (file >= 0) close(file);
  return !lives && unlink(part.c_str()) == 0;
}

/// Two names of one file, or a name that has gone meanwhile.
bool is_at(int file, const std::string& path) {
  struct stat open_one {};
  struct stat named {};
  return fstat(file, &open_one) == 0 && lstat(path.c_str(), &named) == 0 && open_one.st_ino == named.st_ino &&
         open_one.st_dev == named.st_dev;
}

}  // namespace

std::string place_of(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const std::filesystem::path place = std::filesystem::canonical(path, error);
  return error ? path : place.string();
}

bool is_special_file(const std::string& path) noexcept {
  struct stat found {};
  return stat(path.c_str(), &found) == 0 && !S_ISREG(found.st_mode) && !S_ISDIR(found.st_mode);
}

bool is_being_written(const std::string& path) noexcept {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  const bool lives = is_locked(file, LOCK_SH);
  close(file);
  return lives;
}

bool on_memory_file_system(int file) noexcept {
  constexpr unsigned long kTmpfs = 0x01021994ul;
  constexpr unsigned long kRamfs = 0x858458f6ul;
  constexpr unsigned long kHugetlbfs = 0x958458f6ul;
  struct statfs found {};
  if (fstatfs(file, &found) != 0) return false;
  const unsigned long type = static_cast<unsigned long>(found.f_type) & 0xfffffffful;
  return type == kTmpfs || type == kRamfs || type == kHugetlbfs;
}

FilePlace::FilePlace(const std::string& path, unsigned mode) : path_(place_of(path)) {
  if (is_special_file(path_)) {
    file_ = open(path_.c_str(), O_WRONLY | O_CLOEXEC);
    if (file_ < 0) refuse(path_, std::strerror(errno));
    taken_ = true;
    return;
  }
  struct stat found {};
  if (stat(path_.c_str(), &found) == 0 && S_ISDIR(found.st_mode))
    refuse(path_, "it is a folder; give a file");
  if (is_being_written(path_)) refuse(path_, "a run that is still going uses it; choose another file");
  open_part(mode);
}

// A name may go away between its opening and its lock, when a program that ends takes its file with it.
void FilePlace::open_part(unsigned mode) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    file_ = open(part().c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, mode);
    const int error = errno;
    struct stat found {};
    const bool ours =
        file_ >= 0 && fstat(file_, &found) == 0 && S_ISREG(found.st_mode) && found.st_uid == geteuid();
    const bool lives = ours && is_locked(file_, LOCK_EX);
    if (ours && !lives && is_at(file_, part()) && ftruncate(file_, 0) == 0) return;
    if (file_ >= 0) close(file_);
    const bool was_open = file_ >= 0;
    file_ = -1;
    if (lives) refuse(path_, "a run that is still going makes it; choose another file");
    if (ours) continue;
    if ((was_open || error == ELOOP || error == EACCES) && clear_abandoned(part())) continue;
    refuse(path_,
           was_open ? part() + " is another user's; remove it, or choose another file"
                    : std::string(std::strerror(error)) + "; give a path in a directory that can be written");
  }
  refuse(path_, "another program keeps making it; choose another file");
}

FilePlace::~FilePlace() {
  if (!taken_ && !refused_ && file_ >= 0) unlink(part().c_str());
  if (file_ >= 0) close(file_);
}

int FilePlace::second_descriptor() const noexcept { return fcntl(file_, F_DUPFD_CLOEXEC, 0); }

bool FilePlace::occupied() const noexcept {
  struct stat found {};
  return !taken_ && lstat(path_.c_str(), &found) == 0;
}

// By a second name, so that no kill finds the place empty; without hard links it takes two renames.
bool FilePlace::keep_former() noexcept {
  const std::string spare = previous() + ".part";
  unlink(spare.c_str());
  bool kept = false;
  if (link(path_.c_str(), spare.c_str()) == 0) {
    kept = std::rename(spare.c_str(), previous().c_str()) == 0;
    const int reason = errno;
    unlink(spare.c_str());  // still there where both were names of one file: a kill came between
    errno = reason;
  } else {
    kept = std::rename(path_.c_str(), previous().c_str()) == 0;
  }
  former_kept_ = kept;
  return kept;
}

std::string FilePlace::take(FormerFile former) {
  if (taken_ || refused_) return {};
  const bool good = (former == FormerFile::replaced || !occupied() || keep_former()) &&
                    std::rename(part().c_str(), path_.c_str()) == 0;
  if (good) {
    taken_ = true;
    return {};
  }
  refused_ = true;
  return path_ + ": what stands there cannot be moved (" + std::strerror(errno) + "); the new file is " +
         part();
}

}  // namespace sortie::rt::posix
