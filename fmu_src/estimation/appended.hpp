// Constants that a measurement brings into a filter besides the states of its model: errors of a sensor that
// its own measurements alone show. Model, predictor and corrector know nothing of them. With x the errors of
// the states, s those of the constants, C = E[x s^T]:
//
//   prediction           C <- F C
//   measurement of x     what it says of s is what it says of x, by the regression of s on x, G = C^T P^-1,
//                        which it leaves as it is: s + G dx,  P_s + G (P+ - P) G^T,  C <- P+ G^T.
//                        So for every corrector, whatever gain it used
//   measurement of both  the Kalman update of the joint covariance
//
// (Friedland 1969, "Treatment of bias in recursive filtering", separates them likewise, for linear models and
// gains that are known.)
#pragma once

#include <Eigen/Cholesky>

#include "estimation/bounded.hpp"
#include "estimation/gaussian.hpp"

namespace truenorth {

class Appended {
  public:
    static constexpr int kCount = 6;
    using Constants = Vector<kCount>;

    // Setting; of what a filter has not, zero.
    Constants prior_sigma = Constants::Zero();

    // Nothing but the prior is known.
    void start() {
        mean_.setZero();
        covariance_ = prior_sigma.cwiseAbs2().asDiagonal();
        part();
    }

    // The states are known anew, by something that the constants do not tell in.
    void part() {
        cross_.setZero();
        related_ = false;
    }

    // Of these constants nothing is believed any more, but that they are within the prior or this sigma,
    // whichever is larger.
    void forget(int first, int count, double least_sigma = 0.0);

    [[nodiscard]] bool any() const { return !prior_sigma.isZero(0.0); }
    [[nodiscard]] const Constants& mean() const { return mean_; }
    [[nodiscard]] const Matrix<kCount>& covariance() const { return covariance_; }
    template <int N>
    [[nodiscard]] Matrix<N, kCount> cross() const {
        return cross_.topRows<N>();
    }

    // Of these constants the one that is farthest from its prior: by how many sigmas of that it has moved.
    [[nodiscard]] double deviate(int first, int count) const;

    [[nodiscard]] bool finite() const {
        return mean_.allFinite() && covariance_.allFinite() && cross_.allFinite();
    }

    // Whether the states know of them.
    [[nodiscard]] bool related() const { return related_; }

    // The errors of the states become F times what they were.
    template <int N>
    void carry(const Matrix<N>& F) {
        if (related_) {
            cross_.topRows<N>() = (F * cross_.topRows<N>()).eval();
        }
    }

    // The states alone have been measured, which moved them by `deviation`.
    template <int N>
    void learn(const Matrix<N>& prior, const Matrix<N>& posterior, const Vector<N>& deviation) {
        if (related_) {
            regress(prior, posterior, deviation);
        }
    }

    // After a measurement of both: `own` is the covariance of the constants and the prediction.
    template <int N, int M>
    [[nodiscard]] Appended after(const Innovation<N, M>& innovation, const Matrix<kCount, M>& own) const {
        const Eigen::LLT<Matrix<M>> S(innovation.spread + innovation.noise);
        const Matrix<kCount, M> gain = S.solve(own.transpose()).transpose();
        Appended next = *this;
        next.mean_ += gain * innovation.residual;
        next.covariance_ -= gain * own.transpose();
        symmetrise(next.covariance_);
        next.cross_.topRows<N>() -= innovation.cross * gain.transpose();
        next.related_ = related_ || any();
        return next;
    }

    // Likewise, of a measurement from which nothing is to be learned of the constants themselves: they are
    // considered (Schmidt 1966).
    template <int N, int M>
    [[nodiscard]] Appended considered(const Innovation<N, M>& innovation,
                                      const Matrix<kCount, M>& own) const {
        Appended next = after(innovation, own);
        next.mean_ = mean_;
        next.covariance_ = covariance_;
        return next;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(mean_, covariance_, cross_, related_);
    }

  private:
    using Rows = Eigen::Ref<const Eigen::MatrixXd>;
    void regress(const Rows& prior, const Rows& posterior,
                 const Eigen::Ref<const Eigen::VectorXd>& deviation);

    Constants mean_ = Constants::Zero();
    Matrix<kCount> covariance_ = Matrix<kCount>::Zero();
    Matrix<kMostStates, kCount> cross_ = Matrix<kMostStates, kCount>::Zero();  // as many rows as states
    bool related_ = false;
};

}  // namespace truenorth
