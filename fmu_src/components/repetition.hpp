// Sees to it that the same event many times in a row is told in a few lines.
#pragma once

#include <cstdint>

namespace truenorth {

class Repetition {
  public:
    static constexpr double kInterval = 60.0;  // [s]

    // An event of this kind; true if it is to be told: the first of a kind, then one a minute.
    bool tell(int kind, double clock) {
        const bool new_kind = kind != kind_;
        if (new_kind || clock - told_ >= kInterval) {
            omitted_ = new_kind ? 0 : counted_;
            counted_ = 0;
            kind_ = kind;
            told_ = clock;
            return true;
        }
        ++counted_;
        return false;
    }

    // How many of the kind were not told before the last one that was.
    [[nodiscard]] std::int64_t omitted() const { return omitted_; }

    // The next event is told, whatever its kind.
    void end() { kind_ = -1; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(kind_, told_, counted_, omitted_);
    }

  private:
    int kind_ = -1;
    double told_ = 0.0;  // [s]
    std::int64_t counted_ = 0;
    std::int64_t omitted_ = 0;
};

}  // namespace truenorth
