// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/gpio_line.hpp"

#if defined(__linux__) && __has_include(<linux/gpio.h>)
#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#endif

namespace sortie::drivers {

#if defined(__linux__) && defined(GPIO_V2_GET_LINE_IOCTL)

Status GpioLine::open(const GpioLineConfig& config, std::string& problem) {
  close();
  const int chip = ::open(config.chip.c_str(), O_RDWR | O_CLOEXEC);
  if (chip < 0) {
    problem = config.chip + ": " + std::generic_category().message(errno) +
              "; see 'gpiodetect', and let this user read and write the chip";
    return Status::disconnected;
  }
  gpio_v2_line_request request{};
  request.offsets[0] = config.line;
  request.num_lines = 1;
  request.config.flags = GPIO_V2_LINE_FLAG_INPUT;
  if (config.active_low) request.config.flags |= GPIO_V2_LINE_FLAG_ACTIVE_LOW;
  std::strncpy(request.consumer, "sortie", sizeof request.consumer - 1);
  const bool good = ::ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &request) == 0 && request.fd >= 0;
  const int error = errno;
  ::close(chip);
  if (!good) {
    problem = config.chip + ": line " + std::to_string(config.line) + ": " +
              std::generic_category().message(error) + "; see 'gpioinfo': it must exist and be free";
    return Status::disconnected;
  }
  descriptor_ = request.fd;
  return Status::ok;
}

void GpioLine::close() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

Status GpioLine::read(bool& active) const noexcept {
  gpio_v2_line_values values{};
  values.mask = 1;
  if (descriptor_ < 0 || ::ioctl(descriptor_, GPIO_V2_LINE_GET_VALUES_IOCTL, &values) != 0)
    return Status::disconnected;
  active = (values.bits & 1u) != 0;
  return Status::ok;
}

#else

Status GpioLine::open(const GpioLineConfig&, std::string& problem) {
  problem = "GPIO: only Linux has lines like these; use a button on the CAN bus";
  return Status::not_supported;
}
void GpioLine::close() noexcept { descriptor_ = -1; }
Status GpioLine::read(bool&) const noexcept { return Status::disconnected; }

#endif

}  // namespace sortie::drivers
