// SPDX-License-Identifier: BSD-3-Clause
// Codec of answers to requests; member order as in drivers/messages/request_answers_t.lcm.
#include "drivers/wire_answers.hpp"

#include "drivers/channels.hpp"
#include "drivers/wire_columns.hpp"
#include "drivers/wire_tag.hpp"

namespace sortie::drivers {

Status encode(const AnswersMessage& message, const SipKey* key, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintRequestAnswers);
  writer.put(message.utime);
  writer.put(message.session);
  writer.put_string(message.robot);
  writer.put_string(message.task);
  writer.put(static_cast<std::uint8_t>(message.keyed));
  writer.put(message.counter);
  writer.put_count(message.answers.size());
  put_column(writer, message.answers, &RequestAnswer::sender);
  put_column(writer, message.answers, &RequestAnswer::counter);
  put_column(writer, message.answers, &RequestAnswer::status);
  writer.put_count(message.state.size());
  put_column(writer, message.state, &NamedValue::name);
  put_column(writer, message.state, &NamedValue::value);
  put_tag(writer, key, out);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> bytes, const SipKey* key, AnswersMessage& message) {
  WireReader reader(bytes);
  if (const Status type = expect_fingerprint(reader, kFingerprintRequestAnswers); type != Status::ok)
    return type;
  AnswersMessage read;
  read.utime = reader.get<std::int64_t>();
  read.session = reader.get<std::int64_t>();
  read.robot = reader.get_string();
  read.task = reader.get_string();
  read.keyed = reader.get<std::uint8_t>() != 0;
  read.counter = reader.get<std::int64_t>();
  read.answers.resize(reader.get_count(2 * 8 + 4));
  get_column(reader, read.answers, &RequestAnswer::sender);
  get_column(reader, read.answers, &RequestAnswer::counter);
  get_column(reader, read.answers, &RequestAnswer::status);
  read.state.resize(reader.get_count(WireReader::kMinStringBytes + 8));
  get_column(reader, read.state, &NamedValue::name);
  get_column(reader, read.state, &NamedValue::value);
  const Status end = finish_with_tag(reader, key, bytes);
  if (end == Status::ok) message = std::move(read);
  return end;
}

}  // namespace sortie::drivers
