// Tells that a measurement at a port is new: by its count or, where nobody counts, by its time stamp.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace truenorth {

class Arrival {
  public:
    // Another number for every new measurement. The first stamp of all is that from which others are told: of
    // what lies at a port at the start nobody knows whether it is a measurement.
    int number(int sample, double stamp) {
        counted_ = counted_ || sample != 0;
        if (!counted_ && std::isfinite(stamp) && stamp != stamp_) {
            stamped_ += std::isnan(stamp_) ? 0 : 1;
            stamp_ = stamp;
        }
        return static_cast<int>(static_cast<std::uint32_t>(sample) + stamped_);
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
        archive(counted_, told_, stamp_, stamped_);
    }

  private:
    bool counted_ = false;
    bool told_ = false;
    double stamp_ = std::numeric_limits<double>::quiet_NaN();  // seen last, while nobody counted [s]
    std::uint32_t stamped_ = 0;                                // so many new ones came
};

}  // namespace truenorth
