#include "plant/earth_fixed.hpp"

#include <gtest/gtest.h>

#include "plant/motions.hpp"

namespace truenorth::plant {
namespace {

constexpr earth::Position kChina{
    .latitude = 38.03 * kDegree, .longitude = 114.26 * kDegree, .height = 1234.5};
constexpr earth::Position kPatagonia{
    .latitude = -52.7 * kDegree, .longitude = -71.2 * kDegree, .height = -30.0};

// pymap3d 3.2, geodetic2ecef and enu2uvw.
TEST(EarthFixed, AgreesWithPymap3d) {
    EXPECT_LT(
        (earth_fixed(kChina) - Eigen::Vector3d(-2067271.3063505825, 4587034.080673561, 3908827.974156243))
            .norm(),
        1e-8);
    EXPECT_LT((earth_fixed(kPatagonia) -
               Eigen::Vector3d(1248222.4686492707, -3666629.411366361, -5050358.315221021))
                  .norm(),
              1e-8);
    EXPECT_LT((C_ne(kChina) * Eigen::Vector3d(1.0, 2.0, 3.0) -
               Eigen::Vector3d(-1.3763591848666914, 0.6201680163235264, 3.4235985491529872))
                  .norm(),
              1e-14);
}

// One metre east, north and up is one metre along the axes of n. The step leaves 1e-7 of curvature and 1e-8
// of rounding.
TEST(EarthFixed, TheAxesAreThoseAlongWhichAPositionMoves) {
    for (const earth::Position& position : {kChina, kPatagonia}) {
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d step = Eigen::Vector3d::Unit(axis);
            const Eigen::Vector3d moved = earth_fixed(earth::displaced(position, 0.5 * step)) -
                                          earth_fixed(earth::displaced(position, -0.5 * step));
            EXPECT_LT((moved - C_ne(position) * step).norm(), 2e-7);
        }
    }
}

}  // namespace
}  // namespace truenorth::plant
