// SPDX-License-Identifier: BSD-3-Clause
#include "rt/posix/trace_span.hpp"

#include <cstring>
#include <mutex>

namespace sortie::rt::posix {
namespace {

struct Names {
  std::mutex mutex;
  char text[kMaxSpanNames][32]{};
  std::uint32_t count{};
};

// Names are made by globals of other files, so this one must exist before any of them.
Names& names() {
  static Names all;
  return all;
}

}  // namespace

SpanName::SpanName(const char* name) : index_(0) {
  Names& all = names();
  const std::lock_guard lock(all.mutex);
  static constexpr char kOther[32] = "other";
  char cut[32]{};
  std::strncpy(cut, name, sizeof(cut) - 1);
  for (index_ = 0; index_ < all.count; ++index_) {
    if (std::strcmp(all.text[index_], cut) == 0) return;
  }
  if (all.count == kMaxSpanNames) {
    index_ = kMaxSpanNames - 1;
    return;
  }
  std::memcpy(all.text[all.count], all.count == kMaxSpanNames - 1 ? kOther : cut, sizeof cut);
  index_ = all.count++;
}

std::uint32_t span_name_count() {
  Names& all = names();
  const std::lock_guard lock(all.mutex);
  return all.count;
}

const char* span_name(std::uint32_t index) {
  Names& all = names();
  const std::lock_guard lock(all.mutex);
  return index < all.count ? all.text[index] : "";
}

}  // namespace sortie::rt::posix
