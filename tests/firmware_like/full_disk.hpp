// SPDX-License-Identifier: BSD-3-Clause
// A disk that is full, for this process alone.
#pragma once

#include <sys/resource.h>

#include <csignal>
#include <cstdint>

namespace sortie::testing {

/// Files of this process end at `bytes`, as a full disk ends them, while this lives.
class FullDisk {
 public:
  explicit FullDisk(std::uint64_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = static_cast<rlim_t>(bytes);
    works_ = setrlimit(RLIMIT_FSIZE, &limit) == 0;
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  bool works() const { return works_; }

 private:
  void (*handler_)(int);
  rlimit before_{};
  bool works_{};
};

}  // namespace sortie::testing
