// SPDX-License-Identifier: BSD-3-Clause
// A stream of big samples: a header each, and elements that are written once into a pooled buffer.
#pragma once

#include <cstdint>

#include "rt/ports.hpp"

namespace sortie::rt {

/// Stream of (Header, Element[]) pairs: one producer thread, one consuming group. The ring carries slot
/// numbers. A buffer lives until the consumer's next job has been released: that is known from the table, so
/// nothing is counted and nothing depends on timing. No heap; all memory is given at start-up.
template <class Header, class Element>
class PooledStream final : public StreamBase {
 public:
  /// One sample as the consumer sees it.
  struct View {
    Header header;
    const Element* elements;
  };
  /// What crosses the ring.
  struct Ticket {
    Header header;
    std::uint32_t slot;
  };

  /// `elements`: slots * slot_size of them. `tickets`, `free_slots`: `ring` entries each, a power of two >=
  /// slots. `batch`: batch_size entries.
  PooledStream(const char* name, std::uint16_t id, Element* elements, std::uint32_t slots,
               std::uint32_t slot_size, Ticket* tickets, std::uint32_t* free_slots, std::uint32_t ring,
               Ticket* batch, std::uint32_t batch_size)
      : StreamBase(name, id, batch_size),
        elements_(elements),
        slots_(slots),
        slot_size_(slot_size),
        ring_(tickets, ring),
        free_(free_slots, ring),
        batch_(batch) {
    for (std::uint32_t slot = 0; slot < slots; ++slot)
      static_cast<void>(free_.try_push(slot));  // fits by construction
  }

  std::uint32_t slot_size() const { return slot_size_; }
  std::uint32_t slots() const { return slots_; }

  /// Producer: room for `count` elements, or null (no slot, or more than one holds; counted). One at a time.
  Element* reserve(std::uint32_t count) {
    if (reserved_ || count > slot_size_ || (!spare_ && !free_.try_pop(slot_))) {
      refused_.add();
      return nullptr;
    }
    spare_ = false;
    reserved_ = true;
    return elements_ + static_cast<std::size_t>(slot_) * slot_size_;
  }

  /// Producer: admits the reserved sample. Status: ok, malformed (nothing reserved).
  Status commit(const Header& header) {
    if (!reserved_) return Status::malformed;
    reserved_ = false;
    return ring_.try_push(Ticket{header, slot_}) ? Status::ok : Status::full;
  }

  /// Producer: the reservation is kept for the next reserve(). Only the producer may touch the slot, so it is
  /// not put back through the ring that the consumer fills.
  void cancel() {
    if (!reserved_) return;
    reserved_ = false;
    spare_ = true;
  }

  /// Samples of the current job, oldest first.
  std::uint32_t size() const { return taken_; }
  View operator[](std::uint32_t index) const {
    const Ticket& ticket = batch_[index];
    return {ticket.header, elements_ + static_cast<std::size_t>(ticket.slot) * slot_size_};
  }

  std::uint32_t waiting() const override { return ring_.size(); }
  std::uint32_t capacity() const override { return slots_; }

  /// Samples that wait, with their elements; of the last job's batch only how many buffers it keeps.
  void archive(Archive& archive) override {
    StreamBase::archive(archive);
    if (archive.is_reading()) release_all();
    std::uint32_t kept = taken_;
    archive.bounded(kept, batch());
    for (std::uint32_t i = 0; archive.is_reading() && i < kept && free_.try_pop(batch_[i].slot); ++i)
      taken_ = i + 1;
    std::uint32_t count = ring_.size();
    archive.bounded(count, slots_ - taken_);
    for (std::uint32_t i = 0; i < count; ++i) {
      Ticket ticket{};
      static_cast<void>(archive.is_reading() ? free_.try_pop(ticket.slot) : ring_.try_pop(ticket));
      archive.value(ticket.header);
      Element* elements = elements_ + static_cast<std::size_t>(ticket.slot) * slot_size_;
      for (std::uint32_t k = 0; k < used(ticket.header); ++k) archive.value(elements[k]);
      static_cast<void>(ring_.try_push(ticket));
    }
  }

 private:
  // Elements that a sample consists of, if its header says so.
  std::uint32_t used(const Header& header) const {
    if constexpr (requires { header.points; }) return header.points < slot_size_ ? header.points : slot_size_;
    return slot_size_;
  }
  void release_all() {
    cancel();
    static_cast<void>(take(0));
    for (Ticket ticket; ring_.try_pop(ticket);) static_cast<void>(free_.try_push(ticket.slot));
    if (spare_) static_cast<void>(free_.try_push(slot_));
    spare_ = false;
  }
  std::uint32_t take(std::uint32_t count) override {
    for (std::uint32_t i = 0; i < taken_; ++i)
      static_cast<void>(free_.try_push(batch_[i].slot));  // as many as slots
    return taken_ = ring_.pop_n(batch_, count);
  }

  Element* elements_;
  std::uint32_t slots_;
  std::uint32_t slot_size_;
  SpscSpanRing<Ticket> ring_;
  SpscSpanRing<std::uint32_t> free_;
  Ticket* batch_;
  std::uint32_t taken_{};
  std::uint32_t slot_{};
  bool reserved_{};
  bool spare_{};
};

}  // namespace sortie::rt
