#include "estimation/linearised.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "estimation/example_models.hpp"
#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

TEST(Linearised, MovesTheStateThroughTheModelAndTheCovarianceThroughTheJacobianOfTheStart) {
    RandomCovariance random(4);
    CurvedModel model;
    model.Q = random.covariance<3>(0.1, 1.0);
    const Vector<3> start = random.normal<3, 1>();
    const Matrix<3> P0 = random.covariance<3>(0.1, 1.0);
    Vector<3> x = start;
    Matrix<3> P = P0;
    EXPECT_EQ(Linearised().predict(model, x, P, {}), Prediction::sound);

    Matrix<3> F;
    for (int j = 0; j < 3; ++j) {
        const Vector<3> h = 1e-6 * Vector<3>::Unit(j);
        F.col(j) = (CurvedModel::moved(start + h) - CurvedModel::moved(start - h)) / 2e-6;
    }
    EXPECT_EQ(x, CurvedModel::moved(start));
    EXPECT_LT(relative_difference(P, Matrix<3>(F * P0 * F.transpose() + model.Q)), 1e-8);
}

TEST(Linearised, KeepsTheCovarianceSymmetricAndPositiveDefinite) {
    for (const unsigned seed : {1U, 2U}) {
        RandomCovariance random(seed);
        for (int i = 0; i < 200; ++i) {
            LinearModel<10> model;
            model.F = random.normal<10, 10>();
            model.Q = 1e-6 * Matrix<10>::Identity();
            Vector<10> x = random.normal<10, 1>();
            Matrix<10> P = random.covariance<10>(1e-6, 1.0);
            Linearised().predict(model, x, P, {});
            EXPECT_EQ(P, P.transpose());
            EXPECT_GT(smallest_eigenvalue(P), 0.0);
        }
    }
}

TEST(Linearised, FailsWhenTheModelGivesNoNumber) {
    LinearModel<3> model;
    model.F(0, 0) = std::numeric_limits<double>::infinity();
    Vector<3> x = Vector<3>::Ones();
    Matrix<3> P = Matrix<3>::Identity();
    EXPECT_EQ(Linearised().predict(model, x, P, {}), Prediction::failed);
}

}  // namespace
}  // namespace truenorth
