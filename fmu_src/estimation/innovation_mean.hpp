// Whether the innovations of late have no mean. Those of a filter that is what it believes to be are white:
// of n of them, each by its sigma, the sum has the variance n. A constant error of the measurement that the
// filter was not told of pulls the estimate along and leaves a part of itself in every innovation, each well
// within its covariance.
#pragma once

#include <algorithm>
#include <cmath>

#include "estimation/gaussian.hpp"

namespace truenorth {

template <int K>
class InnovationMean {
  public:
    void restart() { *this = {}; }

    // Of K channels at most, at `time` [s]; what was not measured adds nothing.
    template <int N, int M>
        requires(M <= K)
    void add(double time, const Innovation<N, M>& innovation) {
        const double keep = 1.0 - std::min(std::max(time - time_, 0.0) / kMemory, 1.0 / kFewest);
        time_ = time;
        const Vector<M> variance = (innovation.spread + innovation.noise).diagonal();
        sum_ *= keep;
        variance_ *= keep * keep;
        for (int i = 0; i < M; ++i) {
            if (innovation.present(i)) {
                sum_(i) += innovation.residual(i) / std::sqrt(variance(i));
                variance_(i) += 1.0;
            }
        }
    }

    // Of the channel that is farthest off, in standard deviations; 0 while there are few.
    [[nodiscard]] double deviate() const {
        double largest = 0.0;
        for (int i = 0; i < K; ++i) {
            if (variance_(i) > kEnough) {
                const double deviates = std::abs(sum_(i)) / std::sqrt(variance_(i));
                if (std::isnan(deviates)) {
                    return deviates;
                }
                largest = std::max(largest, deviates);
            }
        }
        return largest;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(sum_, variance_, time_);
    }

  private:
    static constexpr double kMemory = 300.0;  // [s]
    static constexpr double kFewest = 50.0;   // measurements that are remembered however seldom they come
    static constexpr double kEnough = 10.0;   // from which on the mean is asked for

    Vector<K> sum_ = Vector<K>::Zero();
    Vector<K> variance_ = Vector<K>::Zero();
    double time_ = 0.0;
};

}  // namespace truenorth
