// A filter with constants beside its states is the filter of the joint state: a dense Kalman filter of both,
// for any sequence of predictions, measurements of the states, and measurements of both.
#include "estimation/appended.hpp"

#include <gtest/gtest.h>

#include "estimation/random_covariance.hpp"
#include "estimation/standard.hpp"

namespace truenorth {
namespace {

constexpr int kN = 5;
constexpr int kS = Appended::kCount;
constexpr int kAll = kN + kS;

struct Joint {  // the dense filter
    Dense mean = Dense::Zero(kAll, 1);
    Dense P = Dense::Zero(kAll, kAll);

    void predict(const Dense& F, const Dense& Q) {
        Dense all = Dense::Identity(kAll, kAll);
        all.topLeftCorner(kN, kN) = F;
        mean = all * mean;
        P = all * P * all.transpose();
        P.topLeftCorner(kN, kN) += Q;
    }
    void measure(const Dense& H, const Dense& R, const Dense& residual) {
        const Dense K = P * H.transpose() * inverse(H * P * H.transpose() + R);
        mean += K * residual;
        P -= K * H * P;
    }
};

class AppendedToAFilter : public testing::TestWithParam<unsigned> {
  protected:
    void SetUp() override {
        constants.prior_sigma << 0.01, 0.1, 1.0, 0.0, 3.0, 10.0;
        constants.start();
        P = random.covariance<kN>(1e-3, 1e3);
        joint.P.topLeftCorner(kN, kN) = P;
        joint.P.bottomRightCorner(kS, kS) = constants.covariance();
    }

    void expect_equal() {
        EXPECT_LT(relative_difference(P, joint.P.topLeftCorner(kN, kN)), 1e-9);
        EXPECT_LT(relative_difference(constants.covariance(), joint.P.bottomRightCorner(kS, kS)), 1e-9);
        const Dense scale = joint.P.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse().asDiagonal();
        Dense mine = joint.P;
        mine.topRightCorner(kN, kS) = constants.cross<kN>();
        EXPECT_LT((scale * (mine - joint.P) * scale).topRightCorner(kN, kS).cwiseAbs().maxCoeff(), 1e-7);
        for (int i = 0; i < kN; ++i) {
            EXPECT_NEAR(mean(i), joint.mean(i, 0), 1e-7 * (1.0 + std::abs(mean(i))));
        }
        for (int i = 0; i < kS; ++i) {
            EXPECT_NEAR(constants.mean()(i), joint.mean(kN + i, 0),
                        1e-7 * (1.0 + std::abs(constants.mean()(i))));
        }
    }

    void predict() {
        const Matrix<kN> F = Matrix<kN>::Identity() + 0.2 * random.normal<kN, kN>();
        const Matrix<kN> Q = random.covariance<kN>(1e-3, 1e-1);
        constants.carry<kN>(F);
        P = transformed<kN>(F, P) + Q;
        mean = (F * mean).eval();
        joint.predict(F, Q);
    }

    void measure_states() {
        const Matrix<2, kN> H = random.normal<2, kN>();
        const Matrix<2> R = random.covariance<2>(0.1, 1.0);
        const Vector<2> z = random.normal<2, 1>();
        const auto correction = Standard().correct(P, innovation_of<kN, 2>(P, H, R, Vector<2>(z - H * mean)));
        constants.learn<kN>(P, correction.covariance, correction.deviation);
        P = correction.covariance;
        Dense all = Dense::Zero(2, kAll);
        all.leftCols(kN) = H;
        joint.measure(all, R, Dense(z) - all * joint.mean);
        mean += correction.deviation;
    }

    void measure_both() {
        const Matrix<3, kN> H = random.normal<3, kN>();
        const Matrix<3, kS> L = random.normal<3, kS>();
        const Matrix<3> R = random.covariance<3>(0.1, 1.0);
        const Vector<3> z = random.normal<3, 1>();
        const Matrix<kN, kS> C = constants.cross<kN>();
        const Matrix<kN, 3> cross = P * H.transpose() + C * L.transpose();
        const Matrix<kS, 3> own = C.transpose() * H.transpose() + constants.covariance() * L.transpose();
        const Innovation<kN, 3> innovation{z - H * mean - L * constants.mean(), H * cross + L * own, R,
                                           cross};
        const auto correction = Standard().correct(P, innovation);
        constants = constants.after(innovation, own);
        P = correction.covariance;
        Dense all = Dense::Zero(3, kAll);
        all << Dense(H), Dense(L);
        joint.measure(all, R, Dense(z) - all * joint.mean);
        mean += correction.deviation;
    }

    RandomCovariance random{GetParam()};
    Appended constants;
    Vector<kN> mean = Vector<kN>::Zero();
    Matrix<kN> P;
    Joint joint;
};

TEST_P(AppendedToAFilter, IsTheFilterOfBoth) {
    for (int n = 0; n < 30; ++n) {
        measure_states();
        predict();
        measure_both();
        predict();
        measure_states();
        ASSERT_NO_FATAL_FAILURE(expect_equal());
    }
}

TEST_P(AppendedToAFilter, LeavesConstantsThatAreConsideredAsTheyWere) {
    measure_states();
    measure_both();
    const Matrix<3, kN> H = random.normal<3, kN>();
    const Matrix<3, kS> L = random.normal<3, kS>();
    const Matrix<kN, kS> C = constants.cross<kN>();
    const Matrix<kS> S = constants.covariance();
    const Matrix<kN, 3> cross = P * H.transpose() + C * L.transpose();
    const Matrix<kS, 3> own = C.transpose() * H.transpose() + S * L.transpose();
    const Innovation<kN, 3> innovation{Vector<3>::Ones(), H * cross + L * own, Matrix<3>::Identity(), cross};
    const Appended next = constants.considered(innovation, own);
    EXPECT_EQ(next.mean(), constants.mean());
    EXPECT_EQ(next.covariance(), S);
    // The covariance of the joint error with the gain K of the states and none of the constants.
    const Dense K = Dense(cross) * inverse(Dense(innovation.spread) + Dense::Identity(3, 3));
    const Dense expected = (Dense::Identity(kN, kN) - K * Dense(H)) * Dense(C) - K * Dense(L) * Dense(S);
    EXPECT_LT(relative_difference(next.cross<kN>(), expected), 1e-9);
}

TEST_P(AppendedToAFilter, KnowsNothingOfStatesThatAreKnownAnew) {
    measure_both();
    EXPECT_TRUE(constants.related());
    const Matrix<kS> before = constants.covariance();
    constants.part();
    measure_states();
    EXPECT_FALSE(constants.related());
    EXPECT_EQ(constants.covariance(), before);
}

TEST_P(AppendedToAFilter, ForgetsOneSensorAndKeepsTheOthers) {
    measure_both();
    predict();
    const Appended before = constants;
    constants.forget(1, 2);
    for (int i = 0; i < kS; ++i) {
        const bool forgotten = i == 1 || i == 2;
        EXPECT_EQ(constants.mean()(i), forgotten ? 0.0 : before.mean()(i));
        EXPECT_EQ(constants.covariance()(i, i), forgotten
                                                    ? constants.prior_sigma(i) * constants.prior_sigma(i)
                                                    : before.covariance()(i, i));
        EXPECT_EQ(constants.cross<kN>().col(i).isZero(0.0), forgotten || constants.prior_sigma(i) == 0.0);
    }
}

TEST_P(AppendedToAFilter, MayBeForgottenBeyondThePrior) {
    constants.forget(1, 1, 0.7);
    EXPECT_DOUBLE_EQ(constants.covariance()(1, 1), 0.49);
    constants.forget(1, 1, 0.07);
    EXPECT_DOUBLE_EQ(constants.covariance()(1, 1), 0.01);  // that of the prior
    constants.forget(3, 1, 0.7);
    EXPECT_EQ(constants.covariance()(3, 3), 0.0);  // the sensor has no such error
}

// A corrector that divides the covariance by alpha adds noise that has nothing to do with the constants.
TEST_P(AppendedToAFilter, IsTheFilterOfBothWhenThePredictionIsBlamed) {
    measure_both();
    predict();
    for (const double alpha : {0.5, 0.01}) {
        const Matrix<kN> blamed = P / alpha;
        joint.P.topLeftCorner(kN, kN) = blamed;
        const Matrix<2, kN> H = random.normal<2, kN>();
        const Matrix<2> R = random.covariance<2>(0.1, 1.0);
        const Vector<2> z = random.normal<2, 1>();
        const auto correction =
            Standard().correct(blamed, innovation_of<kN, 2>(blamed, H, R, Vector<2>(z - H * mean)));
        constants.learn<kN>(blamed, correction.covariance, correction.deviation);
        P = correction.covariance;
        mean += correction.deviation;
        Dense all = Dense::Zero(2, kAll);
        all.leftCols(kN) = H;
        joint.measure(all, R, Dense(z) - all * joint.mean);
        ASSERT_NO_FATAL_FAILURE(expect_equal());
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AppendedToAFilter, testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace truenorth
