#include "estimation/h_infinity.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

constexpr int kStates = 6;
constexpr int kMeasurements = 2;
constexpr int kHeading = 4;
using Square = Matrix<kStates>;

// Zhou 2011, eqs. 7-11 in the form of the algorithm that follows them; R = I.
Dense transcription(const Dense& P, const Dense& H, const Dense& L, double gamma) {
    const Dense I = Dense::Identity(kStates, kStates);
    const Dense K =
        P * H.transpose() * inverse(H * P * H.transpose() + Dense::Identity(kMeasurements, kMeasurements));
    const Dense B = L * (I - K * H) * P * L - gamma * gamma * I;
    const Dense M = (I - K * H) * P * L * inverse(B) * L;
    return P - (I - M) * K * H * P - M * P;
}

struct Case {
    explicit Case(RandomCovariance& random)
        : P(random.covariance<kStates>(0.1, 2.0)),
          H(random.normal<kMeasurements, kStates>()),
          R(random.covariance<kMeasurements>(0.1, 2.0)),
          residual(random.normal<kMeasurements, 1>()),
          scale(random.normal<kStates, 1>().cwiseAbs() + Vector<kStates>::Constant(0.2)) {}

    [[nodiscard]] Innovation<kStates, kMeasurements> innovation() const {
        return innovation_of<kStates, kMeasurements>(P, H, R, residual);
    }
    [[nodiscard]] Square standard() const { return Standard().correct(P, innovation()).covariance; }
    // The largest eigenvalue of L P_post L; feasible while it is below gamma^2.
    [[nodiscard]] double largest(const Vector<kStates>& L) const {
        return eigenvalues(standard().cwiseProduct(L * L.transpose()))(kStates - 1);
    }
    [[nodiscard]] Vector<kStates> heading_scale() const {
        return scale(kHeading) * Vector<kStates>::Unit(kHeading);
    }

    Square P;
    Matrix<kMeasurements, kStates> H;
    Matrix<kMeasurements> R;
    Vector<kMeasurements> residual;
    Vector<kStates> scale;
};

class HInfinityCorrector : public testing::TestWithParam<unsigned> {
  protected:
    // The check gets a case and an L, full or of the heading alone.
    template <class Check>
    void for_random_cases(const Check& check) {
        RandomCovariance random(GetParam());
        for (int i = 0; i < 100; ++i) {
            const Case c(random);
            check(c, c.scale);
            check(c, c.heading_scale());
        }
    }
};

TEST_P(HInfinityCorrector, TakesInformationFromTheStandardPosterior) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        const double gamma = std::sqrt(2.0 * c.largest(L));
        const auto correction = HInfinity<kStates>{.gamma = gamma, .scale = L}.correct(c.P, c.innovation());
        Dense information = inverse(c.standard());
        information.diagonal() -= (L / gamma).cwiseAbs2();
        EXPECT_LT(relative_difference(correction.covariance, inverse(information)), 1e-10);
        EXPECT_TRUE(correction.feasible);
        EXPECT_EQ(correction.gamma_effective, gamma);
    });
}

TEST_P(HInfinityCorrector, IsTheAlgorithmOfZhou2011InNoiseNormalisedUnits) {
    for_random_cases([](Case c, const Vector<kStates>& L) {
        c.R.setIdentity();
        const double gamma = std::sqrt(1.5 * c.largest(L));
        const auto correction = HInfinity<kStates>{.gamma = gamma, .scale = L}.correct(c.P, c.innovation());
        EXPECT_LT(relative_difference(correction.covariance,
                                      transcription(c.P, c.H, Square(L.asDiagonal()), gamma)),
                  1e-10);
    });
}

TEST_P(HInfinityCorrector, IsTheRiccatiEquationOfTheKreinSpace) {
    // Zhou 2011, eqs. 2-11 one by one; R = I. Every line of the derivation gives the same gain and
    // covariance.
    for_random_cases([](Case c, const Vector<kStates>& scale) {
        c.R.setIdentity();
        const double gamma = std::sqrt(1.5 * c.largest(scale));
        const Dense I = Dense::Identity(kStates, kStates);
        const Dense L = Square(scale.asDiagonal());
        const Dense P = c.P;
        const Dense H = c.H;
        const Dense HT = H.transpose();

        const Dense A11 = H * P * HT + Dense::Identity(kMeasurements, kMeasurements);
        const Dense A12 = H * P * L;
        const Dense A21 = A12.transpose();
        const Dense A22 = L * P * L - gamma * gamma * I;
        Dense R_e(kMeasurements + kStates, kMeasurements + kStates);  // eq. 3
        R_e << A11, A12, A21, A22;
        Dense HL(kMeasurements + kStates, kStates);
        HL << H, L;
        const Dense K_inf = P * HL.transpose() * inverse(R_e);  // eq. 5
        const Dense posterior = P - K_inf * HL * P;             // eqs. 3, 4
        const Dense K_Y = K_inf.leftCols(kMeasurements);
        const Dense K_Z = K_inf.rightCols(kStates);

        const Dense A11_inverse = inverse(A11);
        const Dense B22 = inverse(A22 - A21 * A11_inverse * A12);  // theorem 1
        const Dense B12 = -(A11_inverse * A12 * B22);
        const Dense B21 = B12.transpose();
        const Dense B11 = A11_inverse - B12 * A21 * A11_inverse;
        EXPECT_LT(relative_difference(P * (HT * B11 + L * B21), K_Y), 1e-10);  // eq. 6
        EXPECT_LT(relative_difference(P * (HT * B12 + L * B22), K_Z), 1e-10);

        const Dense K = P * HT * A11_inverse;
        const Dense eq7 = K + P * (HT * A11_inverse * A12 - L) * B22 * L * K;
        EXPECT_LT(relative_difference(eq7, K_Y), 1e-10);
        const Dense after = (I - K * H) * P * L;
        const Dense inner = inverse(L * after - gamma * gamma * I);
        const Dense eq8 = (I + (K * H - I) * P * L * inner * L) * K;
        EXPECT_LT(relative_difference(eq8, K_Y), 1e-10);
        const Dense M = after * inner * L;
        EXPECT_LT(relative_difference(K - M * K, K_Y), 1e-10);      // eq. 9
        EXPECT_LT(relative_difference(after * inner, K_Z), 1e-10);  // eq. 10 without its last L_k
        const Dense eq11 = P - (I - M) * K * H * P - M * P;
        EXPECT_LT(relative_difference(eq11, posterior), 1e-10);

        const auto found = HInfinity<kStates>{.gamma = gamma, .scale = scale}.correct(P, c.innovation());
        EXPECT_LT(relative_difference(found.covariance, posterior), 1e-9);
    });
}

TEST_P(HInfinityCorrector, CorrectsTheStateAsTheStandardCorrectorDoes) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        const auto correction = HInfinity<kStates>{.gamma = 1.0, .scale = L}.correct(c.P, c.innovation());
        EXPECT_EQ(correction.deviation, Standard().correct(c.P, c.innovation()).deviation);
    });
}

TEST_P(HInfinityCorrector, TendsToTheStandardCorrectorForLargeGamma) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        const auto difference = [&](double gamma) {
            return relative_difference(
                HInfinity<kStates>{.gamma = gamma, .scale = L}.correct(c.P, c.innovation()).covariance,
                c.standard());
        };
        EXPECT_LT(difference(1e8), 1e-13);
        // To first order P_post L^2 P_post / gamma^2: a hundredth for ten times gamma.
        EXPECT_NEAR(difference(1e3) / difference(1e4), 100.0, 0.1);
    });
}

TEST_P(HInfinityCorrector, BacksOffWhereGammaIsInfeasible) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        for (const double share : {0.999, 0.5, 1e-3, 1e-9}) {  // of the limit gamma^2 = largest eigenvalue
            const double gamma = std::sqrt(share * c.largest(L));
            const auto correction =
                HInfinity<kStates>{.gamma = gamma, .scale = L}.correct(c.P, c.innovation());
            EXPECT_FALSE(correction.feasible);
            EXPECT_EQ(correction.gamma_effective, std::numeric_limits<double>::infinity());
            EXPECT_LT(relative_difference(correction.covariance, c.standard()), 1e-12);
        }
    });
}

TEST_P(HInfinityCorrector, BacksOffFromTheDocumentedShareOfTheLimitOn) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        const double border = std::sqrt(c.largest(L) / forgetting::kLargestRatio);
        EXPECT_TRUE((HInfinity<kStates>{.gamma = border * 1.000001, .scale = L}
                         .correct(c.P, c.innovation())
                         .feasible));
        EXPECT_FALSE((HInfinity<kStates>{.gamma = border * 0.999999, .scale = L}
                          .correct(c.P, c.innovation())
                          .feasible));
    });
}

// Eigenvalues of a covariance in units of sigma, ascending.
Vector<kStates> eigenvalues_in(const Vector<kStates>& sigma, const Square& P) {
    const Vector<kStates> inverse = sigma.cwiseInverse();
    return eigenvalues(P.cwiseProduct(inverse * inverse.transpose()));
}

TEST_P(HInfinityCorrector, BelowItsCeilingIsTheExactUpdate) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        const Vector<kStates> sigma = c.scale.cwiseInverse();
        const double gamma = std::sqrt(2.0 * c.largest(L));
        const HInfinity<kStates> free{.gamma = gamma, .scale = L};
        const HInfinity<kStates> bounded{
            .gamma = gamma, .scale = L, .ceiling = {{.sigma = sigma, .limit = 1e6}}};
        EXPECT_LT(relative_difference(bounded.correct(c.P, c.innovation()).covariance,
                                      free.correct(c.P, c.innovation()).covariance),
                  1e-10);
    });
}

TEST_P(HInfinityCorrector, ClipsTheEigenvaluesInUnitsOfSigmaAtTheCeiling) {
    // With every state protected alike the axes stay, and clipping is exact.
    RandomCovariance random(GetParam());
    for (int i = 0; i < 100; ++i) {
        const Case c(random);
        const Vector<kStates> sigma = c.scale.cwiseInverse();
        const Vector<kStates> standard = eigenvalues_in(sigma, c.standard());
        for (const double gamma : {0.05, 0.3, 1.0, 2.0}) {
            const double limit = 1.5 * standard(kStates - 1);
            const HInfinity<kStates> corrector{
                .gamma = gamma, .scale = c.scale, .ceiling = {{.sigma = sigma, .limit = limit}}};
            const auto correction = corrector.correct(c.P, c.innovation());
            EXPECT_TRUE(correction.feasible);
            EXPECT_EQ(correction.covariance, correction.covariance.transpose());
            const Vector<kStates> found = eigenvalues_in(sigma, correction.covariance);
            for (int k = 0; k < kStates; ++k) {
                // What is not positive has lost all its information.
                const double left = 1.0 / standard(k) - 1.0 / (gamma * gamma);
                EXPECT_NEAR(found(k), left * limit > 1.0 ? 1.0 / left : limit, 1e-10 * limit);
            }
        }
    }
}

TEST_P(HInfinityCorrector, WithACeilingIsNeverBelowTheStandardPosterior) {
    for_random_cases([](const Case& c, const Vector<kStates>& L) {
        const Vector<kStates> sigma = c.scale.cwiseInverse();
        for (const double gamma : {0.05, 0.3, 1.0, 2.0}) {
            for (const double limit : {0.2, 1.0, 5.0}) {
                const HInfinity<kStates> corrector{
                    .gamma = gamma, .scale = L, .ceiling = {{.sigma = sigma, .limit = limit}}};
                const Square posterior = corrector.correct(c.P, c.innovation()).covariance;
                EXPECT_GT(smallest_eigenvalue(posterior - c.standard()), -1e-10) << gamma << " " << limit;
            }
        }
    });
}

INSTANTIATE_TEST_SUITE_P(Seeds, HInfinityCorrector, testing::Values(17U, 1717U));

TEST(HInfinityCorrectorByHand, InflatesAScalar) {
    // Posterior variance 0.8; 1 / (1 / 0.8 - 1 / 4) = 1.
    const auto innovation =
        innovation_of<1, 1>(Matrix<1>(4.0), Matrix<1>(1.0), Matrix<1>(1.0), Vector<1>(10.0));
    const auto correction = HInfinity<1>{.gamma = 2.0}.correct(Matrix<1>(4.0), innovation);
    EXPECT_NEAR(correction.covariance(0), 1.0, 1e-14);
    EXPECT_NEAR(correction.deviation(0), 8.0, 1e-14);
}

TEST(HInfinityCorrectorByHand, LeavesStatesWithoutScaleAndCorrelationAlone) {
    const Matrix<2> P = Eigen::Vector2d(1.0, 3.0).asDiagonal();
    const auto innovation = innovation_of<2, 1>(P, Matrix<1, 2>(1.0, 0.0), Matrix<1>(1.0), Vector<1>(0.0));
    const auto correction = HInfinity<2>{.gamma = 1.0, .scale = {1.0, 0.0}}.correct(P, innovation);
    EXPECT_NEAR(correction.covariance(0, 0), 1.0, 1e-14);  // 1 / (1 / 0.5 - 1)
    EXPECT_EQ(correction.covariance(1, 1), 3.0);
}

}  // namespace
}  // namespace truenorth
