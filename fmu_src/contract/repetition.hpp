// Sees to it that what happens many times is told in a few lines: the first of its kind, then one a minute.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace truenorth {

template <std::size_t Kinds>
class Repetition {
  public:
    static constexpr double kInterval = 60.0;  // [s]

    // An event of a kind, below Kinds. If it is to be told: how many of its kind were not since the last that
    // was.
    template <class Kind>
    std::optional<std::int64_t> tell(Kind kind, double clock) {
        Told& told = told_[static_cast<std::size_t>(kind)];
        if (clock - told.last < kInterval) {
            ++told.omitted;
            return std::nullopt;
        }
        const std::int64_t omitted = told.omitted;
        told = {.last = clock, .omitted = 0};
        return omitted;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(told_);
    }

  private:
    struct Told {
        double last = std::numeric_limits<double>::lowest();  // [s]
        std::int64_t omitted = 0;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(last, omitted);
        }
    };

    std::array<Told, Kinds> told_{};
};

}  // namespace truenorth
