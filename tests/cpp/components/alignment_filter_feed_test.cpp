// Ports of which not everything is connected.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "components/alignment_filter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using FedFilter = Fed<AlignmentFilter>;
using Trial = Session<AlignmentFilter>;
using Status = alignment_filter::Status;

constexpr double kSeconds = 30.0;

// Leaves things out of what the filter is fed; `change` sees the ports before every step. In the first one
// nothing has been put out.
void run(FedFilter& fed, const std::function<void(FedFilter&)>& change) {
    Trial trial;
    trial.fix_noise = [](int second) {
        return Eigen::Vector3d(0.02 * std::sin(second), 0.02 * std::cos(second), 0.0);
    };
    trial.start(fed);
    FedFilter source;
    trial.start(source);
    fed.step();
    for (int k = 1; k <= static_cast<int>(kSeconds * kRate); ++k) {
        trial.advance(source, k - 1, k);
        fed.filter.inputs = source.filter.inputs;
        fed.next = source.clock;
        change(fed);
        fed.step();
    }
}

std::string whole() {
    FedFilter fed;
    run(fed, [](FedFilter&) {});
    EXPECT_EQ(fed.log.with("counts as a new measurement"), 0);
    return estimate(fed);
}

TEST(AlignmentFilterFeed, WithoutCountsIsToldByTheStamps) {
    FedFilter fed;
    run(fed, [](FedFilter& f) {
        f.filter.inputs.imu.sample = 0;
        f.filter.inputs.gnss.sample = 0;
    });
    EXPECT_TRUE(estimate(fed) == whole());
    EXPECT_EQ(fed.log.with("imu.sample stays 0: a new imu.time counts as a new measurement"), 1);
    EXPECT_EQ(fed.log.with("gnss.sample stays 0: a new gnss.time counts as a new measurement"), 1);
}

TEST(AlignmentFilterFeed, WithoutCountsAndStampsWaitsAndSaysSo) {
    FedFilter fed;
    run(fed, [](FedFilter& f) {
        f.filter.inputs.imu.sample = 0;
        f.filter.inputs.imu.time = 0.0;
        f.filter.inputs.gnss.sample = 0;
        f.filter.inputs.gnss.time = 0.0;
    });
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    EXPECT_EQ(fed.log.with("neither imu.sample nor imu.time has changed for 1 s"), 1);
    EXPECT_EQ(fed.log.with("gnss.sample has not changed for 10 s: no fix has come"), 1);
    EXPECT_EQ(fed.log.lines.size(), 2U);
}

// The step is the interval; the increments of a row are those until its time, as a Jacobi master passes them.
TEST(AlignmentFilterFeed, OfEachStepIsThatOfStampsAtItsBegin) {
    std::string results[2];
    for (const bool each_step : {false, true}) {
        FedFilter fed;
        fed.filter.parameters.imu.each_step = each_step;
        run(fed, [each_step](FedFilter& f) {
            // What lies there at the start is no sample.
            f.filter.inputs.imu.sample = each_step ? 0 : f.filter.inputs.imu.sample - 1;
            f.filter.inputs.imu.time = each_step ? 0.0 : f.clock;
        });
        EXPECT_EQ(fed.log.with("imu.sample"), 0);
        EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
        results[each_step ? 1 : 0] = estimate(fed);
    }
    EXPECT_TRUE(results[0] == results[1]);
}

TEST(AlignmentFilterFeed, OfEachStepPassesOverCountAndStamp) {
    FedFilter fed;
    fed.filter.parameters.imu.each_step = true;
    run(fed, [](FedFilter& f) {
        f.filter.inputs.imu.sample = 3;
        f.filter.inputs.imu.time = kNaN;
    });
    EXPECT_EQ(fed.filter.outputs.rejected_samples, 0);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
}

// What lies at the ports at the start may be a measurement or not.
TEST(AlignmentFilterFeed, OfTheFirstStampIsNoMeasurement) {
    FedFilter fed;
    const Trial trial;
    trial.start(fed);
    trial.advance(fed, 0, 1);
    FedFilter twice;
    trial.start(twice);
    twice.filter.inputs = fed.filter.inputs;
    twice.filter.inputs.imu.sample = 0;
    twice.next = fed.clock;
    twice.step();
    EXPECT_EQ(fed.filter.outputs.nav.time, fed.clock);
    EXPECT_EQ(twice.filter.outputs.nav.time, 0.0);
    EXPECT_EQ(twice.filter.outputs.rejected_samples, 0);
}

// Of which nobody knows more than that its count, beside one that goes on, stays where it is.
TEST(AlignmentFilterFeed, OfACountThatStaysAtZeroBesideThatOfTheImuIsNoMeasurement) {
    FedFilter fed;
    fed.filter.parameters.measurement.heading_aid_sigma = 0.5 * kDegree;
    run(fed, [](FedFilter& f) {
        f.filter.inputs.gnss = {};
        f.filter.inputs.gnss.time = f.next;
        f.filter.inputs.gnss.velocity.setConstant(0.001 * f.next);
        f.filter.inputs.heading_aid = {};
        f.filter.inputs.heading_aid.time = f.next;
        f.filter.inputs.heading_aid.heading = 1e-3 * f.next;
    });
    EXPECT_EQ(fed.filter.outputs.used_fixes, 0);
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 0);
    EXPECT_EQ(fed.filter.outputs.aid.heading_aid.used, 0);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    EXPECT_EQ(fed.log.with("gnss.sample has not changed for 10 s: no fix has come"), 1);
    EXPECT_EQ(fed.log.lines.size(), 1U);
}

TEST(AlignmentFilterFeed, WithoutCountsTakesNothingThatIsHeld) {
    FedFilter fed;
    run(fed, [](FedFilter& f) {
        f.filter.inputs.imu.sample = 0;
        f.filter.inputs.gnss.sample = 0;
        f.filter.inputs.gnss.time = f.next;
        f.filter.inputs.gnss.velocity.setZero();
    });
    EXPECT_EQ(fed.filter.outputs.used_fixes, 1);  // the place, when it comes first
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 0);
}

TEST(AlignmentFilterFeed, OfAnAidWithoutACountIsTaken) {
    const auto used = [](bool counted) {
        FedFilter fed;
        fed.filter.parameters.measurement.heading_aid_sigma = 0.5 * kDegree;
        std::decay_t<decltype(fed.filter.inputs.heading_aid)> aid;
        run(fed, [&aid, counted](FedFilter& f) {
            if (f.next > aid.time + 0.999) {
                aid.time = f.next;
                aid.heading = 0.7 + 1e-4 * f.next;
                aid.sample += counted ? 1 : 0;
            }
            f.filter.inputs.heading_aid = aid;
            f.filter.inputs.imu.sample *= counted ? 1 : 0;
        });
        EXPECT_EQ(fed.log.with("heading_aid.sample stays 0"), counted ? 0 : 1);
        return fed.filter.outputs.aid.heading_aid.used;
    };
    EXPECT_GT(used(true), 20);
    EXPECT_EQ(used(false), used(true));
}

}  // namespace
}  // namespace truenorth
