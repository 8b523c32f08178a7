// SPDX-License-Identifier: BSD-3-Clause
// Requests to the kernel's table of interfaces (rtnetlink, RTM_NEWLINK).
#include "drivers/can_link.hpp"

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace sortie::drivers {

namespace {

/// One request and its answer. Everything is written into a fixed buffer that no request here fills.
class LinkRequest {
 public:
  LinkRequest(const std::string& name, std::uint16_t more_flags) : name_(name) {
    header().nlmsg_len = NLMSG_LENGTH(sizeof(ifinfomsg));
    header().nlmsg_type = RTM_NEWLINK;
    header().nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | NLM_F_ACK | more_flags);
    if (more_flags == 0) info().ifi_index = static_cast<int>(::if_nametoindex(name.c_str()));
  }
  void set_up(bool up) {
    info().ifi_change = IFF_UP;
    info().ifi_flags = up ? unsigned{IFF_UP} : 0U;
  }
  void put(std::uint16_t type, const void* data, std::size_t bytes) {
    rtattr* const attribute = begin(type);
    if (bytes != 0) std::memcpy(RTA_DATA(attribute), data, bytes);
    header().nlmsg_len += static_cast<std::uint32_t>(RTA_ALIGN(bytes));
    attribute->rta_len = static_cast<std::uint16_t>(RTA_LENGTH(bytes));
  }
  rtattr* begin(std::uint16_t type) {
    auto* const attribute = reinterpret_cast<rtattr*>(buffer_ + NLMSG_ALIGN(header().nlmsg_len));
    attribute->rta_type = type;
    header().nlmsg_len = static_cast<std::uint32_t>(NLMSG_ALIGN(header().nlmsg_len) + RTA_LENGTH(0));
    return attribute;
  }
  void end(rtattr* attribute) {
    attribute->rta_len =
        static_cast<std::uint16_t>(buffer_ + header().nlmsg_len - reinterpret_cast<char*>(attribute));
  }
  bool ask(std::string& problem) {
    if (header().nlmsg_flags == (NLM_F_REQUEST | NLM_F_ACK) && info().ifi_index == 0) {
      problem = name_ + ": there is no such interface";
      return false;
    }
    const int descriptor = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    alignas(NLMSG_ALIGNTO) char answer[1024];
    bool good =
        descriptor >= 0 && ::send(descriptor, buffer_, header().nlmsg_len, 0) >= 0 &&
        ::recv(descriptor, answer, sizeof answer, 0) >= static_cast<ssize_t>(NLMSG_LENGTH(sizeof(nlmsgerr)));
    int error = errno;
    if (good) {
      error = -static_cast<const nlmsgerr*>(NLMSG_DATA(reinterpret_cast<const nlmsghdr*>(answer)))->error;
      good = error == 0;
    }
    if (descriptor >= 0) ::close(descriptor);
    if (!good) problem = name_ + ": " + std::generic_category().message(error);
    return good;
  }

 private:
  nlmsghdr& header() { return *reinterpret_cast<nlmsghdr*>(buffer_); }
  ifinfomsg& info() { return *static_cast<ifinfomsg*>(NLMSG_DATA(&header())); }

  std::string name_;
  alignas(NLMSG_ALIGNTO) char buffer_[512]{};
};

}  // namespace

bool make_virtual_can(const std::string& name, std::string& problem) {
  LinkRequest request(name, NLM_F_CREATE | NLM_F_EXCL);
  request.put(IFLA_IFNAME, name.c_str(), name.size() + 1);
  rtattr* const kind = request.begin(IFLA_LINKINFO);
  request.put(IFLA_INFO_KIND, "vcan", 4);
  request.end(kind);
  request.set_up(true);
  return request.ask(problem);
}

bool set_can_bitrate(const std::string& name, std::uint32_t bits_per_s, std::string& problem) {
  LinkRequest request(name, 0);
  if (bits_per_s != 0) {
    can_bittiming timing{};
    timing.bitrate = bits_per_s;
    rtattr* const kind = request.begin(IFLA_LINKINFO);
    request.put(IFLA_INFO_KIND, "can", 3);
    rtattr* const data = request.begin(IFLA_INFO_DATA);
    request.put(IFLA_CAN_BITTIMING, &timing, sizeof timing);
    request.end(data);
    request.end(kind);
  }
  request.set_up(bits_per_s != 0);
  return request.ask(problem);
}

bool switch_on(const std::string& name, std::string& problem) {
  LinkRequest request(name, 0);
  request.set_up(true);
  return request.ask(problem);
}

bool move_can_to(const std::string& name, int process, std::string& problem) {
  LinkRequest request(name, 0);
  const auto number = static_cast<std::uint32_t>(process);
  request.put(IFLA_NET_NS_PID, &number, sizeof number);
  return request.ask(problem);
}

}  // namespace sortie::drivers
