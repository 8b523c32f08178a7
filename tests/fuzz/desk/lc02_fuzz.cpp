// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer entry point: any datagram and any address. What is taken must lie inside the datagram; then it
// goes through the spy's table as if it had come from the network.
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "drivers/lcm_receiver.hpp"
#include "drivers/lcm_url.hpp"
#include "toolchain/commands/spy_table.hpp"

using namespace sortie;
using namespace sortie::drivers;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Lc02Message message;
  if (parse_lc02({data, size}, message) == Status::ok) {
    require(message.channel.size() >= 1 && message.channel.size() <= 63);
    require(message.channel.find('\0') == std::string_view::npos);
    require(8 + message.channel.size() + 1 + message.payload.size() == size);
    require(message.payload.empty() || message.payload.data() + message.payload.size() == data + size);
    toolchain::SpyTable table(true);
    table.add(message.channel, message.payload, 1);
    table.add(message.channel, message.payload, 2'000'000);
    std::ostringstream text;
    table.print(text, 3'000'000);
    require(table.channels().size() == 1);
    for (const char character : text.str())
      require(character == '\n' || (character >= ' ' && character <= '~'));
  }
  try {
    const MulticastAddress address = parse_udpm_url({reinterpret_cast<const char*>(data), size});
    require((address.group >> 28) == 0xE && address.port != 0);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
