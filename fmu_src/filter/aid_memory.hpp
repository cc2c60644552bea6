// What a filter remembers of an aid: what it has read, and how its innovations have been of late.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "contract/repetition.hpp"
#include "estimation/innovation_gate.hpp"
#include "estimation/innovation_mean.hpp"
#include "estimation/nis_window.hpp"
#include "filter/arrival.hpp"
#include "filter/filter_events.hpp"
#include "filter/stamp_clock.hpp"

namespace truenorth {

struct AidMemory {
    static constexpr int kMostChannels = 3;

    int sample = 0;      // that was read last
    int used = 0;        // measurements that corrected the estimate
    int rejected = 0;    // that did not
    double last = 0.0;   // when one did, or the start, by the master's clock [s]
    double heard = 0.0;  // when one came [s]
    Arrival arrival;
    StampClock clock;
    NisWindow window;
    InnovationMean<kMostChannels> mean;
    Repetition<kRefusals> told;

    void start(double now) {
        window.restart();
        mean.restart();
        refused_ = 0;
        contradictions_ = 0;
        last = now;
        heard = now;
    }

    // Whether a measurement may be used, which its covariance explains or not; it may if the gate stands
    // open.
    bool admits(const InnovationGate& gate, double nis, int channels, bool open) {
        const bool explained = gate.explains(nis, channels);
        contradictions_ = explained ? 0 : std::min(contradictions_ + 1, kMost);
        const bool admitted = explained || open || !gate.enabled;
        refused_ = admitted ? 0 : std::min(refused_ + 1, kMost);
        return admitted;
    }

    // One has come. What was before a silence says nothing of what is now.
    void hear(double now) {
        if (!heard_of_late(now)) {
            mean.restart();
        }
        heard = now;
    }

    // What is not heard any more contradicts nothing.
    [[nodiscard]] bool heard_of_late(double now) const { return now - heard <= window.length; }

    // So many in a row were beyond what the covariance explains; and so many were refused.
    [[nodiscard]] int contradictions() const { return contradictions_; }
    [[nodiscard]] bool out_of_patience(int patience) const { return patience > 0 && refused_ >= patience; }

    // Patience begins anew.
    void lose_count() { refused_ = 0; }

    // The prediction has been blamed.
    void forgive() {
        lose_count();
        contradictions_ = 0;
        window.restart();
        mean.restart();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(sample, used, rejected, last, heard, arrival, clock, window, mean, told, refused_,
                contradictions_);
    }

  private:
    static constexpr int kMost = 1'000'000;

    int refused_ = 0;
    int contradictions_ = 0;
};

// What is remembered of each of these aids.
template <class... Aids>
class AidMemories {
  public:
    // Calls use(std::type_identity<Aid>, its memory), one after the other.
    template <class Use>
    void each(Use use) {
        std::size_t i = 0;
        (use(std::type_identity<Aids>{}, memories_[i++]), ...);
    }
    template <class Use>
    void each(Use use) const {
        std::size_t i = 0;
        (use(std::type_identity<Aids>{}, memories_[i++]), ...);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        for (AidMemory& memory : memories_) {
            archive(memory);
        }
    }

  private:
    std::array<AidMemory, sizeof...(Aids)> memories_{};
};

}  // namespace truenorth
