#include "fmi/instance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <string>

#include "components/invalid_parameter.hpp"
#include "fmi/refusal.hpp"
#include "stand_in.hpp"

namespace truenorth::test {
namespace {

using fmi::Instance;
using fmi::Journal;
using fmi::Kind;
using fmi::Refusal;
using fmi::State;

class InstanceTest : public testing::Test {
  protected:
    explicit InstanceTest(Kind kind = Kind::co_simulation)
        : instance(stand_in(), kind, [](Journal::Severity, const char*, const char*) {}, false) {}

    Instance instance;

    void set(unsigned reference, double value) {
        instance.set<double>(std::array{reference}, std::span<const double>(&value, 1));
    }

    double get(unsigned reference) {
        double value = 0.0;
        instance.get<double>(std::array{reference}, std::span(&value, 1));
        return value;
    }

    void start() {
        instance.set_up_experiment(0.0, std::nullopt);
        instance.enter_initialisation();
        instance.exit_initialisation();
    }
};

TEST_F(InstanceTest, StepsAccumulate) {
    start();
    set(input, 3.0);
    instance.step(0.0, 0.5);
    instance.step(0.5, 0.5);
    EXPECT_EQ(get(output), 1.0 + 2.0 * 3.0 + 2.0 * 3.0);
    EXPECT_EQ(instance.time(), 1.0);
}

TEST_F(InstanceTest, AStepThatCannotBeMadeChangesNothing) {
    start();
    set(input, -1.0);
    EXPECT_THROW(instance.step(0.0, 1.0), std::invalid_argument);
    EXPECT_EQ(instance.time(), 0.0);
    set(input, 1.0);
    EXPECT_NO_THROW(instance.step(0.0, 1.0));
}

TEST_F(InstanceTest, AStepThatBreaksDownEndsTheRunUntilAStateOrAResetLeadsBack) {
    start();
    State* const before = instance.save(nullptr);
    set(input, 101.0);
    EXPECT_THROW(instance.step(0.0, 1.0), std::runtime_error);
    EXPECT_THROW(instance.step(0.0, 1.0), Refusal);
    EXPECT_THROW(set(input, 1.0), Refusal);
    EXPECT_NO_THROW(get(output));

    State* const broken = instance.save(nullptr);
    instance.restore(before);
    EXPECT_EQ(get(output), 1.0);
    EXPECT_NO_THROW(instance.step(0.0, 1.0));

    instance.restore(broken);
    EXPECT_THROW(instance.step(0.0, 1.0), Refusal);
    instance.reset();
    EXPECT_NO_THROW(start());
}

TEST_F(InstanceTest, ARefusedTunableKeepsTheOldValue) {
    start();
    EXPECT_THROW(set(tunable, -1.0), InvalidParameter);
    EXPECT_EQ(get(tunable), 2.0);
    set(tunable, 5.0);
    EXPECT_EQ(get(tunable), 5.0);
}

TEST_F(InstanceTest, InitialisesAgainWhenAParameterChangesInInitialisationMode) {
    instance.set_up_experiment(0.0, std::nullopt);
    instance.enter_initialisation();
    EXPECT_EQ(get(output), 1.0);
    set(fixed, 4.0);
    EXPECT_EQ(get(output), 4.0);
    set(fixed, -4.0);
    EXPECT_THROW(get(output), InvalidParameter);
    EXPECT_EQ(get(fixed), -4.0);
    EXPECT_THROW(instance.exit_initialisation(), InvalidParameter);
    set(fixed, 4.0);
    EXPECT_NO_THROW(instance.exit_initialisation());
}

TEST_F(InstanceTest, AFailedRestoreLeavesTheInstanceAsItWas) {
    start();
    set(input, 1.0);
    instance.step(0.0, 1.0);
    EXPECT_THROW(instance.restore(nullptr), Refusal);
    EXPECT_THROW(static_cast<void>(instance.import_state({})), Refusal);
    EXPECT_EQ(get(output), 3.0);
    EXPECT_NO_THROW(instance.step(1.0, 1.0));
}

class ExchangedTest : public InstanceTest {
  protected:
    ExchangedTest() : InstanceTest(Kind::model_exchange) { start(); }

    void event_at(double time) {
        instance.enter_continuous();
        instance.set_time(time);
        instance.enter_event();
        instance.update_discrete_states();
    }
};

TEST_F(ExchangedTest, StepsOnceInEachPeriod) {
    set(input, 3.0);
    EXPECT_EQ(instance.next_event(), 0.5);
    instance.update_discrete_states();  // the input is new, at the start
    EXPECT_EQ(get(output), 1.0 + 2.0 * 3.0);
    event_at(0.3);  // an event of another FMU
    EXPECT_EQ(get(output), 1.0 + 2.0 * 3.0);
    event_at(0.5);
    EXPECT_EQ(get(output), 1.0 + 2.0 * 3.0 + 2.0 * 3.0);
    EXPECT_EQ(instance.next_event(), 1.0);
}

TEST_F(ExchangedTest, LooksAgainAtInputsThatChangeInTheSameEvent) {
    event_at(0.5);
    const double before = get(output);
    set(input, 4.0);
    instance.update_discrete_states();
    EXPECT_EQ(get(output), before + 2.0 * 4.0);
    instance.update_discrete_states();
    EXPECT_EQ(get(output), before + 2.0 * 4.0);
}

TEST_F(ExchangedTest, RefusesWhatItsPhaseDoesNotAllow) {
    EXPECT_THROW(instance.step(0.0, 0.5), Refusal);
    EXPECT_THROW(instance.enter_event(), Refusal);
    instance.enter_continuous();
    EXPECT_THROW(instance.update_discrete_states(), Refusal);
    EXPECT_THROW(set(input, 1.0), Refusal);
    EXPECT_THROW(instance.require_none(1), Refusal);
    EXPECT_NO_THROW(instance.require_none(0));
    instance.set_time(0.7);
    EXPECT_TRUE(instance.completed_integrator_step());
    instance.enter_event();
    EXPECT_THROW(instance.update_discrete_states(), Refusal);  // the event at 0.5 was missed
}

}  // namespace
}  // namespace truenorth::test
