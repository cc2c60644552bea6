#include "estimation/chi_square.hpp"

#include <gtest/gtest.h>

namespace truenorth {
namespace {

TEST(ChiSquare, HasTheQuantilesOfTheTables) {
    // scipy.stats.chi2.isf(scipy.stats.norm.sf(deviate), degrees)
    struct Quantile {
        double deviate;
        int degrees;
        double chi_square;
        double relative;  // the approximation is the better the more degrees there are
    };
    for (const auto& [deviate, degrees, chi_square, relative] : {
             Quantile{4.0, 2, 20.7202, 0.07},
             Quantile{3.0, 6, 21.7392, 0.01},
             Quantile{4.0, 12, 42.1298, 0.015},
             Quantile{-2.0, 40, 24.1776, 0.001},
             Quantile{4.0, 120, 192.1929, 0.001},
             Quantile{4.0, 1200, 1406.0374, 0.001},
         }) {
        EXPECT_NEAR(chi_square_beyond(deviate, degrees), chi_square, relative * chi_square) << degrees;
    }
}

TEST(ChiSquare, ComesBackFromTheNormalDeviate) {
    for (const double deviate : {-3.0, 0.0, 1.5, 6.0}) {
        for (const int degrees : {1, 2, 30, 600}) {
            EXPECT_NEAR(normal_deviate(chi_square_beyond(deviate, degrees), degrees), deviate, 1e-12);
        }
    }
}

}  // namespace
}  // namespace truenorth
