// Tells that a measurement at a port is new: by its count, or, where nobody counts, by its time stamp.
#pragma once

#include <cstdint>

namespace truenorth {

class Arrival {
  public:
    // A number that is another one for every new measurement. `blank`: all values are zero, as those of a
    // port that nothing is connected to; before any other came, a stamp alone is no measurement.
    int number(int sample, double time, bool blank) {
        fed_ = fed_ || !blank;
        counted_ = counted_ || sample != 0;
        if (!counted_ && fed_ && time != stamp_) {
            stamp_ = time;
            ++stamped_;
        }
        return static_cast<int>(static_cast<std::uint32_t>(sample) + stamped_);
    }

    [[nodiscard]] bool fed() const { return fed_; }          // values have come
    [[nodiscard]] bool counted() const { return counted_; }  // and so has a count
    [[nodiscard]] bool stamped() const { return stamped_ > 0; }

    // Whether that is to be told, which it is once.
    bool tell() {
        const bool first = !told_;
        told_ = true;
        return first;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(fed_, counted_, told_, stamp_, stamped_);
    }

  private:
    bool fed_ = false;
    bool counted_ = false;
    bool told_ = false;
    double stamp_ = 0.0;         // of the last measurement that nobody counted [s]
    std::uint32_t stamped_ = 0;  // so many of them came
};

}  // namespace truenorth
