// Variational Bayes corrector of Jing 2023, section 2 (after Sarkka and Nummenmaa 2009): the variances of the
// measurement noise are estimated with the state.
//
// The variance of a channel has an inverse gamma distribution of the parameters a and b; R = diag(b / a).
//
//     a- = rho a, b- = rho b                                                          (eq. 12)
//     a  = a- + 1/2, b = b-; then, a few times:
//         R = diag(b / a), measurement update
//         b = b- + r^2 / 2 + diag(H P+ H^T) / 2        r the residual of the posterior
//
// Neither needs the states: with S = H P H^T + R, r = R S^-1 v and H P+ H^T = R - R S^-1 R. a tends to
// 1 / (2 (1 - rho)), so that R remembers some 1 / (1 - rho) epochs. Jing 2023's eq. 17 adds 1/2 to the a of
// the epoch before, not to a-, so that a grows without bound while b does not, and takes residual and
// covariance of the prior; this is the form `printed`, which lets the new R act in the epoch that it comes
// from (eq. 16 has that of the epoch before).
//
// No estimate is believed that is more than `limit` times off the nominal sigma: beyond it innovations are
// large for another reason, such as a prediction that has gone astray, and shall show.
//
// A channel starts with the nominal R of its first epoch, or with a variance that is given, as sure as
// 2 a epochs make it (Jing 2023, eq. 19: a = 1, b = 0.1 m2/s2 and 2 m2); correlations of the nominal R
// are left out. A channel that is absent learns nothing, and nothing is forgotten of it. The
// corrector is the standard one, with R as given, for 0 iterations.
#pragma once

#include <Eigen/Cholesky>

#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"
#include "settings/correction.hpp"

namespace truenorth {

template <int M>
class VariationalBayes : public settings::VariationalBayes {
  public:
    using Form = settings::BayesForm;
    using settings::VariationalBayes::operator=;

    Vector<M> start_variance = Vector<M>::Zero();  // b / a of a channel that starts; 0: the nominal R

    template <int N>
    Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) {
        if (iterations == 0) {
            return Standard().correct(prior, innovation);
        }
        const auto& present = innovation.present;
        const Array nominal = innovation.noise.diagonal();
        const Mask starts = present && a_ == 0.0;
        const Array start = (start_variance.array() > 0.0).select(start_variance.array(), nominal);
        a_ = starts.select(a, a_);
        b_ = starts.select(a * start, b_);

        const bool printed = form == Form::printed;
        const Array a_now = (printed ? 1.0 : rho) * a_ + 0.5;
        const Array b_prior = rho * b_;
        Array b = b_prior;
        Innovation<N, M> used = innovation;
        for (int i = 0; i < (printed ? 1 : iterations); ++i) {
            used.noise = present.select(b / a_now, nominal).matrix().asDiagonal();
            b = b_prior + 0.5 * (printed ? square_of_prior(used) : square_of_posterior(used));
            if (!printed) {
                b = b.max(a_now * nominal / (limit * limit)).min(a_now * nominal * (limit * limit));
            }
        }
        a_ = present.select(a_now, a_);
        b_ = present.select(b, b_);
        return Standard().correct(prior, used);
    }

    // Variances of the measurement noise as estimated; 0 of a channel that has not been measured yet.
    [[nodiscard]] Vector<M> noise() const { return (a_ > 0.0).select(b_ / a_, 0.0).matrix(); }

    // What is known of a channel's noise belongs to another source (satellite) from now on.
    void restart(int channel) { a_(channel) = 0.0; }
    void restart() { a_.setZero(); }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(a_, b_);
    }

  private:
    using Array = Eigen::Array<double, M, 1>;
    using Mask = Eigen::Array<bool, M, 1>;

    // Expected square of the residual of the posterior.
    template <int N>
    static Array square_of_posterior(const Innovation<N, M>& innovation) {
        const Eigen::LLT<Matrix<M>> S(innovation.spread + innovation.noise);
        const Vector<M> residual = innovation.noise.lazyProduct(S.solve(innovation.residual));
        Matrix<M> whitened = innovation.noise;
        S.matrixL().solveInPlace(whitened);
        return residual.cwiseAbs2() + innovation.noise.diagonal() -
               whitened.colwise().squaredNorm().transpose();
    }

    template <int N>
    static Array square_of_prior(const Innovation<N, M>& innovation) {
        return innovation.residual.cwiseAbs2() + innovation.spread.diagonal();
    }

    Array a_ = Array::Zero();
    Array b_ = Array::Zero();
};

}  // namespace truenorth
