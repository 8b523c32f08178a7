// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/sdo_client.hpp"

namespace sortie::drivers::canopen {

void SdoClient::begin(const Sdo& request) noexcept {
  request_ = request;
  result_ = {SdoProgress::waiting, 0};
  attempts_ = 0;
  offered_ = true;
}

bool SdoClient::poll(rt::Nanoseconds now_ns, CanFrame& frame) noexcept {
  if (result_.progress != SdoProgress::waiting) return false;
  if (!offered_) {
    if (now_ns - sent_ns_ < kTimeoutNs) return false;
    if (attempts_ >= kAttempts) {
      result_ = {SdoProgress::timed_out, kAbortTimeout};
      return false;
    }
    offered_ = true;
  }
  frame = encode_sdo_request(node_, request_);
  return true;
}

void SdoClient::sent(rt::Nanoseconds now_ns) noexcept {
  offered_ = false;
  sent_ns_ = now_ns;
  ++attempts_;
}

bool SdoClient::take(const Sdo& reply) noexcept {
  if (result_.progress != SdoProgress::waiting || attempts_ == 0 || !(reply.key == request_.key))
    return false;
  if (reply.kind == SdoKind::abort) {
    result_ = {SdoProgress::aborted, reply.value};
    return true;
  }
  const SdoKind expected = request_.kind == SdoKind::read ? SdoKind::value : SdoKind::written;
  if (reply.kind != expected) return false;
  result_ = {SdoProgress::done, reply.value};
  return true;
}

}  // namespace sortie::drivers::canopen
