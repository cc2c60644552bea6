// A bank of extended Kalman filters, each linearised at its own state and weighed by how well it foretold the
// measurements: a Gaussian sum filter (Alspach and Sorenson 1972, "Nonlinear Bayesian estimation using
// Gaussian sum approximations").
//
// For a prior that is too wide to linearise in: a filter that does so all the same takes the motion of its
// own estimate for information. Members that are each narrow do not, and what the measurements say of the
// wide prior stands in the weights.
//
// The weights have two parts. A measurement that a member did not foretell may have been explained by
// constants of which something was known beforehand, and then counts no more than these have moved; what else
// it says of the members is evidence. Where it is known that there can be none, it need not be counted: what
// drives the model has noise, and members that are driven apart by noise would be told apart by noise.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "elementary/exponential.hpp"
#include "elementary/logarithm.hpp"
#include "estimation/innovation_gate.hpp"
#include "estimation/linearised.hpp"
#include "estimation/standard.hpp"

namespace truenorth {

// Logarithm of the density of an innovation, but for a constant of its dimension.
template <int N, int M>
double log_likelihood(const Innovation<N, M>& innovation) {
    const Eigen::LLT<Matrix<M>> S(innovation.spread + innovation.noise);
    const Vector<M> whitened = S.matrixL().solve(innovation.residual);
    double log_determinant = 0.0;  // of the factor
    for (int i = 0; i < M; ++i) {
        log_determinant += logarithm(S.matrixLLT()(i, i));
    }
    return -0.5 * whitened.squaredNorm() - log_determinant;
}

// Of a model that is no vector space: it has retract and local.
template <ErrorModel M>
class GaussianSum {
  public:
    using Covariance = Matrix<M::kStates>;

    struct Member {
        typename M::State state;
        Covariance covariance;
        double evidence = 0.0;   // logarithm of the likelihood, without what follows
        double log_prior = 0.0;  // of its constants, as they are now

        // But for a constant that all members share.
        [[nodiscard]] double log_weight() const { return evidence + log_prior; }

        template <class Archive>
        void serialize(Archive& archive) {
            archive(state, covariance, evidence, log_prior);
        }
    };

    // Mean and covariance of all members together.
    struct Moments {
        typename M::State state;
        Covariance covariance;
    };

    static constexpr std::size_t kCapacity = 24;

    // Allocates what it will ever need.
    void reserve() { members_.reserve(kCapacity); }

    [[nodiscard]] bool active() const { return !members_.empty(); }
    void clear() { members_.clear(); }
    void add(const Member& member) { members_.push_back(member); }

    // Of each member, to which more may be done than this class knows of.
    [[nodiscard]] std::vector<Member>& members() { return members_; }

    // First phase of the filter step, of every member.
    void predict(const M& model, const typename M::Interval& interval) {
        for (Member& member : members_) {
            carry(model, member.state, member.covariance, interval);
        }
    }

    // Second and third; members that are out of the question are dropped. `log_prior` is that of the
    // constants of a state; `evident`: the fix can tell the members apart by more than these. Returns whether
    // any member had foretold the fix, as the gate has it: else nothing changes.
    template <class LogPrior>
    bool correct(const M& model, const typename M::Fix& fix, const InnovationGate& gate,
                 const LogPrior& log_prior, bool evident) {
        double least = std::numeric_limits<double>::infinity();
        int channels = 0;
        for (const Member& member : members_) {
            const auto innovation = innovate(model, member.state, member.covariance, fix);
            channels = innovation.channels();
            least = std::min(least, nis(innovation));
        }
        if (!gate.admits(least, channels)) {
            return false;
        }
        for (Member& member : members_) {
            const auto innovation = innovate(model, member.state, member.covariance, fix);
            const auto correction = Standard().correct(member.covariance, innovation);
            member.covariance = correction.covariance;
            truenorth::correct(model, member.state, correction.deviation, [&member](const Covariance& F) {
                member.covariance = transformed<M::kStates>(F, member.covariance);
            });
            const double before = std::exchange(member.log_prior, log_prior(member.state));
            if (evident) {
                member.evidence += log_likelihood(innovation) - (member.log_prior - before);
            }
        }
        drop();
        return true;
    }

    // The mean is the state from which the weighted deviations of the members cancel, sought from the member
    // of the most weight.
    [[nodiscard]] Moments moments() const {
        constexpr int kIterations = 5;
        const auto heaviest = std::ranges::max_element(members_, {}, &Member::log_weight);
        Moments all{.state = heaviest->state, .covariance = Covariance::Zero()};
        double total = 0.0;
        for (const Member& member : members_) {
            total += exponential(member.log_weight() - heaviest->log_weight());
        }
        const auto share = [&](const Member& member) {
            return exponential(member.log_weight() - heaviest->log_weight()) / total;
        };
        for (int iteration = 0; iteration < kIterations; ++iteration) {
            Vector<M::kStates> mean = Vector<M::kStates>::Zero();
            for (const Member& member : members_) {
                mean += share(member) * M::local(all.state, member.state);
            }
            all.state = M::retract(all.state, mean);
        }
        for (const Member& member : members_) {
            const Vector<M::kStates> d = M::local(all.state, member.state);
            all.covariance += share(member) * (member.covariance + d * d.transpose());
        }
        return all;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        std::uint64_t count = members_.size();
        archive(count);
        if constexpr (Archive::is_loading::value) {
            if (count > kCapacity) {
                throw std::out_of_range("the stored state is damaged: it has " + std::to_string(count) +
                                        " members of a bank of filters");
            }
            reserve();
            members_.resize(count);
        }
        for (Member& member : members_) {
            archive(member);
        }
    }

  private:
    void drop() {
        constexpr double kNothing = 25.0;  // of a logarithm: 1e-11 of the most
        const double most = std::ranges::max_element(members_, {}, &Member::log_weight)->log_weight();
        std::erase_if(members_, [most](const Member& m) { return m.log_weight() < most - kNothing; });
        for (Member& member : members_) {
            member.evidence -= most;
        }
    }

    std::vector<Member> members_;
};

}  // namespace truenorth
