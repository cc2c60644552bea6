// The loop with components made up for it: what is done, in which steps, in which order, and where it stops.
#include "runner/loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <new>
#include <numeric>
#include <vector>

namespace {

long allocated = 0;

}  // namespace

// Not inlined: GCC then takes malloc and delete for a pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocated;
    if (void* const memory = std::malloc(size)) {
        return memory;
    }
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }

namespace truenorth::runner {
namespace {

// A component that keeps the time to which it has stepped, and counts the fixes that it makes.
struct Component {
    double time = 0.0;
    std::int32_t fixes = 0;
    int steps_per_fix = 3;
    int steps = 0;
    std::vector<std::int32_t> heard;
    double refuses_at = 1e9;
};

int step_component(void* component, double time, double step, int no_set_before) {
    auto& self = *static_cast<Component*>(component);
    EXPECT_EQ(no_set_before, 1);
    EXPECT_EQ(time, self.time);
    if (time >= self.refuses_at) {
        return 3;
    }
    self.time += step;
    self.fixes += ++self.steps % self.steps_per_fix == 0 ? 1 : 0;
    return 1;  // a warning
}

int get_reals(void* component, const std::uint32_t* references, std::size_t count, void* values) {
    for (std::size_t i = 0; i < count; ++i) {
        static_cast<double*>(values)[i] = static_cast<Component*>(component)->time + references[i];
    }
    return 0;
}

int get_integers(void* component, const std::uint32_t* /*references*/, std::size_t /*count*/, void* values) {
    *static_cast<std::int32_t*>(values) = static_cast<Component*>(component)->fixes;
    return 0;
}

int set_time(void* component, const std::uint32_t* /*references*/, std::size_t /*count*/, void* values) {
    static_cast<Component*>(component)->time = *static_cast<double*>(values);
    return 0;
}

int hear(void* component, const std::uint32_t* /*references*/, std::size_t count, void* values) {
    EXPECT_EQ(count, 1U);
    static_cast<Component*>(component)->heard.push_back(*static_cast<std::int32_t*>(values));
    return 0;
}

template <class Value>
std::byte* bytes(Value* values) {
    return reinterpret_cast<std::byte*>(values);
}

struct RunnerLoop : ::testing::Test {
    static constexpr std::size_t kSteps = 20;

    Component component;
    std::array<std::uint32_t, 3> places{0, 100, 200};
    std::array<double, 3> signals{};
    std::int32_t counter = 0;
    std::vector<double> times;
    std::vector<Operation> operations;

    RunnerLoop() : times(kSteps + 1) { std::iota(times.begin(), times.end(), 0.0); }

    Operation& add(Kind kind, When when = When::always) {
        Operation& operation = operations.emplace_back();
        operation.kind = kind;
        operation.when = when;
        operation.component = &component;
        operation.references = places.data();
        return operation;
    }
    void add_step() { add(Kind::step).step = step_component; }
    Operation& add_access(Access* access, std::size_t count, std::byte* values, When when = When::always) {
        Operation& operation = add(Kind::access, when);
        operation.access = access;
        operation.count = count;
        operation.values = values;
        return operation;
    }
    void add_look() {
        add_access(get_integers, 1, bytes(&counter));
        add(Kind::look).signals = bytes(&counter);
    }
    [[nodiscard]] Loop loop(std::size_t steps_per_row) {
        return {operations.data(), operations.size(), times.data(), 0, steps_per_row, 0, counter};
    }
};

TEST_F(RunnerLoop, RecordsRowsAndFixesWhereTheyAreDue) {
    std::vector<double> rows(4 * 3);
    std::vector<double> at_fixes(kSteps, -1.0);
    add_step();
    add_look();
    add_access(get_reals, 3, bytes(rows.data()), When::at_row).values_stride = 3 * sizeof(double);
    add_access(get_reals, 1, bytes(at_fixes.data()), When::at_fix).values_stride = sizeof(double);
    Loop made = loop(5);
    EXPECT_EQ(run(made, kSteps), -1);
    EXPECT_EQ(rows, (std::vector<double>{5, 105, 205, 10, 110, 210, 15, 115, 215, 20, 120, 220}));
    EXPECT_EQ(made.done, kSteps);
    EXPECT_EQ(made.fixes, 6U);
    at_fixes.resize(7);
    EXPECT_EQ(at_fixes, (std::vector<double>{3, 6, 9, 12, 15, 18, -1}));
}

TEST_F(RunnerLoop, SeesAFixBehindTheLookAlone) {
    std::array<double, kSteps> before{};
    std::array<double, kSteps> behind{};
    add_access(get_reals, 1, bytes(before.data()), When::at_fix).values_stride = sizeof(double);
    add_look();
    add_access(get_reals, 1, bytes(behind.data()), When::at_fix).values_stride = sizeof(double);
    add_step();
    Loop made = loop(1);
    EXPECT_EQ(run(made, 8), -1);
    EXPECT_EQ(made.fixes, 2U);
    EXPECT_EQ(before[0], 0.0);
    EXPECT_EQ(behind[1], 6.0);
}

TEST_F(RunnerLoop, GoesOnWhereItCameBack) {
    std::vector<double> whole(kSteps);
    for (const std::size_t returns : {1, 3, 7, 20}) {
        std::vector<double> rows(kSteps);
        component = {};
        operations.clear();
        add_step();
        add_access(get_reals, 1, bytes(rows.data())).values_stride = sizeof(double);
        Loop made = loop(4);
        for (std::size_t until = 0; until < kSteps;) {
            until = std::min(until + returns, kSteps);
            EXPECT_EQ(run(made, until), -1);
            EXPECT_EQ(made.done, until);
        }
        std::iota(whole.begin(), whole.end(), 1.0);
        EXPECT_EQ(rows, whole);
    }
}

TEST_F(RunnerLoop, SaysWhatWasRefusedAndInWhichStep) {
    component.refuses_at = 12.0;
    add_access(get_reals, 3, bytes(signals.data()));
    add_step();
    Loop made = loop(5);
    EXPECT_EQ(run(made, kSteps), 1);
    EXPECT_EQ(made.done, 12U);
    EXPECT_EQ(component.time, 12.0);
}

TEST_F(RunnerLoop, GathersWideAndNarrowSignals) {
    const std::array<double, 4> wide{1.5, 2.5, 3.5, 4.5};
    const std::array<std::int32_t, 4> narrow{1, 2, 3, 4};
    const std::array<std::uint32_t, 3> picked{3, 0, 2};
    std::array<double, 3> of_wide{};
    std::array<std::int32_t, 3> of_narrow{};
    Operation& first = add(Kind::gather);
    first.signals = reinterpret_cast<const std::byte*>(wide.data());
    first.size = sizeof(double);
    first.values = bytes(of_wide.data());
    Operation& second = add(Kind::gather);
    second.signals = reinterpret_cast<const std::byte*>(narrow.data());
    second.size = sizeof(std::int32_t);
    second.values = bytes(of_narrow.data());
    for (Operation& operation : operations) {
        operation.references = picked.data();
        operation.count = picked.size();
    }
    Loop made = loop(1);
    EXPECT_EQ(run(made, 2), -1);
    EXPECT_EQ(of_wide, (std::array{4.5, 1.5, 3.5}));
    EXPECT_EQ(of_narrow, (std::array<std::int32_t, 3>{4, 1, 3}));
}

TEST_F(RunnerLoop, WritesWhatHasChangedSinceItWasWrittenLast) {
    std::int32_t last = counter;  // the first is written all the same
    add_step();
    add_access(get_integers, 1, bytes(&counter));
    Operation& renewed = add(Kind::renew);
    renewed.access = hear;
    renewed.count = 1;
    renewed.size = sizeof counter;
    renewed.values = bytes(&counter);
    renewed.last = bytes(&last);
    Loop made = loop(1);
    EXPECT_EQ(run(made, 10), -1);
    EXPECT_EQ(component.heard, (std::vector<std::int32_t>{0, 1, 2, 3}));  // a fix in every third step
}

TEST_F(RunnerLoop, AddsARowForEachStep) {
    const std::array<double, 6> rows{1.0, 10.0, 2.0, 20.0, 3.0, 30.0};
    const std::array<std::uint32_t, 2> summed{2, 0};
    Operation& sum = add(Kind::add);
    sum.references = summed.data();
    sum.count = summed.size();
    sum.values = bytes(signals.data());
    sum.signals = reinterpret_cast<const std::byte*>(rows.data());
    sum.signals_stride = 2 * sizeof(double);
    Loop made = loop(1);
    EXPECT_EQ(run(made, 3), -1);
    EXPECT_EQ(signals, (std::array{60.0, 0.0, 6.0}));
}

TEST_F(RunnerLoop, TellsARowForEachStep) {
    std::array<double, 3> told{7.0, 8.0, 9.0};
    std::array<double, 3> heard{};
    add_access(set_time, 1, bytes(told.data())).values_stride = sizeof(double);
    add_access(get_reals, 1, bytes(heard.data())).values_stride = sizeof(double);
    Loop made = loop(1);
    EXPECT_EQ(run(made, 3), -1);
    EXPECT_EQ(heard, told);
}

TEST_F(RunnerLoop, AllocatesNothing) {
    std::vector<double> rows(kSteps);
    add_step();
    add_look();
    add_access(get_reals, 1, bytes(rows.data())).values_stride = sizeof(double);
    Loop made = loop(5);
    const long before = allocated;
    const std::ptrdiff_t refused = run(made, kSteps);
    EXPECT_EQ(allocated, before);
    EXPECT_EQ(refused, -1);
    EXPECT_GT(before, 0);
}

}  // namespace
}  // namespace truenorth::runner
