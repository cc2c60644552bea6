// Fixes under way from their time of validity to the receiver's output, first in, first out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "plant/fix.hpp"

namespace truenorth::plant {

class FixQueue {
  public:
    static constexpr std::size_t kCapacity = 32;

    // `due`: number of the IMU sample at whose end the fix appears. At most kCapacity fixes may wait.
    void push(const Fix& fix, std::uint64_t due) {
        waiting_[(first_ + count_) % kCapacity] = {.fix = fix, .due = due};
        ++count_;
    }

    [[nodiscard]] bool due(std::uint64_t sample) const {
        return count_ > 0 && waiting_[first_].due <= sample;
    }

    Fix pop() {
        const Fix fix = waiting_[first_].fix;
        first_ = (first_ + 1) % kCapacity;
        --count_;
        return fix;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(waiting_, first_, count_);
        if (first_ >= kCapacity || count_ > kCapacity) {
            throw std::out_of_range("the stored state is damaged: there is no such fix in its queue");
        }
    }

  private:
    struct Entry {
        Fix fix;
        std::uint64_t due = 0;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(fix, due);
        }
    };

    std::array<Entry, kCapacity> waiting_{};
    std::uint64_t first_ = 0;
    std::uint64_t count_ = 0;
};

}  // namespace truenorth::plant
