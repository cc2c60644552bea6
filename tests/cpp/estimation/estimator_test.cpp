#include "estimation/estimator.hpp"

#include <gtest/gtest.h>

#include "estimation/example_models.hpp"
#include "estimation/random_covariance.hpp"
#include "estimation/shear.hpp"
#include "estimation/standard.hpp"

namespace truenorth {
namespace {

struct ResettableModel : LinearModel<4> {
    [[nodiscard]] static Matrix<4> reset_jacobian(const Vector<4>& x) {
        return Matrix<4>::Identity() + x * Vector<4>::Unit(1).transpose();
    }
};

Estimator<ResettableModel> example() {
    Estimator<ResettableModel> estimator;
    RandomCovariance random(13);
    estimator.model.F = random.normal<4, 4>();
    estimator.model.Q = random.covariance<4>(0.1, 1.0);
    estimator.state = random.normal<4, 1>();
    estimator.covariance = random.covariance<4>(0.1, 1.0);
    return estimator;
}

TEST(Estimator, PredictsWithTheChosenPredictor) {
    for (const Predictor& predictor : {Predictor(Linearised()), Predictor(Unscented())}) {
        auto estimator = example();
        const Matrix<4>& F = estimator.model.F;
        const Vector<4> state = F * estimator.state;
        const Matrix<4> covariance = F * estimator.covariance * F.transpose() + estimator.model.Q;
        estimator.predictor = predictor;
        EXPECT_EQ(estimator.predict({}), Prediction::sound);
        EXPECT_LT(relative_difference(estimator.state, state), 1e-9);
        EXPECT_LT(relative_difference(estimator.covariance, covariance), 1e-9);
    }
}

TEST(Estimator, AppliesACorrectionToItsState) {
    auto estimator = example();
    const Vector<4> before = estimator.state;
    const auto innovation = estimator.innovate({Eigen::Vector2d(1.0, 2.0)});
    const auto correction = Standard().correct(estimator.covariance, innovation);
    estimator.apply(correction);
    EXPECT_EQ(estimator.state, before + correction.deviation);
    EXPECT_EQ(estimator.covariance, correction.covariance);
}

// Constants that a measurement has related to the states.
Appended related_constants(RandomCovariance& random) {
    Appended constants;
    constants.prior_sigma.setConstant(0.1);
    constants.start();
    const Innovation<4, 2> both{.residual = Vector<2>::Zero(),
                                .spread = Matrix<2>::Identity(),
                                .noise = Matrix<2>::Identity(),
                                .cross = 0.1 * random.normal<4, 2>()};
    return constants.after(both, Matrix<6, 2>(1e-3 * random.normal<6, 2>()));
}

// The constants learn from the prior that the corrector used, which is what it blamed.
TEST(Estimator, TeachesTheConstantsByThePriorThatWasUsed) {
    RandomCovariance random(7);
    auto estimator = example();
    estimator.appended = related_constants(random);
    Appended expected = estimator.appended;
    const Matrix<4> blamed = estimator.covariance / 0.25;
    auto innovation = estimator.innovate({Eigen::Vector2d(1.0, 2.0)});
    innovation.spread /= 0.25;
    innovation.cross /= 0.25;
    auto correction = Standard().correct(blamed, innovation);
    correction.alpha = 0.25;
    expected.learn<4>(blamed, correction.covariance, correction.deviation);
    estimator.apply(correction);
    EXPECT_EQ(estimator.appended.mean(), expected.mean());
    EXPECT_EQ(estimator.appended.covariance(), expected.covariance());
}

struct HindsightModel : LinearModel<4> {
    [[nodiscard]] static Shear<4> hindsight(const Matrix<4>& P, const Vector<4>& correction) {
        return {.along = 2, .by = P * correction};
    }
};

TEST(Estimator, SeesThePriorAnewAfterACorrection) {
    RandomCovariance random(19);
    Estimator<HindsightModel> estimator;
    estimator.state = random.normal<4, 1>();
    estimator.covariance = random.covariance<4>(0.1, 1.0);
    estimator.appended = related_constants(random);
    const auto innovation = estimator.innovate({Eigen::Vector2d(1.0, 2.0)});
    const auto correction = Standard().correct(estimator.covariance, innovation);
    const Matrix<4> J = HindsightModel::hindsight(estimator.covariance, correction.deviation).matrix();
    const Vector<4> state = estimator.state + correction.deviation;
    Appended expected = estimator.appended;
    expected.learn<4>(estimator.covariance, correction.covariance, correction.deviation);
    expected.carry<4>(J);
    estimator.apply(correction);
    EXPECT_EQ(estimator.state, state);
    EXPECT_LT(relative_difference(estimator.covariance, Matrix<4>(J * correction.covariance * J.transpose())),
              1e-14);
    EXPECT_EQ(estimator.covariance, estimator.covariance.transpose());
    EXPECT_EQ(estimator.appended.cross<4>(), expected.cross<4>());
}

TEST(Estimator, ResetMovesTheCovarianceWithTheJacobianAtTheEstimate) {
    auto estimator = example();
    const Matrix<4> G = ResettableModel::reset_jacobian(estimator.state);
    const Matrix<4> expected = G * estimator.covariance * G.transpose();
    estimator.reset();
    EXPECT_LT(relative_difference(estimator.covariance, expected), 1e-14);
    EXPECT_EQ(estimator.covariance, estimator.covariance.transpose());
    EXPECT_EQ(estimator.state, Vector<4>::Zero());
}

}  // namespace
}  // namespace truenorth
