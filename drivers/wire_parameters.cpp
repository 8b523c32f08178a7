// SPDX-License-Identifier: BSD-3-Clause
// Codecs of the parameter messages; member order as in drivers/messages/*.lcm.
#include "drivers/wire_parameters.hpp"

#include "drivers/wire_columns.hpp"
#include "drivers/wire_tag.hpp"

namespace sortie::drivers {

Status encode(const rt::ParameterChange& change, std::int64_t seq, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  size = 0;
  if (rt::name_of(change).empty()) return Status::out_of_range;  // refused when it is read
  WireWriter writer(out);
  writer.put(kFingerprintParameter);
  writer.put(change.stamp_ns);
  writer.put(seq);
  writer.put_string(rt::name_of(change));
  writer.put(change.value);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, rt::ParameterChange& change,
              std::int64_t& seq) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintParameter); type != Status::ok) return type;
  const auto stamp_ns = reader.get<std::int64_t>();
  const auto number = reader.get<std::int64_t>();
  const std::string_view name = reader.get_string();
  const auto value = reader.get<double>();
  if (reader.finish() != Status::ok) return Status::malformed;
  if (rt::make_change(name, value, stamp_ns, change) != Status::ok) return Status::malformed;
  seq = number;
  return Status::ok;
}

Status encode(const SetParameter& request, const SipKey* key, std::span<std::uint8_t> out,
              std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintSetParameter);
  writer.put(request.utime);
  writer.put(request.session);
  writer.put(request.sender);
  writer.put(request.counter);
  writer.put_string(request.name);
  writer.put(request.value);
  put_tag(writer, key, out);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, const SipKey* key, SetParameter& request) noexcept {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintSetParameter); type != Status::ok)
    return type;
  SetParameter read;
  read.utime = reader.get<std::int64_t>();
  read.session = reader.get<std::int64_t>();
  read.sender = reader.get<std::int64_t>();
  read.counter = reader.get<std::int64_t>();
  read.name = reader.get_string();
  read.value = reader.get<double>();
  const Status end = finish_with_tag(reader, key, message);
  if (end == Status::ok) request = read;
  return end;
}

Status encode(const ParametersMessage& parameters, std::span<std::uint8_t> out, std::size_t& size) noexcept {
  WireWriter writer(out);
  writer.put(kFingerprintParameters);
  writer.put(parameters.utime);
  writer.put(parameters.session);
  writer.put(parameters.counter);
  writer.put_string(parameters.scene);
  writer.put(static_cast<std::uint8_t>(parameters.remote));
  writer.put(static_cast<std::uint8_t>(parameters.keyed));
  writer.put_count(parameters.parameters.size());
  put_column(writer, parameters.parameters, &ParameterInForce::name);
  put_column(writer, parameters.parameters, &ParameterInForce::unit);
  put_column(writer, parameters.parameters, &ParameterInForce::value);
  put_column(writer, parameters.parameters, &ParameterInForce::low);
  put_column(writer, parameters.parameters, &ParameterInForce::high);
  writer.put_count(parameters.answers.size());
  put_column(writer, parameters.answers, &ParameterAnswer::sender);
  put_column(writer, parameters.answers, &ParameterAnswer::counter);
  put_column(writer, parameters.answers, &ParameterAnswer::status);
  return writer.finish(size);
}

Status decode(std::span<const std::uint8_t> message, ParametersMessage& parameters) {
  WireReader reader(message);
  if (const Status type = expect_fingerprint(reader, kFingerprintParameters); type != Status::ok) return type;
  parameters.utime = reader.get<std::int64_t>();
  parameters.session = reader.get<std::int64_t>();
  parameters.counter = reader.get<std::int64_t>();
  parameters.scene = reader.get_string();
  parameters.remote = reader.get<std::uint8_t>() != 0;
  parameters.keyed = reader.get<std::uint8_t>() != 0;
  parameters.parameters.resize(reader.get_count(2u * WireReader::kMinStringBytes + 3u * 8u));
  get_column(reader, parameters.parameters, &ParameterInForce::name);
  get_column(reader, parameters.parameters, &ParameterInForce::unit);
  get_column(reader, parameters.parameters, &ParameterInForce::value);
  get_column(reader, parameters.parameters, &ParameterInForce::low);
  get_column(reader, parameters.parameters, &ParameterInForce::high);
  parameters.answers.resize(reader.get_count(2 * 8 + 4));
  get_column(reader, parameters.answers, &ParameterAnswer::sender);
  get_column(reader, parameters.answers, &ParameterAnswer::counter);
  get_column(reader, parameters.answers, &ParameterAnswer::status);
  return reader.finish();
}

}  // namespace sortie::drivers
