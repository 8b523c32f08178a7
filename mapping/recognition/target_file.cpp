// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/recognition/target_file.hpp"

#include "rt/digest.hpp"

namespace sortie::mapping {
namespace {

constexpr std::size_t kHeadBytes = rt::canonical_size<TargetFileHead>();
constexpr std::size_t kFrameBytes = rt::canonical_size<KeyFrameRecord>();
constexpr std::size_t kTargetBytes = rt::canonical_size<KeptTarget>();
constexpr std::size_t kCheckBytes = 8;
static_assert(kHeadBytes == 24 && kFrameBytes == 22 && kTargetBytes == 56);

TargetFileHead head_of(const TargetStore& store) {
  TargetFileHead head;
  for (std::uint32_t i = 0; i < store.key_frames().key_frames(); ++i)
    head.key_frames += store.key_frames().knows(static_cast<std::uint16_t>(i)) ? 1u : 0u;
  head.targets = store.kept();
  return head;
}

/// No sum overflows: counts have 32 bits.
std::uint64_t bytes_of(const TargetFileHead& head) {
  return kHeadBytes + std::uint64_t{kFrameBytes} * head.key_frames +
         std::uint64_t{kTargetBytes} * head.targets + kCheckBytes;
}

KeptTarget kept_of(const TargetRecord& r) {
  return {r.descriptor, r.id,      r.voxels, r.last_seen_ms, r.offset,
          r.key_frame,  r.version, r.views,  r.robot,        r.uniqueness};
}

TargetRecord record_of(const KeptTarget& kept) {
  TargetRecord r;
  r.descriptor = kept.descriptor;
  r.id = kept.id;
  r.voxels = kept.voxels;
  r.last_seen_ms = kept.last_seen_ms;
  r.offset = kept.offset;
  r.key_frame = kept.key_frame;
  r.version = kept.version;
  r.views = kept.views;
  r.robot = kept.robot;
  r.uniqueness = kept.uniqueness;
  return r;
}

class Loader {
 public:
  Loader(std::span<const std::uint8_t> bytes, TargetStore& store)
      : archive_(rt::Archive::reading(bytes)), bytes_(bytes), store_(store) {}

  TargetFileResult load() {
    store_.clear();
    const bool good = is_good() && take_key_frames() && take_targets();
    if (!good) store_.clear();
    return result_;
  }

 private:
  bool refuse(TargetFileFault fault, std::uint32_t needed = 0) {
    result_.fault = fault;
    result_.needed = needed;
    return false;
  }

  bool is_good() {
    result_ = read_target_head(bytes_);
    if (result_.fault != TargetFileFault::none) return false;
    result_.needed = 0;
    archive_.value(result_.head);
    if (result_.head.targets > store_.capacity())
      return refuse(TargetFileFault::targets_room, result_.head.targets);
    return true;
  }

  bool take_key_frames() {
    std::uint32_t next = 0;
    for (std::uint32_t i = 0; i < result_.head.key_frames; ++i) {
      KeyFrameRecord one;
      result_.byte = archive_.bytes();
      archive_.value(one);
      if (one.number < next) return refuse(TargetFileFault::order);
      next = one.number + 1u;
      if (next > store_.key_frames().key_frames()) return refuse(TargetFileFault::key_frames_room, next);
      if (store_.set_key_frame(one.number, one.pose) != Status::ok) return refuse(TargetFileFault::key_frame);
    }
    return true;
  }

  bool take_targets() {
    for (std::uint32_t i = 0; i < result_.head.targets; ++i) {
      KeptTarget one;
      result_.byte = archive_.bytes();
      archive_.value(one);
      if (store_.find(one.robot, one.id) != kNoTarget) return refuse(TargetFileFault::twice);
      if (store_.take(record_of(one)) != Status::ok) return refuse(TargetFileFault::target);
    }
    result_.byte = 0;
    return true;
  }

  rt::Archive archive_;
  std::span<const std::uint8_t> bytes_;
  TargetStore& store_;
  TargetFileResult result_;
};

}  // namespace

const char* to_string(TargetFileFault fault) {
  switch (fault) {
    case TargetFileFault::none:
      return "none";
    case TargetFileFault::no_targets:
      return "not a file of targets";
    case TargetFileFault::version:
      return "of another version";
    case TargetFileFault::length:
      return "cut off, or too long";
    case TargetFileFault::checksum:
      return "damaged";
    case TargetFileFault::key_frame:
      return "a key frame whose pose cannot be";
    case TargetFileFault::order:
      return "a key frame that is there twice, or out of order";
    case TargetFileFault::target:
      return "a target that cannot be, or hangs on no key frame";
    case TargetFileFault::twice:
      return "a segment that is there twice";
    case TargetFileFault::key_frames_room:
      return "more key frames than there is room for";
    case TargetFileFault::targets_room:
      return "more targets than there is room for";
  }
  return "unknown fault";
}

std::uint64_t target_file_bytes(const TargetStore& store) { return bytes_of(head_of(store)); }

Status write_targets(const TargetStore& store, std::span<std::uint8_t> out) {
  TargetFileHead head = head_of(store);
  if (out.size() < bytes_of(head)) return Status::full;
  rt::Archive archive = rt::Archive::writing(out);
  archive.value(head);
  for (std::uint32_t i = 0; i < store.key_frames().key_frames(); ++i) {
    const auto number = static_cast<std::uint16_t>(i);
    if (!store.key_frames().knows(number)) continue;
    KeyFrameRecord one{number, store.key_frames().latest(number)};
    archive.value(one);
  }
  for (const TargetRecord& record : store.records()) {
    if (record.state == TargetState::free) continue;
    KeptTarget one = kept_of(record);
    archive.value(one);
  }
  std::uint64_t check = rt::digest_bytes(out.data(), static_cast<std::size_t>(archive.bytes()));
  archive.value(check);
  return archive.status();
}

TargetFileResult read_target_head(std::span<const std::uint8_t> bytes) {
  TargetFileResult result;
  rt::Archive archive = rt::Archive::reading(bytes);
  archive.value(result.head);
  const TargetFileHead& head = result.head;
  const TargetFileHead own;
  const auto refused = [&result](TargetFileFault fault) {
    result.fault = fault;
    return result;
  };
  if (archive.status() != Status::ok)
    return refused(head.magic == own.magic ? TargetFileFault::length : TargetFileFault::no_targets);
  if (head.magic != own.magic) return refused(TargetFileFault::no_targets);
  if (head.version != own.version || head.steps != own.steps) return refused(TargetFileFault::version);
  if (bytes_of(head) != bytes.size()) return refused(TargetFileFault::length);
  const std::size_t body = bytes.size() - kCheckBytes;
  rt::Archive tail = rt::Archive::reading(bytes.subspan(body));
  std::uint64_t check = 0;
  tail.value(check);
  if (check != rt::digest_bytes(bytes.data(), body)) return refused(TargetFileFault::checksum);
  if (head.key_frames == 0) return result;
  // They rise: the last one says how many a store must have room for.
  KeyFrameRecord last;
  rt::Archive frame =
      rt::Archive::reading(bytes.subspan(kHeadBytes + kFrameBytes * (head.key_frames - std::size_t{1})));
  frame.value(last);
  result.needed = last.number + 1u;
  return result;
}

TargetFileResult load_targets(std::span<const std::uint8_t> bytes, TargetStore& store) {
  return Loader(bytes, store).load();
}

}  // namespace sortie::mapping
