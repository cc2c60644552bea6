// Whether the vehicle stands, as its inertial sensors show: window after window its rates and forces vary by
// no more than those of a vehicle that stands, about means that do not drift.
//
// With n samples in a window of T seconds, noise of density q and what else shakes a standing vehicle, s, a
// sample has the variance
//
//     V = q^2 n / T + s^2.
//
// The variance within a window may be kMargin^2 V, and its mean may differ from that of the window before by
// kSteady sqrt(2 V / n). An angle that sways by A at the angular frequency w turns its rate by A w^2 T and
// the gravity in it by g A w T, the one where the other rests: whoever sways is seen, however slowly, down to
// the noise. Whoever goes on at a constant velocity is not; that is for the estimate to say.
#pragma once

#include "contract/count_up.hpp"
#include "filter/imu_activity.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth {

class Standstill {
  public:
    using Rates = ImuActivity::Rates;

    static constexpr int kFewest = 10;      // samples of a window that says anything
    static constexpr double kMargin = 1.5;  // of the deviation: five sigmas of that of 50 samples
    static constexpr double kSteady = 3.5;

    // Of a vehicle that stands.
    struct Signals {
        double window = 1.0;              // [s]
        Rates noise = Rates::Zero();      // density [rad/s^0.5], [m/s^1.5]
        Rates deviation = Rates::Zero();  // of what shakes it besides [rad/s], [m/s2]
    };

    void start() { *this = Standstill{}; }

    // Something is not known of the time before the next sample.
    void interrupt() {
        window_ = {};
        was_quiet_ = false;
        stands_ = false;
        ended_ = false;
    }

    // A sound sample.
    void add(const ImuIncrement& increment, const Signals& standing);

    // With the last sample a window has ended; it and the one before look like standing.
    [[nodiscard]] bool ended() const { return ended_; }
    [[nodiscard]] bool looks_like_it() const { return steady_; }
    [[nodiscard]] const Rates& mean() const { return mean_; }         // of that window
    [[nodiscard]] const Rates& mean_sigma() const { return sigma_; }  // of the mean, for one that stands

    // At the end of a window: what else is known speaks for it, or not.
    void decide(bool possible) { stands_ = steady_ && possible; }
    [[nodiscard]] bool stands() const { return stands_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(window_, mean_, sigma_, was_quiet_, steady_, ended_, stands_);
    }

  private:
    struct Window {
        int samples = 0;
        double duration = 0.0;            // [s]
        Rates travelled = Rates::Zero();  // sum of the increments
        Rates mean = Rates::Zero();       // of the samples
        Rates scatter = Rates::Zero();    // sum of the squares about it

        template <class Archive>
        void serialize(Archive& archive) {
            archive(samples, duration, travelled, mean, scatter);
        }
    };

    Window window_;  // that is going on
    Rates mean_ = Rates::Zero();
    Rates sigma_ = Rates::Zero();
    bool was_quiet_ = false;
    bool steady_ = false;
    bool ended_ = false;
    bool stands_ = false;
};

}  // namespace truenorth
