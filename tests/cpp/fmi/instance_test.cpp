#include "fmi/instance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cereal/types/string.hpp>
#include <cstring>
#include <limits>
#include <span>
#include <string>

#include "contract/invalid_parameter.hpp"
#include "fmi/archive.hpp"
#include "fmi/refusal.hpp"
#include "fmi/snapshot.hpp"
#include "stand_in.hpp"

namespace truenorth::test {
namespace {

using fmi::Instance;
using fmi::Journal;
using fmi::Kind;
using fmi::Reach;
using fmi::Refusal;
using fmi::State;

class InstanceTest : public testing::Test {
  protected:
    explicit InstanceTest(Kind kind = Kind::co_simulation)
        : instance(
              stand_in(), {.fmi_version = 2, .kind = kind},
              [](Journal::Severity, const char*, const char*) {}, false) {}

    Instance instance;

    void set(unsigned reference, double value) {
        instance.set<double>(std::array{reference}, Reach::scalar, std::span<const double>(&value, 1));
    }

    double get(unsigned reference) {
        double value = 0.0;
        instance.get<double>(std::array{reference}, Reach::scalar, std::span(&value, 1));
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

    // Inputs that were set with it are as they were before.
    set(input, 3.0);
    const std::array<unsigned, 2> both{input, tunable};
    const std::array<double, 2> values{4.0, -1.0};
    EXPECT_THROW((instance.set<double, double>(both, fmi::Reach::scalar, values)), InvalidParameter);
    EXPECT_EQ(get(input), 3.0);
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

// What a variable is, by the functions of FMI 2 and of FMI 3.
class AccessTest : public InstanceTest {
  protected:
    AccessTest() { start(); }

    template <class T, class External, std::size_t N = 1>
    std::string refusal(unsigned reference, Reach reach) {
        std::array<External, N> values{};
        try {
            instance.get<T>(std::array{reference}, reach, std::span<External>(values));
            instance.set<T>(std::array{reference}, reach, std::span<const External>(values));
        } catch (const Refusal& reason) {
            return reason.what();
        }
        return "nothing";
    }
};

TEST_F(AccessTest, AnArrayHasOneReferenceInFmi3AndEachElementOneInFmi2) {
    EXPECT_EQ((refusal<double, double, 2>(array, Reach::variable)), "nothing");
    EXPECT_EQ((refusal<double, double>(array, Reach::scalar)), "nothing");
    EXPECT_EQ((refusal<double, double>(array + 1, Reach::scalar)), "nothing");
    const std::string none =
        "the value reference 5 is that of no variable, but of array[2], an element of an array";
    EXPECT_EQ((refusal<double, double>(array + 1, Reach::variable)), none);
    EXPECT_EQ((refusal<double, double, 0>(array + 1, Reach::variable)), none);
    EXPECT_NE((refusal<bool, bool>(booleans + 1, Reach::variable)).find("is that of no variable"),
              std::string::npos);
}

TEST_F(AccessTest, AnEnumerationIsAnIntegerInFmi2Alone) {
    EXPECT_EQ((refusal<int, int>(integer, Reach::scalar)), "nothing");
    EXPECT_EQ((refusal<int, int>(enumeration, Reach::scalar)), "nothing");
    EXPECT_EQ((refusal<int, int>(integer, Reach::variable)), "nothing");
    EXPECT_EQ((refusal<int, std::int64_t>(enumeration, Reach::variable)), "nothing");
    EXPECT_EQ((refusal<int, std::int64_t>(integer, Reach::variable)),
              "integer has the type Integer, not Enumeration");
    EXPECT_EQ((refusal<int, int>(enumeration, Reach::variable)),
              "enumeration has the type Enumeration, not Integer");
    EXPECT_EQ((refusal<double, double>(enumeration, Reach::scalar)),
              "enumeration has the type Enumeration, not Real");
}

TEST_F(AccessTest, AnyByteButZeroIsTrue) {
    for (const unsigned char byte : {1, 2, 128, 255}) {
        std::array<bool, 2> given{};
        std::memset(given.data(), byte, 1);
        instance.set<bool>(std::array{booleans}, Reach::variable, std::span<const bool>(given));
        std::array<bool, 2> stored{};
        instance.get<bool>(std::array{booleans}, Reach::variable, std::span<bool>(stored));
        EXPECT_EQ(std::memcmp(stored.data(), "\1\0", 2), 0) << int{byte};
        EXPECT_NO_THROW(instance.restore(instance.save(nullptr)));
    }
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

// What comes from outside may be anything, and have a right checksum nevertheless.
class ForgedStateTest : public InstanceTest {
  protected:
    // The payload of the instance's state as it is now.
    [[nodiscard]] std::string payload() {
        const auto bytes = instance.bytes(instance.save(nullptr));
        return std::string(fmi::unpack(stand_in().identity, use, bytes));
    }

    std::string reason_for_refusing(const std::string& forged) {
        try {
            instance.restore(instance.import_state(fmi::pack(stand_in().identity, use, forged)));
        } catch (const std::exception& refusal) {
            return refusal.what();
        }
        return "accepted";
    }

    static constexpr fmi::Use use{.fmi_version = 2, .kind = Kind::co_simulation};
};

TEST_F(ForgedStateTest, OfAnyOtherLengthIsRefused) {
    start();
    const std::string whole = payload();
    ASSERT_EQ(reason_for_refusing(whole), "accepted");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_NE(reason_for_refusing(whole.substr(0, length)).find("truncated or damaged"),
                  std::string::npos)
            << "length " << length;
    }
    EXPECT_EQ(reason_for_refusing(whole + '\0'), "the stored state is damaged: 1 bytes follow its end");
}

TEST_F(ForgedStateTest, OfAnImpossiblePhaseOrTimeIsRefused) {
    start();
    const std::string whole = payload();
    for (const char phase : {5, 6, 7, -1}) {  // of model exchange, and none
        std::string forged = whole;
        forged[0] = phase;
        EXPECT_EQ(reason_for_refusing(forged),
                  "the stored state is damaged: its phase or its times are impossible");
    }
    const double never = std::numeric_limits<double>::quiet_NaN();
    for (const std::size_t time : {0, 1, 2}) {  // start, stop and present
        std::string forged = whole;
        std::memcpy(forged.data() + 1 + time * sizeof never, &never, sizeof never);
        EXPECT_EQ(reason_for_refusing(forged),
                  "the stored state is damaged: its phase or its times are impossible");
    }
}

TEST_F(ForgedStateTest, OfParametersThatNoInitialisationAcceptsIsRefused) {
    start();
    State* const before = instance.save(nullptr);
    set(input, -1.0);
    std::string forged = payload();
    const double bad = -2.0;
    const std::size_t place = forged.size() - 3 * sizeof bad;  // tunable, input and output end it
    std::memcpy(forged.data() + place, &bad, sizeof bad);
    EXPECT_EQ(reason_for_refusing(forged), "tunable = -2: must be greater than 0");
    EXPECT_EQ(get(input), -1.0);
    instance.restore(before);
    EXPECT_EQ(get(input), 0.0);
}

// A length that a damaged state claims must not become memory.
TEST(StateReader, BelievesNoLengthBeyondItsBytes) {
    std::string bytes;
    fmi::StateWriter{bytes}(std::uint64_t{1} << 60, 'x');
    std::string text;
    EXPECT_THROW(fmi::StateReader{bytes}(text), Refusal);
    EXPECT_TRUE(text.empty());
}

TEST(StateReader, ABooleanIsTrueOrFalse) {
    std::string bytes("\1\0\2", 3);
    bool value = false;
    fmi::StateReader reader(bytes);
    reader(value);
    EXPECT_TRUE(value);
    reader(value);
    EXPECT_FALSE(value);
    EXPECT_THROW(reader(value), Refusal);
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
