#include "estimation/gaussian_sum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

// A direction that stays what it is, and of which a sensor with an unknown constant error tells two
// components: what gyros at rest tell of the heading.
struct Direction {
    static constexpr int kStates = 3;
    static constexpr int kMeasurements = 2;
    using State = Vector<3>;  // direction [rad], errors of the components
    struct Interval {};
    struct Fix {
        Eigen::Vector2d value;
    };
    static constexpr double kSigma = 0.02;

    [[nodiscard]] static State retract(const State& x, const State& d) { return x + d; }
    [[nodiscard]] static State local(const State& x, const State& other) {
        State d = other - x;
        d(0) = std::remainder(d(0), 2.0 * std::numbers::pi);
        return d;
    }
    [[nodiscard]] static State moved(const State& x, const Interval& /*interval*/) { return x; }
    template <int Count>
    void propagate(State& /*x*/, Points<3, Count>& /*deviations*/, const Interval& /*interval*/) const {}
    [[nodiscard]] static Matrix<3> transition(const State& /*x*/, const Interval& /*interval*/) {
        return Matrix<3>::Identity();
    }
    [[nodiscard]] static Matrix<3> process_noise(const State& /*x*/, const Interval& /*interval*/) {
        return Matrix<3>::Zero();
    }
    [[nodiscard]] static Eigen::Vector2d of(double direction) {
        return {std::cos(direction), std::sin(direction)};
    }
    [[nodiscard]] static Eigen::Vector2d residual(const State& x, const Fix& fix) {
        return fix.value - of(x(0)) - x.tail<2>();
    }
    [[nodiscard]] static Matrix<2, 3> measurement_matrix(const State& x, const Fix& /*fix*/) {
        Matrix<2, 3> H;
        H << -std::sin(x(0)), 1.0, 0.0, std::cos(x(0)), 0.0, 1.0;
        return H;
    }
    [[nodiscard]] static Eigen::Matrix2d measurement_noise(const State& /*x*/, const Fix& /*fix*/) {
        return kSigma * kSigma * Eigen::Matrix2d::Identity();
    }
};

constexpr int kMembers = 18;
constexpr double kApart = 2.0 * std::numbers::pi / kMembers;

GaussianSum<Direction> bank_of_directions(double sensor_sigma) {
    GaussianSum<Direction> bank;
    bank.reserve();
    for (int k = 0; k < kMembers; ++k) {
        const Vector<3> sigma(0.5 * kApart, sensor_sigma, sensor_sigma);
        bank.add({.state = {k * kApart, 0.0, 0.0}, .covariance = sigma.cwiseAbs2().asDiagonal()});
    }
    return bank;
}

constexpr InnovationGate kOpen{{.enabled = false}};

// Of the constant errors of the sensor.
auto log_prior(double sigma) {
    return [sigma](const Vector<3>& x) { return -0.5 * x.tail<2>().squaredNorm() / (sigma * sigma); };
}

bool take(GaussianSum<Direction>& bank, const Eigen::Vector2d& value, double sensor_sigma,
          const InnovationGate& gate = kOpen, bool evident = true) {
    return bank.correct(Direction(), {value}, gate, log_prior(sensor_sigma), evident);
}

// The direction is known as well as the constant errors of the sensor allow, and no better however long it
// is measured: by numbers, the posterior is proportional to exp(-|z - u(direction)|^2 / (2 sigma^2)). All of
// it is what the constants have moved; there is no other evidence.
class Posterior : public testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(Posterior, IsWhatTheMomentsAreOf) {
    const auto [sensor_sigma, evident] = GetParam();
    RandomCovariance random(7);
    const Eigen::Vector2d mean = Direction::of(1.0) + sensor_sigma * Eigen::Vector2d(0.6, -0.9);
    auto bank = bank_of_directions(sensor_sigma);
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    constexpr int kFixes = 2000;
    for (int i = 0; i < kFixes; ++i) {
        const Eigen::Vector2d value = mean + Direction::kSigma * random.normal<2, 1>();
        bank.predict(Direction(), {});
        ASSERT_TRUE(take(bank, value, sensor_sigma, kOpen, evident));
        sum += value;
    }
    const auto found = bank.moments();

    const double variance = sensor_sigma * sensor_sigma + Direction::kSigma * Direction::kSigma / kFixes;
    double total = 0.0;
    double square = 0.0;
    constexpr int kGrid = 3600;
    for (int i = 0; i < kGrid; ++i) {
        const double away = std::remainder(i * 2.0 * std::numbers::pi / kGrid, 2.0 * std::numbers::pi);
        const Eigen::Vector2d off = sum / kFixes - Direction::of(found.state(0) + away);
        const double density = std::exp(-0.5 * off.squaredNorm() / variance);
        total += density;
        square += density * away * away;
    }
    const double sigma = std::sqrt(square / total);
    EXPECT_NEAR(std::sqrt(found.covariance(0, 0)), sigma, 0.1 * sigma);
}

INSTANTIATE_TEST_SUITE_P(GaussianSum, Posterior,
                         testing::Values(std::tuple{0.2, true}, std::tuple{0.5, true}, std::tuple{0.5, false},
                                         std::tuple{1.0, true}, std::tuple{1.0, false}));

// A single filter of the same prior believes the motion of its own estimate.
TEST(GaussianSum, OneWideFilterIsSurer) {
    RandomCovariance random(7);
    const Eigen::Vector2d mean = Direction::of(1.0) + Eigen::Vector2d(0.6, -0.9);
    GaussianSum<Direction> bank;
    bank.add({.state = {3.0, 0.0, 0.0}, .covariance = Vector<3>(3.3, 1.0, 1.0).asDiagonal()});
    for (int i = 0; i < 2000; ++i) {
        take(bank, mean + Direction::kSigma * random.normal<2, 1>(), 1.0);
    }
    EXPECT_LT(std::sqrt(bank.moments().covariance(0, 0)), 0.5);
}

TEST(GaussianSum, ForgetsWhatIsOutOfTheQuestion) {
    auto bank = bank_of_directions(0.02);
    for (int i = 0; i < 100; ++i) {
        take(bank, Direction::of(1.0), 0.02);
    }
    EXPECT_LT(bank.members().size(), 6U);
    EXPECT_NEAR(bank.moments().state(0), 1.0, 0.03);
}

TEST(GaussianSum, RefusesWhatNoMemberForetold) {
    auto bank = bank_of_directions(0.2);
    for (int i = 0; i < 10; ++i) {
        take(bank, Direction::of(1.0), 0.2, {});
    }
    const auto before = bank.moments();
    EXPECT_FALSE(take(bank, {30.0, 30.0}, 0.2, {}));
    EXPECT_EQ(bank.moments().state, before.state);
    EXPECT_TRUE(take(bank, Direction::of(1.0), 0.2, {}));
}

// Of members that stand a full circle around, the mean is sought from the one of the most weight.
TEST(GaussianSum, KnowsNothingBeforeItIsTold) {
    auto bank = bank_of_directions(1.0);
    const double uniform = std::numbers::pi / std::numbers::sqrt3;
    EXPECT_NEAR(std::sqrt(bank.moments().covariance(0, 0)), uniform, 0.02 * uniform);
}

}  // namespace
}  // namespace truenorth
