// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/keyframes.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "firmware_like/scene/input_error.hpp"
#include "rt/digest.hpp"
#include "rt/posix/file_place.hpp"

namespace sortie::firmware {

namespace {

constexpr char kBegin[] = "SORTIEKF";
constexpr char kEnd[] = "SORTIEND";
constexpr std::uint32_t kFormat = 1;
constexpr std::uint64_t kMark = 8;  // bytes of either word
constexpr std::uint64_t kPrefix = kMark + 4 + 4 + 8;
constexpr std::uint64_t kFrameHead = 4 * 8;
constexpr std::uint64_t kMostHeadBytes = 1u << 20;

void archive_text(rt::Archive& archive, std::string& text) {
  auto length = static_cast<std::uint32_t>(text.size());
  archive.bounded(length, kMostHeadBytes);
  text.resize(length);
  for (char& c : text) {
    auto byte = static_cast<std::uint8_t>(c);
    archive.value(byte);
    c = static_cast<char>(byte);
  }
}

template <class... T>
std::vector<std::uint8_t> to_bytes(T... values) {
  rt::Archive measure = rt::Archive::measuring();
  (measure.value(values), ...);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  (write.value(values), ...);
  return bytes;
}

template <class... T>
void from_bytes(const std::vector<std::uint8_t>& bytes, T&... values) {
  rt::Archive read = rt::Archive::reading(bytes);
  (read.value(values), ...);
}

std::vector<std::uint8_t> word(const char* text) { return {text, text + kMark}; }

// Reads whole pieces of a file, or refuses with the place.
class Pieces {
 public:
  explicit Pieces(const std::string& path) : path_(path), in_(path, std::ios::binary | std::ios::ate) {
    if (!in_) throw InputError(path + ": cannot be read; make it with `sortie index LOG`");
    size_ = static_cast<std::uint64_t>(in_.tellg());
  }
  std::uint64_t left() const { return size_ - at_; }
  std::uint64_t at() const { return at_; }
  void skip_to(std::uint64_t offset) { at_ = offset; }
  std::vector<std::uint8_t> take(std::uint64_t bytes) {
    if (bytes > left()) refuse("is cut off");
    std::vector<std::uint8_t> piece(static_cast<std::size_t>(bytes));
    in_.seekg(static_cast<std::streamoff>(at_));
    in_.read(reinterpret_cast<char*>(piece.data()), static_cast<std::streamsize>(bytes));
    if (!in_) refuse("cannot be read");
    at_ += bytes;
    return piece;
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(path_ + ": byte " + std::to_string(at_) + ": " + why +
                     "; make it again with `sortie index LOG`");
  }

 private:
  std::string path_;
  std::ifstream in_;
  std::uint64_t size_{};
  std::uint64_t at_{};
};

}  // namespace

void KeyframeHead::archive(rt::Archive& archive) {
  archive_text(archive, version);
  archive_text(archive, vehicle);
  archive.value(scene_hash);
  archive.value(log_bytes);
  archive.value(log_events);
  archive.value(log_header_digest);
  archive.value(base_tick_ns);
  archive_text(archive, groups);
  archive_text(archive, tasks);
}

KeyframeWriter::KeyframeWriter(const std::string& path, KeyframeHead head)
    : path_(rt::posix::place_of(path)),
      part_(rt::posix::is_special_file(path_) ? path_ : path_ + ".part"),
      out_(part_, std::ios::binary | std::ios::trunc) {
  if (!out_) throw InputError(path + ": cannot be made; give a path in a folder that can be written", 3);
  const auto bytes = to_bytes(std::move(head));
  write(word(kBegin));
  write(to_bytes(kFormat, static_cast<std::uint32_t>(bytes.size()),
                 rt::digest_bytes(bytes.data(), bytes.size())));
  write(bytes);
}

KeyframeWriter::~KeyframeWriter() {
  if (!out_.is_open()) return;
  out_.close();
  remove_part();
}

void KeyframeWriter::remove_part() {
  if (part_ != path_) static_cast<void>(std::remove(part_.c_str()));  // nothing more can be done about it
}

void KeyframeWriter::write(const std::vector<std::uint8_t>& bytes) {
  out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out_)
    throw InputError(part_ + ": cannot be written; free some space, or choose another place with -o", 3);
  bytes_ += bytes.size();
}

void KeyframeWriter::add(rt::Tick tick, const std::vector<std::uint8_t>& state) {
  const std::uint64_t size = state.size();
  const std::uint64_t digest = rt::digest_bytes(state.data(), state.size());
  const auto head = to_bytes(std::uint64_t{tick}, size, digest);
  write(head);
  write(to_bytes(rt::digest_bytes(head.data(), head.size())));
  entries_.push_back({tick, size, digest, bytes_});
  write(state);
}

void KeyframeWriter::finish() {
  write(word(kEnd));
  write(to_bytes(static_cast<std::uint64_t>(entries_.size())));
  out_.close();
  if (!out_ || (part_ != path_ && std::rename(part_.c_str(), path_.c_str()) != 0)) {
    remove_part();
    throw InputError(path_ + ": cannot be written; free some space, or choose another place with -o", 3);
  }
}

KeyframeFile::KeyframeFile(const std::string& path) : path_(path) {
  Pieces pieces(path);
  if (pieces.left() < kPrefix || pieces.take(kMark) != word(kBegin)) {
    pieces.skip_to(0);
    pieces.refuse("is no file of keyframes");
  }
  std::uint32_t format{};
  std::uint32_t head_bytes{};
  std::uint64_t head_digest{};
  from_bytes(pieces.take(kPrefix - kMark), format, head_bytes, head_digest);
  if (format != kFormat)
    pieces.refuse("keyframes of format " + std::to_string(format) + ", this program reads 1");
  const auto head = pieces.take(std::min<std::uint64_t>(head_bytes, kMostHeadBytes));
  if (rt::digest_bytes(head.data(), head.size()) != head_digest) pieces.refuse("the head is damaged");
  from_bytes(head, head_);
  while (pieces.left() != 2 * kMark) {
    const auto frame = pieces.take(kFrameHead);
    KeyframeEntry entry;
    std::uint64_t check{};
    from_bytes(frame, entry.tick, entry.bytes, entry.digest, check);
    if (rt::digest_bytes(frame.data(), 3 * 8) != check || entry.bytes > pieces.left() ||
        (!entries_.empty() && entry.tick <= entries_.back().tick)) {
      pieces.refuse("a keyframe is damaged or cut off");
    }
    entry.offset = pieces.at();
    entries_.push_back(entry);
    pieces.skip_to(entry.offset + entry.bytes);
  }
  std::uint64_t count{};
  const bool ends = pieces.take(kMark) == word(kEnd);
  from_bytes(pieces.take(8), count);
  if (!ends || count != entries_.size()) pieces.refuse("the end is damaged or cut off");
}

const KeyframeEntry* KeyframeFile::nearest(rt::Tick tick) const {
  const KeyframeEntry* found = nullptr;
  for (const KeyframeEntry& entry : entries_) {
    if (entry.tick <= tick) found = &entry;
  }
  return found;
}

std::vector<std::uint8_t> KeyframeFile::state(const KeyframeEntry& entry) const {
  Pieces pieces(path_);
  pieces.skip_to(entry.offset);
  auto bytes = pieces.take(entry.bytes);
  if (rt::digest_bytes(bytes.data(), bytes.size()) != entry.digest) {
    pieces.skip_to(entry.offset);
    pieces.refuse("the keyframe of tick " + std::to_string(entry.tick) + " is damaged");
  }
  return bytes;
}

}  // namespace sortie::firmware
