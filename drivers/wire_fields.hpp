// SPDX-License-Identifier: BSD-3-Clause
// The codec of every message, from its struct's list of members (wire_rules.hpp). The bytes are what
// lcm-gen's code writes for the type that lcm_type.hpp derives; no length from the wire is trusted, and
// nothing is allocated before the bytes that it stands for are known to be there.
//
// Cost: linear in the message, a few ns a member; any thread. No heap but for texts and vectors that are
// read. Encoders: ok; `full` (`out` is too small); `out_of_range` (a value that may not be sent). `size` is 0
// unless ok. Decoders: ok; `bad_checksum` (a message of another type); `malformed` (wrong lengths, or a value
// that is not taken); `full` (a right message with more rows than a bounded list holds); `disconnected`
// (tagged ones: not the tag that `key` gives). What they would set is unchanged unless ok.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "drivers/lcm_type.hpp"
#include "drivers/siphash.hpp"
#include "drivers/wire_walk.hpp"

namespace sortie::drivers {

/// Of the tag of a command, which ends its message: SipHash over all before it.
inline constexpr std::size_t kTagBytes = 8;

/// Bytes of a message of T, fingerprint included, with all its texts and lists empty.
template <WireMessage T>
inline constexpr std::size_t kLeastBytes = 8 + detail::least<T>().bytes + (WireRules<T>::kNumbered ? 8 : 0) +
                                           (WireRules<T>::kTagged ? kTagBytes : 0);
/// It has no texts and lists: all messages have that length.
template <WireMessage T>
inline constexpr bool kFixedLength = detail::least<T>().fixed;

/// Bytes that encode() will need.
template <WireMessage T>
std::size_t encoded_bytes(const T& value) noexcept {
  detail::WireSize size;
  detail::walk(size, value);
  return kLeastBytes<T> - detail::least<T>().bytes + size.bytes;
}

namespace detail {
template <class T>
concept PlainMessage = WireMessage<T> && !WireRules<T>::kNumbered && !WireRules<T>::kTagged;
template <class T>
concept NumberedMessage = WireMessage<T> && WireRules<T>::kNumbered;
template <class T>
concept TaggedMessage = WireMessage<T> && WireRules<T>::kTagged;
template <class T>
concept ChecksTaken = requires(const T& value) {
  WireRules<T>::taken(value);
};

// The members, and `seq` behind the first one.
template <class Stream, class T, class Seq>
void walk_message(Stream& stream, T& value, Seq& seq) {
  bool first = true;
  visit_members(value, [&](const char*, auto&& member) {
    walk(stream, member);
    if (WireRules<std::remove_const_t<T>>::kNumbered && first) walk_number(stream, seq);
    first = false;
  });
}

template <class T>
Status encode_any(const T& value, std::int64_t seq, const SipKey* key, std::span<std::uint8_t> out,
                  std::size_t& size) noexcept {
  size = 0;
  if constexpr (requires { WireRules<T>::sent(value); }) {
    if (!WireRules<T>::sent(value)) return Status::out_of_range;
  }
  if (out.size() < kLeastBytes<T>) return Status::full;
  WireOut stream{WireWriter(out)};
  stream.writer.put(kFingerprintOf<T>);
  walk_message(stream, value, seq);
  if constexpr (WireRules<T>::kTagged) {
    const bool tagged = key != nullptr && stream.writer.status() == Status::ok;
    stream.writer.put(tagged ? siphash24(*key, out.first(stream.writer.size())) : std::uint64_t{0});
  }
  return stream.writer.finish(size);
}

// Reads the tag, which must end the message.
inline Status finish_with_tag(WireReader& reader, const SipKey* key,
                              std::span<const std::uint8_t> message) noexcept {
  const auto tag = reader.get<std::uint64_t>();
  if (reader.finish() != Status::ok) return Status::malformed;
  const bool fits = key == nullptr || tag == siphash24(*key, message.first(message.size() - kTagBytes));
  return fits ? Status::ok : Status::disconnected;
}

// Reads in place: `value` may be half filled unless ok.
template <class T>
Status read_any(std::span<const std::uint8_t> message, T& value, std::int64_t& seq,
                const SipKey* key = nullptr) {
  WireIn stream{WireReader(message)};
  if (const Status type = expect_fingerprint(stream.reader, kFingerprintOf<T>); type != Status::ok)
    return type;
  if (kFixedLength<T> && message.size() != kLeastBytes<T>) return Status::malformed;
  walk_message(stream, value, seq);
  const Status end =
      WireRules<T>::kTagged ? finish_with_tag(stream.reader, key, message) : stream.reader.finish();
  if (end != Status::ok) return end;
  if constexpr (ChecksTaken<T>) {
    if (!WireRules<T>::taken(value)) return Status::malformed;
  }
  return stream.full ? Status::full : Status::ok;
}

template <class T>
Status decode_any(std::span<const std::uint8_t> message, T& value, std::int64_t& seq,
                  const SipKey* key = nullptr) {
  if constexpr (kFixedLength<T> && !WireRules<T>::kTagged && !ChecksTaken<T>) {
    return read_any(message, value, seq, key);  // which cannot fail half-way
  } else {
    T read{};
    std::int64_t number = 0;
    const Status status = read_any(message, read, number, key);
    if (status != Status::ok) return status;
    value = std::move(read);
    seq = number;
    return Status::ok;
  }
}
}  // namespace detail

/// Writes the message of any struct that lists its fields: its LCM type is that of lcm_text<T>(name), and
/// nothing else has to be said.
template <detail::PlainMessage T>
[[nodiscard]] Status encode(const T& value, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  return detail::encode_any(value, 0, nullptr, out, size);
}
/// The same with its number in its stream.
template <detail::NumberedMessage T>
[[nodiscard]] Status encode(const T& value, std::int64_t seq, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept {
  return detail::encode_any(value, seq, nullptr, out, size);
}
/// The same with its tag; `key` null: tag 0.
template <detail::TaggedMessage T>
[[nodiscard]] Status encode(const T& value, const SipKey* key, std::span<std::uint8_t> out,
                            std::size_t& size) noexcept {
  return detail::encode_any(value, 0, key, out, size);
}

/// Reads a message.
template <detail::PlainMessage T>
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, T& value) {
  std::int64_t none = 0;
  return detail::decode_any(message, value, none);
}
/// The same with its number.
template <detail::NumberedMessage T>
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, T& value, std::int64_t& seq) {
  return detail::decode_any(message, value, seq);
}
/// The same with its tag; `key` null: any will do.
template <detail::TaggedMessage T>
[[nodiscard]] Status decode(std::span<const std::uint8_t> message, const SipKey* key, T& value) {
  std::int64_t none = 0;
  return detail::decode_any(message, value, none, key);
}

}  // namespace sortie::drivers
