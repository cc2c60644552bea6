// Fixes that are younger than the IMU data: they wait for the sample that covers them, first in, first out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "contract/time_tolerance.hpp"

namespace truenorth {

// `Port` is the filter's GNSS input as it stood when the fix came.
template <class Port>
class WaitingFixes {
  public:
    static constexpr std::size_t kCapacity = 8;

    struct Entry {
        Port port{};
        double valid_at = 0.0;  // by the filter's clock [s]

        template <class Archive>
        void serialize(Archive& archive) {
            archive(port, valid_at);
        }
    };

    [[nodiscard]] bool full() const { return count_ == kCapacity; }
    [[nodiscard]] std::size_t count() const { return count_; }

    // There must be room.
    void push(const Port& port, double valid_at) {
        Entry& entry = entries_[(first_ + count_) % kCapacity];
        entry.port = port;
        entry.valid_at = valid_at;
        ++count_;
    }

    // The IMU data reach `now`.
    [[nodiscard]] bool due(double now) const {
        return count_ > 0 && entries_[first_].valid_at <= now + kTimeTolerance;
    }

    // The oldest, which stays readable until the next one is pushed.
    const Entry& pop() {
        const Entry& entry = entries_[first_];
        first_ = (first_ + 1) % kCapacity;
        --count_;
        return entry;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(first_, count_, entries_);
        if (first_ >= kCapacity || count_ > kCapacity) {
            throw std::out_of_range("the stored state is damaged: there is no such fix in its queue");
        }
    }

  private:
    std::array<Entry, kCapacity> entries_{};
    std::uint64_t first_ = 0;
    std::uint64_t count_ = 0;
};

}  // namespace truenorth
