#include "components/gnss_input.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace truenorth {
namespace {

using Verdict = GnssInput::Verdict;

GnssFix fix_at(double time) {
    return {.time = time,
            .position = {.latitude = 0.5, .longitude = 2.0, .height = 100.0},
            .velocity = {1.0, 2.0, 0.0}};
}

TEST(GnssInput, AcceptsAPlausibleFixOnce) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(0, fix_at(0.0), 10.0), Verdict::stale);
    EXPECT_EQ(gnss.read(1, fix_at(9.0), 10.0), Verdict::accepted);
    EXPECT_EQ(gnss.read(1, fix_at(9.0), 10.0), Verdict::stale);
    EXPECT_EQ(gnss.read(2, fix_at(10.0), 10.0), Verdict::accepted);
}

TEST(GnssInput, RejectsEveryValueThatIsNotFinite) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        for (int field = 0; field < 7; ++field) {
            GnssFix fix = fix_at(1.0);
            double* const fields[] = {
                &fix.time,         &fix.position.latitude, &fix.position.longitude, &fix.position.height,
                &fix.velocity.x(), &fix.velocity.y(),      &fix.velocity.z(),
            };
            *fields[field] = bad;
            GnssInput gnss;
            EXPECT_EQ(gnss.read(1, fix, 10.0), Verdict::not_finite) << field;
        }
    }
}

TEST(GnssInput, RejectsPlacesAndSpeedsThatAreImpossible) {
    const auto verdict = [](double latitude, double longitude, double height, double speed) {
        GnssInput gnss;
        return gnss.read(1,
                         {.time = 1.0,
                          .position = {.latitude = latitude, .longitude = longitude, .height = height},
                          .velocity = {speed, 0.0, 0.0}},
                         10.0);
    };
    EXPECT_EQ(verdict(1.5708, 0.0, 0.0, 0.0), Verdict::impossible);  // the pole
    EXPECT_EQ(verdict(-2.0, 0.0, 0.0, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, 7.0, 0.0, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, -118.0, 0.0, 0.0), Verdict::impossible);  // degrees
    EXPECT_EQ(verdict(0.0, 0.0, -16e3, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, 0.0, 101e3, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, 0.0, 0.0, 10001.0), Verdict::impossible);
    EXPECT_EQ(verdict(-1.5, 6.2, 12e3, 900.0), Verdict::accepted);
}

TEST(GnssInput, RejectsTimeThatDoesNotAdvance) {
    GnssInput gnss;
    gnss.read(1, fix_at(5.0), 10.0);
    EXPECT_EQ(gnss.read(2, fix_at(5.0), 10.0), Verdict::backwards);
    EXPECT_EQ(gnss.read(3, fix_at(4.0), 10.0), Verdict::backwards);
    EXPECT_EQ(gnss.read(4, fix_at(5.1), 10.0), Verdict::accepted);
}

TEST(GnssInput, RejectsAFixFromTheFuture) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, fix_at(10.01), 10.0), Verdict::future);
    EXPECT_EQ(gnss.read(2, fix_at(10.0 + 1e-9), 10.0), Verdict::accepted);  // the clocks' rounding
}

TEST(GnssInput, ARejectedFixDoesNotHoldBackTheNext) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, fix_at(1e6), 10.0), Verdict::future);
    EXPECT_EQ(gnss.read(2, fix_at(9.0), 10.0), Verdict::accepted);
}

TEST(GnssInput, StartForgetsEverything) {
    GnssInput gnss;
    gnss.read(1, fix_at(5.0), 10.0);
    gnss.start();
    EXPECT_EQ(gnss.read(1, fix_at(1.0), 10.0), Verdict::accepted);
}

}  // namespace
}  // namespace truenorth
