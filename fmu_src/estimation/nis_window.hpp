// Whether the innovations of late agree with their covariance. The sum of the NIS over a window of time is
// chi-square with as many degrees of freedom as there were channels, if the filter is what it believes to be.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "estimation/chi_square.hpp"

namespace truenorth {

class NisWindow {
  public:
    // Setting, not part of a saved state: how far back it reaches, to a part of kParts [s].
    double length = 60.0;

    void restart() {
        parts_ = {};
        any_ = false;
        known_ = {};
    }

    // A measurement of `channels` channels at `time` [s], not before the last one.
    void add(double time, double nis, int channels) {
        const std::int64_t number = number_of(time);
        Part& part = parts_[static_cast<std::size_t>((number % kParts + kParts) % kParts)];
        if (part.number != number) {
            part = {.number = number};
        }
        any_ = true;
        known_ = {};
        part.nis += nis;
        part.channels += channels;
    }

    // NIS per channel over the window that ends now; 1 is expected, 0 if there was nothing.
    [[nodiscard]] double mean(double now) const { return about(now).mean; }

    // As how rare, in standard deviations of a normal variable, a consistent filter would see so large
    // innovations; 0 if there was nothing.
    [[nodiscard]] double deviate(double now) const { return about(now).deviate; }

    template <class Archive>
    void serialize(Archive& archive) {
        for (Part& part : parts_) {
            archive(part.number, part.nis, part.channels);
        }
        archive(any_);
        known_ = {};
    }

  private:
    // The memory is the same whatever the rate of the measurements: the oldest part goes as a whole.
    static constexpr std::int64_t kParts = 12;

    struct Part {
        std::int64_t number = 0;  // counted from time 0
        double nis = 0.0;
        double channels = 0.0;  // a whole number; that of a damaged state overflows no sum
    };

    [[nodiscard]] std::int64_t number_of(double time) const {
        constexpr double most = 0x1p62;  // of any clock; a number beyond has no integer
        return static_cast<std::int64_t>(std::clamp(std::floor(time * kParts / length), -most, most));
    }

    // What follows from the parts in the window, which is asked for at every step and seldom changes.
    struct Known {
        std::int64_t number = 0;
        double length = 0.0;  // 0: nothing is known
        double mean = 0.0;
        double deviate = 0.0;
    };

    [[nodiscard]] const Known& about(double now) const {
        if (!any_) {  // as of every aid that a vehicle does not have
            return known_;
        }
        const std::int64_t current = number_of(now);
        if (known_.number == current && known_.length == length) {
            return known_;
        }
        Part sum;
        for (const Part& part : parts_) {
            if (part.number > current - kParts) {
                sum.nis += part.nis;
                sum.channels += part.channels;
            }
        }
        known_ = {.number = current, .length = length};
        if (sum.channels > 0) {
            known_.mean = sum.nis / sum.channels;
            known_.deviate = normal_deviate(sum.nis, sum.channels);
        }
        return known_;
    }

    std::array<Part, kParts> parts_{};
    bool any_ = false;
    mutable Known known_;  // no part of a saved state
};

}  // namespace truenorth
