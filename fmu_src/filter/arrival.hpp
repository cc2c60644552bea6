// Tells that a measurement at a port is new: by its count or, where nobody counts, by its time stamp.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace truenorth {

class Arrival {
  public:
    // Another number for every new sample of an IMU. The first stamp of all is that from which others are
    // told: of what lies at a port at the start nobody knows whether it is a measurement.
    int number(int sample, double stamp) {
        counted_ = counted_ || sample != 0;
        if (!counted_ && std::isfinite(stamp) && stamp != stamp_) {
            stamped_ += std::isnan(stamp_) ? 0 : 1;
            stamp_ = stamp;
        }
        return total(sample);
    }

    // Where somebody counts.
    int number(int sample) {
        counted_ = counted_ || sample != 0;
        return total(sample);
    }

    // Likewise of a fix or of an aid, which measures now and then. Its stamp counts only with an IMU that is
    // `uncounted` too, for a count that stays 0 beside one that goes on says that there was none; and only
    // with `values` that have changed, for what is held has not been measured again, whatever its stamp.
    template <class Values>
    int number(int sample, double stamp, const Values& values, bool uncounted) {
        if (!uncounted) {
            return number(sample);
        }
        const std::uint64_t print = fingerprint(values);
        if (print == print_) {
            return total(sample);
        }
        print_ = print;
        return number(sample, stamp);
    }

    [[nodiscard]] bool any() const { return counted_ || stamped_ > 0; }  // something came
    [[nodiscard]] bool by_stamps() const { return !counted_ && stamped_ > 0; }

    // Whether that is to be told, which it is once.
    bool tell() {
        const bool first = !told_;
        told_ = true;
        return first;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(counted_, told_, stamp_, stamped_, print_);
    }

  private:
    [[nodiscard]] int total(int sample) const {
        return static_cast<int>(static_cast<std::uint32_t>(sample) + stamped_);
    }

    // FNV-1a of the bits.
    template <class Values>
    static std::uint64_t fingerprint(const Values& values) {
        std::uint64_t hash = 0xcbf29ce484222325U;
        for (const double value : values) {
            hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3U;
        }
        return hash;
    }

    bool counted_ = false;
    bool told_ = false;
    double stamp_ = std::numeric_limits<double>::quiet_NaN();  // seen last, while nobody counted [s]
    std::uint32_t stamped_ = 0;                                // so many new ones came
    std::uint64_t print_ = 0;                                  // of the values seen last
};

}  // namespace truenorth
