#include "estimation/unscented.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "estimation/example_models.hpp"
#include "estimation/linearised.hpp"
#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

// Zhou 2011, section 1, time update, word for word.
template <class Scalar>
struct Transcription {
    using V = Eigen::Matrix<Scalar, 3, 1>;
    using M = Eigen::Matrix<Scalar, 3, 3>;
    V mean;
    M covariance;

    Transcription(const Vector<3>& x, const Matrix<3>& P, const Matrix<3>& Q, const UnscentedParameters& p) {
        const Scalar n = 3;
        const Scalar alpha = p.alpha;
        const Scalar beta = p.beta;
        const Scalar kappa = p.kappa;
        const Scalar lambda = alpha * alpha * (n + kappa) - n;
        const M root = M((n + lambda) * P.cast<Scalar>()).llt().matrixL();
        Eigen::Matrix<Scalar, 3, 7> X;
        X.col(0) = x.cast<Scalar>();
        for (int i = 0; i < 3; ++i) {
            X.col(1 + i) = X.col(0) + root.col(i);
            X.col(4 + i) = X.col(0) - root.col(i);
        }
        Eigen::Matrix<Scalar, 7, 1> Wm = Eigen::Matrix<Scalar, 7, 1>::Constant(1 / (2 * (n + lambda)));
        Eigen::Matrix<Scalar, 7, 1> Wc = Wm;
        Wm(0) = lambda / (n + lambda);
        Wc(0) = lambda / (n + lambda) + (1 - alpha * alpha + beta);

        mean.setZero();
        for (int i = 0; i < 7; ++i) {
            X.col(i) = CurvedModel::map(V(X.col(i)));
            mean += Wm(i) * X.col(i);
        }
        covariance = Q.cast<Scalar>();
        for (int i = 0; i < 7; ++i) {
            covariance += Wc(i) * (X.col(i) - mean) * (X.col(i) - mean).transpose();
        }
    }
};

TEST(Unscented, IsTheTimeUpdateOfZhou2011) {
    for (const unsigned seed : {3U, 77U}) {
        RandomCovariance random(seed);
        for (int i = 0; i < 50; ++i) {
            for (const UnscentedParameters& p : {UnscentedParameters{.alpha = 1.0, .beta = 2.0, .kappa = 0.0},
                                                 {.alpha = 1.0, .beta = 0.0, .kappa = 1.5},
                                                 {.alpha = 0.5, .beta = 2.0, .kappa = 0.0},
                                                 {.alpha = 0.1, .beta = 1.0, .kappa = 2.0}}) {
                CurvedModel model;
                model.Q = random.covariance<3>(1e-3, 1e-1);
                Vector<3> x = random.normal<3, 1>();
                Matrix<3> P = random.covariance<3>(1e-3, 1.0);
                const Transcription<long double> expected(x, P, model.Q, p);

                EXPECT_EQ(Unscented(p).predict(model, x, P, {}), Prediction::sound);
                EXPECT_LT(relative_difference(x, expected.mean.cast<double>()), 1e-12);
                EXPECT_LT(relative_difference(P, expected.covariance.cast<double>()), 1e-12);
            }
        }
    }
}

TEST(Unscented, KeepsTheDigitsThatTheWeightsOfASmallSpreadCost) {
    // Around zero, where an error-state filter with feedback works, nothing but the weights costs digits.
    const UnscentedParameters p{.alpha = 1e-3, .beta = 2.0, .kappa = 0.0};
    for (const unsigned seed : {5U, 91U}) {
        RandomCovariance random(seed);
        double worst = 0.0;
        double worst_naive = 0.0;
        for (int i = 0; i < 50; ++i) {
            const CurvedModel model;
            Vector<3> x = Vector<3>::Zero();
            Matrix<3> P = random.covariance<3>(0.3, 3.0);
            const Transcription<long double> expected(x, P, model.Q, p);
            const Transcription<double> naive(x, P, model.Q, p);
            Unscented(p).predict(model, x, P, {});
            worst = std::max(worst, relative_difference(P, expected.covariance.cast<double>()));
            worst_naive = std::max(worst_naive,
                                   relative_difference(naive.covariance, expected.covariance.cast<double>()));
        }
        EXPECT_LT(worst, 1e-12);
        EXPECT_GT(worst_naive, 100.0 * worst);
    }
}

TEST(Unscented, EqualsLinearisedOnALinearModel) {
    for (const double alpha : {1e-3, 0.1, 1.0}) {
        for (const unsigned seed : {11U, 12U}) {
            RandomCovariance random(seed);
            for (int i = 0; i < 20; ++i) {
                LinearModel<10> model;
                model.F = random.normal<10, 10>();
                model.Q = random.covariance<10>(1e-3, 1.0);
                Vector<10> x = random.normal<10, 1>();
                Matrix<10> P = random.covariance<10>(1e-2, 10.0);
                Vector<10> x_linear = x;
                Matrix<10> P_linear = P;
                Unscented({.alpha = alpha}).predict(model, x, P, {});
                Linearised().predict(model, x_linear, P_linear, {});
                EXPECT_LT(relative_difference(x, x_linear), 1e-9);
                EXPECT_LT(relative_difference(P, P_linear), 1e-9);
            }
        }
    }
}

TEST(Unscented, FindsTheMeanShiftOfCurvatureThatLinearisedMisses) {
    // E[a^2 / 2] = P_aa / 2 in the second row of the model at zero.
    const CurvedModel model;
    Vector<3> x = Vector<3>::Zero();
    Matrix<3> P = Eigen::Vector3d(0.4, 0.1, 0.1).asDiagonal();
    Unscented().predict(model, x, P, {});
    EXPECT_NEAR(x(1), 0.2, 1e-6);
}

TEST(Unscented, KeepsTheCovarianceSymmetricAndPositiveDefinite) {
    for (const unsigned seed : {21U, 22U}) {
        RandomCovariance random(seed);
        for (int i = 0; i < 200; ++i) {
            CurvedModel model;
            model.Q = 1e-3 * Matrix<3>::Identity();
            Vector<3> x = random.normal<3, 1>();
            Matrix<3> P = random.covariance<3>(1e-6, 1.0);
            Unscented().predict(model, x, P, {});
            EXPECT_EQ(P, P.transpose());
            EXPECT_GT(smallest_eigenvalue(P), 0.0);
        }
    }
}

TEST(Unscented, RepairsAnIndefiniteCovarianceAndSaysSo) {
    const LinearModel<3> model;
    Vector<3> x = Vector<3>::Ones();
    Matrix<3> P = Eigen::Vector3d(1.0, 2.0, 3.0).asDiagonal();
    P(0, 1) = P(1, 0) = 1.6;  // correlation above one
    EXPECT_EQ(Unscented().predict(model, x, P, {}), Prediction::repaired);
    EXPECT_TRUE(P.allFinite());
    EXPECT_GT(smallest_eigenvalue(P), -1e-12);
    EXPECT_NEAR(P(2, 2), 3.0, 1e-9);
}

TEST(Unscented, FailsOnACovarianceThatIsNotFinite) {
    const LinearModel<3> model;
    Vector<3> x = Vector<3>::Ones();
    Matrix<3> P = Matrix<3>::Identity();
    P(2, 2) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(Unscented().predict(model, x, P, {}), Prediction::failed);
}

TEST(Unscented, FailsWhenTheModelGivesNoNumber) {
    LinearModel<3> model;
    model.F(0, 0) = std::numeric_limits<double>::infinity();
    Vector<3> x = Vector<3>::Ones();
    Matrix<3> P = Matrix<3>::Identity();
    EXPECT_EQ(Unscented().predict(model, x, P, {}), Prediction::failed);
}

}  // namespace
}  // namespace truenorth
