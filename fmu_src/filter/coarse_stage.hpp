// The coarse stage of an alignment: intervals and fixes are kept until vectors in inertial space tell the
// attitude well enough to linearise at it; then the filter takes them all again, from the first.
//
// Memory is bounded: fixes closer than kSpacing are passed over, and what fills the memory ends the stage.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "contract/time_tolerance.hpp"
#include "estimation/relinearised.hpp"
#include "filter/uncertainty.hpp"
#include "inertial/vector_alignment.hpp"

namespace truenorth {

template <ErrorModel M>
class CoarseStage {
  public:
    using Solution = VectorAlignment::Solution;

    static constexpr std::size_t kCapacity = 1024;  // fixes
    static constexpr double kSpacing = 0.1;         // [s]
    static constexpr int kFewest = 10;              // fixes, for a scatter that can be believed

    // Allocates what it will ever need.
    void reserve() { epochs_.reserve(kCapacity); }

    // Begins at the next fix.
    void begin() {
        active_ = true;
        interval_ = {};
        doubted_ = {};
        alignment_ = {};
        epochs_.clear();
    }
    void end() {
        active_ = false;
        epochs_.clear();
    }
    [[nodiscard]] bool active() const { return active_; }

    void extend(const Preintegration& interval) { interval_ = interval_ * interval; }

    // The navigation state has become uncertain by so much more than the sensors explain.
    void doubt(const Uncertainty& more) {
        doubted_.attitude += more.attitude;
        doubted_.velocity += more.velocity;
    }
    [[nodiscard]] const Uncertainty& doubted() const { return doubted_; }

    [[nodiscard]] bool awaits_fix() const {
        return epochs_.empty() || interval_.duration > kSpacing - kTimeTolerance;
    }

    // A fix at the end of the intervals so far.
    void add(const typename M::Fix& fix) {
        alignment_.add(
            interval_,
            {.position = fix.position, .velocity = fix.velocity, .velocity_arm = fix.velocity_arm});
        epochs_.push_back({.interval = interval_, .fix = fix});
        interval_ = {};
    }

    [[nodiscard]] std::optional<Solution> solve() const { return alignment_.solve(); }

    [[nodiscard]] Eigen::Quaterniond at_first_fix(const Eigen::Quaterniond& attitude,
                                                  const Vector<6>& bias) const {
        return alignment_.at_first_fix(attitude, bias);
    }

    // The solution is good enough, or as good as it will get.
    [[nodiscard]] bool done(double heading_sigma, double sufficient) const {
        return (alignment_.fixes() >= kFewest && heading_sigma < sufficient) || epochs_.size() == kCapacity;
    }

    [[nodiscard]] const typename M::Fix& first_fix() const { return epochs_.front().fix; }
    [[nodiscard]] std::span<const Epoch<M>> after_first_fix() const { return std::span(epochs_).subspan(1); }

    template <class Archive>
    void serialize(Archive& archive) {
        std::uint64_t count = epochs_.size();
        archive(active_, interval_, doubted_.attitude, doubted_.velocity, alignment_, count);
        if constexpr (Archive::is_loading::value) {
            if (count > (active_ ? kCapacity : 0)) {
                throw std::out_of_range("the stored state is damaged: it has " + std::to_string(count) +
                                        " fixes of a coarse stage");
            }
            reserve();
            epochs_.resize(count);
        }
        for (Epoch<M>& epoch : epochs_) {
            archive(epoch);
        }
    }

  private:
    bool active_ = false;
    Preintegration interval_;  // since the last fix that was kept
    Uncertainty doubted_;
    VectorAlignment alignment_;
    std::vector<Epoch<M>> epochs_;
};

}  // namespace truenorth
