#include "estimation/augmented.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "estimation/estimator.hpp"
#include "estimation/example_models.hpp"
#include "estimation/random_covariance.hpp"
#include "estimation/standard.hpp"

namespace truenorth {
namespace {

// Curved in state and measurement.
struct CurvedMeasurement : CurvedModel {
    static constexpr int kMeasured = 2;

    template <class V>
    [[nodiscard]] static auto predict(const V& x) {
        using std::exp;
        using std::sin;
        Eigen::Matrix<typename V::Scalar, kMeasured, 1> y;
        y << x(0) * x(0) / 2 + x(1), sin(x(2)) + x(0) * x(1);
        return y;
    }
    template <int Count>
    [[nodiscard]] static Points<2, Count> predicted(const State& x, const Points<3, Count>& deviations,
                                                    const Fix& /*fix*/) {
        Points<2, Count> images;
        for (int i = 0; i < Count; ++i) {
            images.col(i) = predict(State(x + deviations.col(i))) - predict(x);
        }
        return images;
    }
    [[nodiscard]] static Eigen::Vector2d residual(const State& x, const Fix& fix) {
        return fix.value - predict(x);
    }
};
static_assert(NonlinearMeasurement<CurvedMeasurement>);
static_assert(!NonlinearMeasurement<CurvedModel>);

// Curved in its noise too, half of which comes before the model and half after.
struct CurvedNoise : CurvedModel {
    using CurvedModel::propagate;

    template <class V>
    [[nodiscard]] static V map_with(const V& x, const V& w) {
        return map(V(x + w / 2)) + w / 2;
    }
    template <int Count>
    void propagate(State& x, Points<3, Count>& deviations, const Points<3, Count>& noise,
                   const Interval& /*interval*/) const {
        const State start = x;
        x = moved(start);
        for (int i = 0; i < Count; ++i) {
            deviations.col(i) = map_with(State(start + deviations.col(i)), State(noise.col(i))) - x;
        }
    }
};
static_assert(NoiseInside<CurvedNoise>);
static_assert(!NoiseInside<CurvedModel>);

using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

// Points and weights of Jing 2023, eqs. 10 and 11, for a covariance of any size.
struct Sigma {
    Long points;  // about zero
    Long Wm;
    Long Wc;

    Sigma(const Long& P, const UnscentedParameters& p)
        : points(Long::Zero(P.rows(), 2 * P.rows() + 1)), Wm(points.cols(), 1), Wc(points.cols(), 1) {
        const Eigen::Index L = P.rows();
        const long double alpha = p.alpha;
        const long double lambda = alpha * alpha * (L + static_cast<long double>(p.kappa)) - L;
        const Long root = Long((L + lambda) * P).llt().matrixL();
        points.middleCols(1, L) = root;
        points.rightCols(L) = -root;
        Wm.setConstant(1 / (2 * (L + lambda)));
        Wc.setConstant(1 / (2 * (L + lambda)));
        Wm(0) = lambda / (L + lambda);
        Wc(0) = Wm(0) + 1 - alpha * alpha + static_cast<long double>(p.beta);
    }
    [[nodiscard]] Long covariance(const Long& A, const Long& B) const {
        const Long a = A.colwise() - Long(A * Wm).col(0);
        const Long b = B.colwise() - Long(B * Wm).col(0);
        return a * Wc.col(0).asDiagonal() * b.transpose();
    }
};

Long both(const Long& A, const Long& B) {
    Long joint = Long::Zero(A.rows() + B.rows(), A.rows() + B.rows());
    joint.topLeftCorner(A.rows(), A.rows()) = A;
    joint.bottomRightCorner(B.rows(), B.rows()) = B;
    return joint;
}

constexpr std::array kParameters{UnscentedParameters{.alpha = 1.0, .beta = 0.0, .kappa = 0.0},
                                 UnscentedParameters{.alpha = 1.0, .beta = 2.0, .kappa = 1.5},
                                 UnscentedParameters{.alpha = 0.3, .beta = 2.0, .kappa = 0.0}};

class AugmentedPredictor : public testing::TestWithParam<unsigned> {};

TEST_P(AugmentedPredictor, IsTheTimeUpdateWithTheNoiseInTheState) {
    RandomCovariance random(GetParam());
    for (const UnscentedParameters& p : kParameters) {
        for (int i = 0; i < 30; ++i) {
            CurvedModel model;
            model.Q = random.covariance<3>(1e-3, 1e-1);
            Vector<3> x = random.normal<3, 1>();
            Matrix<3> P = random.covariance<3>(1e-3, 1.0);

            // Jing 2023, eqs. 8-14: X^a = (x, w), every point through f(x) + w.
            const Sigma sigma(both(P.cast<long double>(), model.Q.cast<long double>()), p);
            Long moved(3, sigma.points.cols());
            for (int k = 0; k < moved.cols(); ++k) {
                const Eigen::Matrix<long double, 3, 1> start =
                    x.cast<long double>() + sigma.points.col(k).head(3);
                moved.col(k) = CurvedModel::map(start) + sigma.points.col(k).tail(3);
            }
            EXPECT_EQ(Augmented(p).predict(model, x, P, {}), Prediction::sound);
            EXPECT_LT(relative_difference(x, Long(moved * sigma.Wm).cast<double>()), 1e-12);
            EXPECT_LT(relative_difference(P, sigma.covariance(moved, moved).cast<double>()), 1e-12);
        }
    }
}

TEST_P(AugmentedPredictor, MovesTheNoiseThroughAModelThatHasItInside) {
    RandomCovariance random(GetParam());
    for (const UnscentedParameters& p : kParameters) {
        for (int i = 0; i < 30; ++i) {
            CurvedNoise model;
            model.Q = random.covariance<3>(1e-3, 1e-1);
            Vector<3> x = random.normal<3, 1>();
            Matrix<3> P = random.covariance<3>(1e-3, 1.0);
            Vector<3> x_simple = x;
            Matrix<3> P_simple = P;

            // Jing 2023, eq. 13: every point through f(x, w).
            const Sigma sigma(both(P.cast<long double>(), model.Q.cast<long double>()), p);
            Long moved(3, sigma.points.cols());
            for (int k = 0; k < moved.cols(); ++k) {
                const Eigen::Matrix<long double, 3, 1> start =
                    x.cast<long double>() + sigma.points.col(k).head(3);
                const Eigen::Matrix<long double, 3, 1> w = sigma.points.col(k).tail(3);
                moved.col(k) = CurvedNoise::map_with(start, w);
            }
            EXPECT_EQ(Augmented(p).predict(model, x, P, {}), Prediction::sound);
            EXPECT_LT(relative_difference(x, Long(moved * sigma.Wm).cast<double>()), 1e-12);
            EXPECT_LT(relative_difference(P, sigma.covariance(moved, moved).cast<double>()), 1e-12);

            // The simplified filter knows nothing of it.
            Unscented(p).predict(model, x_simple, P_simple, {});
            EXPECT_GT(relative_difference(P, P_simple), 1e-3);
        }
    }
}

TEST_P(AugmentedPredictor, IsTheInnovationWithTheNoiseInTheState) {
    RandomCovariance random(GetParam());
    for (const UnscentedParameters& p : kParameters) {
        for (int i = 0; i < 30; ++i) {
            const CurvedMeasurement model;
            const Vector<3> x = random.normal<3, 1>();
            const Matrix<3> P = random.covariance<3>(1e-3, 1.0);
            const CurvedMeasurement::Fix fix{random.normal<2, 1>()};
            const Eigen::Matrix2d R = CurvedMeasurement::measurement_noise(x, fix);

            // Chen 2019, eqs. 19-22 with z for x: X^a = (x, v), z = h(x) + v.
            const Sigma sigma(both(P.cast<long double>(), R.cast<long double>()), p);
            Long z(2, sigma.points.cols());
            for (int k = 0; k < z.cols(); ++k) {
                const Eigen::Matrix<long double, 3, 1> point =
                    x.cast<long double>() + sigma.points.col(k).head(3);
                z.col(k) = CurvedMeasurement::predict(point) + sigma.points.col(k).tail(2);
            }
            const auto found = Augmented(p).innovate(model, x, P, fix);
            const Eigen::Vector2d mean = Long(z * sigma.Wm).cast<double>();
            EXPECT_LT((found.residual - (fix.value - mean)).norm(), 1e-12);
            EXPECT_LT(relative_difference(Matrix<2>(found.spread + found.noise),
                                          sigma.covariance(z, z).cast<double>()),
                      1e-12);
            EXPECT_LT(
                relative_difference(found.cross, sigma.covariance(sigma.points.topRows(3), z).cast<double>()),
                1e-12);
            EXPECT_LT(relative_difference(found.noise, R), 1e-14);
        }
    }
}

// Of a measurement that a weight of 0.3 has made less certain (Chen 2019, eqs. 30 and 31).
struct DoubtedMeasurement : CurvedMeasurement {
    [[nodiscard]] static Eigen::Matrix2d measurement_noise(const State& x, const Fix& fix) {
        return CurvedMeasurement::measurement_noise(x, fix) / 0.3;
    }
};

TEST_P(AugmentedPredictor, PointsDrawnAnewForAnotherNoiseChangeTheNoiseAlone) {
    RandomCovariance random(GetParam());
    for (const UnscentedParameters& p : kParameters) {
        const Vector<3> x = random.normal<3, 1>();
        const Matrix<3> P = random.covariance<3>(1e-3, 1.0);
        const CurvedMeasurement::Fix fix{random.normal<2, 1>()};
        const auto told = Augmented(p).innovate(CurvedMeasurement{}, x, P, fix);
        const auto doubted = Augmented(p).innovate(DoubtedMeasurement{}, x, P, fix);
        EXPECT_LT((told.residual - doubted.residual).norm(), 1e-12);
        EXPECT_LT(relative_difference(told.spread, doubted.spread), 1e-10);
        EXPECT_LT(relative_difference(told.cross, doubted.cross), 1e-12);
        EXPECT_LT(relative_difference(Matrix<2>(told.noise / 0.3), doubted.noise), 1e-14);
    }
}

TEST_P(AugmentedPredictor, EqualsTheSimplifiedOneWithPointsAtTheSameDistance) {
    // alpha^2 (n + q + kappa) = alpha^2 (n + kappa'): three process noises, two measurement noises.
    RandomCovariance random(GetParam());
    for (int i = 0; i < 50; ++i) {
        CurvedMeasurement model;
        model.Q = random.covariance<3>(1e-3, 1e-1);
        Vector<3> x = random.normal<3, 1>();
        Matrix<3> P = random.covariance<3>(1e-3, 1.0);
        Vector<3> x_simple = x;
        Matrix<3> P_simple = P;
        const double alpha = i % 2 == 0 ? 1.0 : 0.1;
        Augmented({.alpha = alpha, .beta = 0.0, .kappa = 0.0}).predict(model, x, P, {});
        Unscented({.alpha = alpha, .beta = 0.0, .kappa = 3.0}).predict(model, x_simple, P_simple, {});
        EXPECT_LT(relative_difference(x, x_simple), 1e-12);
        EXPECT_LT(relative_difference(P, P_simple), 1e-12);

        const CurvedMeasurement::Fix fix{random.normal<2, 1>()};
        const auto a = Augmented({.alpha = alpha, .beta = 0.0, .kappa = 0.0}).innovate(model, x, P, fix);
        const auto b = Unscented({.alpha = alpha, .beta = 0.0, .kappa = 2.0}).innovate(model, x, P, fix);
        EXPECT_LT((a.residual - b.residual).norm(), 1e-12);
        EXPECT_LT(relative_difference(a.spread, b.spread), 1e-12);
        EXPECT_LT(relative_difference(a.cross, b.cross), 1e-12);
    }
}

TEST_P(AugmentedPredictor, TakesAProcessNoiseThatSomeStatesDoNotHave) {
    RandomCovariance random(GetParam());
    LinearModel<4> model;
    model.F = random.normal<4, 4>();
    model.Q = Eigen::Vector4d(0.0, 2.0, 0.0, 1e-12).asDiagonal();
    Vector<4> x = random.normal<4, 1>();
    Matrix<4> P = random.covariance<4>(0.1, 1.0);
    const Matrix<4> expected = model.F * P * model.F.transpose() + model.Q;
    EXPECT_EQ(Augmented({1.0, 0.0, 0.0}).predict(model, x, P, {}), Prediction::sound);
    EXPECT_LT(relative_difference(P, expected), 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Seeds, AugmentedPredictor, testing::Values(101U, 102U));

TEST(AugmentedPrediction, FailsOnAProcessNoiseThatIsNotFinite) {
    LinearModel<3> model;
    model.Q(1, 1) = std::nan("");
    Vector<3> x = Vector<3>::Ones();
    Matrix<3> P = Matrix<3>::Identity();
    EXPECT_EQ(Augmented().predict(model, x, P, {}), Prediction::failed);
}

// A linear measurement that goes through sigma points all the same.
struct LinearThroughPoints : LinearModel<5> {
    template <int Count>
    [[nodiscard]] static Points<2, Count> predicted(const Vector<5>& /*x*/,
                                                    const Points<5, Count>& deviations, const Fix& /*f*/) {
        return deviations.template topRows<2>();
    }
};
static_assert(NonlinearMeasurement<LinearThroughPoints>);

TEST(Predictors, AreOneFilterOnALinearModel) {
    for (const unsigned seed : {103U, 104U}) {
        const std::array predictors{
            Predictor(Linearised()), Predictor(Unscented({.alpha = 1.0, .beta = 0.0, .kappa = 0.0})),
            Predictor(Unscented()), Predictor(Augmented({.alpha = 1.0, .beta = 0.0, .kappa = 0.0}))};
        std::array<Estimator<LinearThroughPoints>, 4> filters;
        RandomCovariance random(seed);
        for (std::size_t k = 0; k < filters.size(); ++k) {
            RandomCovariance same(seed + 1);
            filters.at(k).predictor = predictors.at(k);
            filters.at(k).model.F =
                Matrix<5>::Identity() - 0.1 * same.covariance<5>(0.1, 1.0) + 0.02 * same.normal<5, 5>();
            filters.at(k).model.Q = same.covariance<5>(1e-3, 1e-1);
            filters.at(k).state.setZero();
            filters.at(k).covariance = same.covariance<5>(0.1, 10.0);
        }
        for (int step = 0; step < 500; ++step) {
            const LinearThroughPoints::Fix fix{random.normal<2, 1>()};
            for (auto& filter : filters) {
                EXPECT_EQ(filter.predict({}), Prediction::sound);
                filter.apply(Standard().correct(filter.covariance, filter.innovate(fix)));
            }
        }
        EXPECT_GT(filters[0].state.norm(), 1e-2);
        for (const auto& filter : filters) {
            EXPECT_LT((filter.state - filters[0].state).norm(), 1e-7);
            EXPECT_LT(relative_difference(filter.covariance, filters[0].covariance), 1e-7);
        }
    }
}

}  // namespace
}  // namespace truenorth
