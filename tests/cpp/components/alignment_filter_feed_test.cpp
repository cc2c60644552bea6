// Ports of which not everything is connected.
#include <gtest/gtest.h>

#include <functional>

#include "components/alignment_filter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using FedFilter = Fed<AlignmentFilter>;
using Trial = Session<AlignmentFilter>;
using Status = alignment_filter::Status;

constexpr double kSeconds = 30.0;
const std::string kNothing = "stand still at 0: nothing is taken";

// Leaves things out of what the filter is fed; `change` sees the ports before every step.
void run(FedFilter& fed, const std::function<void(FedFilter&)>& change) {
    const Trial trial;
    trial.start(fed);
    FedFilter source;
    trial.start(source);
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
    EXPECT_EQ(fed.log.with("stand"), 0);
    return estimate(fed);
}

TEST(AlignmentFilterFeed, WithoutCountsIsToldByTheStamps) {
    FedFilter fed;
    run(fed, [](FedFilter& f) {
        f.filter.inputs.imu.sample = 0;
        f.filter.inputs.gnss.sample = 0;
    });
    EXPECT_EQ(estimate(fed), whole());
    EXPECT_EQ(fed.log.with("imu.sample stands still at 0: every new imu.time is taken"), 1);
    EXPECT_EQ(fed.log.with("gnss.sample stands still at 0: every new gnss.time is taken"), 1);
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
    EXPECT_EQ(fed.log.with("imu.sample and imu.time " + kNothing), 1);
    EXPECT_EQ(fed.log.with("imu.each_step"), 1);
    EXPECT_EQ(fed.log.with("gnss.sample and gnss.time " + kNothing), 1);
}

// The step is the interval; the increments of a row are those until its time, as a Jacobi master passes them.
TEST(AlignmentFilterFeed, OfEachStepIsThatOfStampsAtItsBegin) {
    std::string results[2];
    for (const bool each_step : {false, true}) {
        FedFilter fed;
        fed.filter.parameters.imu.each_step = each_step;
        run(fed, [each_step](FedFilter& f) {
            f.filter.inputs.imu.sample = each_step ? 0 : f.filter.inputs.imu.sample;
            f.filter.inputs.imu.time = each_step ? 0.0 : f.clock;
        });
        EXPECT_EQ(fed.log.with("imu.sample"), 0);
        EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
        results[each_step ? 1 : 0] = estimate(fed);
    }
    EXPECT_EQ(results[0], results[1]);
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

TEST(AlignmentFilterFeed, OfNothingAtAllIsToldOnce) {
    FedFilter fed;
    run(fed, [](FedFilter& f) { f.filter.inputs = {}; });
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    EXPECT_EQ(fed.log.with("no IMU data for 1 s"), 1);
    EXPECT_EQ(fed.log.lines.size(), 1U);
}

TEST(AlignmentFilterFeed, OfAnAidWithoutACountIsTaken) {
    const auto used = [](int sample) {
        FedFilter fed;
        fed.filter.parameters.measurement.heading_aid_sigma = 0.5 * kDegree;
        std::decay_t<decltype(fed.filter.inputs.heading_aid)> aid;
        run(fed, [&aid, sample](FedFilter& f) {
            if (f.next > aid.time + 0.999) {
                aid.time = f.next;
                aid.heading = 0.7;
                aid.sample += sample;
            }
            f.filter.inputs.heading_aid = aid;
        });
        EXPECT_EQ(fed.log.with("heading_aid.sample stands still"), sample == 0 ? 1 : 0);
        return fed.filter.outputs.aid.heading_aid.used;
    };
    EXPECT_GT(used(1), 20);
    EXPECT_EQ(used(0), used(1));
}

}  // namespace
}  // namespace truenorth
