// After initialisation no FMU allocates: not in fmi2DoStep, not in fmi2GetXxx, not in fmi2SetXxx.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "allocation_count.hpp"
#include "loaded_fmu.hpp"

namespace truenorth::test {
namespace {

constexpr double step_size = 0.01;
constexpr int steps = 6000;

std::string description_of(const std::string& name) {
    return std::string(GENERATED) + "/" + name + "/fmi2/modelDescription.xml";
}

template <class Value>
Port<Value> port(const LoadedFmu& fmu, const std::vector<std::string>& names) {
    Port<Value> port{names, {}, std::vector<Value>(names.size())};
    for (const std::string& name : names) {
        port.references.push_back(fmu.reference(name));
    }
    return port;
}

// Inputs that another FMU has as outputs; the start of a filter is no signal.
std::vector<std::string> signals(const LoadedFmu& filter, const std::string& type) {
    std::vector<std::string> names = filter.names(type, "input");
    std::erase_if(names, [](const std::string& name) { return name.starts_with("initial."); });
    return names;
}

// Sources and sinks of the same signals.
template <class Value>
struct Connection {
    Port<Value> from;
    Port<Value> to;

    Connection(const LoadedFmu& plant, const LoadedFmu& filter, const std::string& type)
        : from(port<Value>(plant, signals(filter, type))), to(port<Value>(filter, from.names)) {
        from.boolean = to.boolean = type == "Boolean";
    }

    void carry(LoadedFmu& plant, LoadedFmu& filter) {
        plant.read(from);
        to.values = from.values;  // of equal size: nothing is allocated
        filter.write(to);
    }
};

struct Binary {
    const char* name;
    const char* file;
};
constexpr Binary alignment{"AlignmentFilter", ALIGNMENT};
constexpr Binary navigation{"NavigationFilter", NAVIGATION};

struct Setting {
    const char* name;
    Binary filter;
    int error_model;
    int predictor;
    int corrector;
    int scaling = 2;
};

class Allocation : public testing::TestWithParam<Setting> {
  protected:
    LoadedFmu plant{PLANT, description_of("TruthPlant")};
    LoadedFmu filter{GetParam().filter.file, description_of(GetParam().filter.name)};
};

TEST_P(Allocation, NoneInSteps) {
    filter.set("error_model", GetParam().error_model);
    filter.set("predictor", GetParam().predictor);
    filter.set("corrector", GetParam().corrector);
    filter.set("robust.scaling", GetParam().scaling);
    for (const char* aid : {"body_velocity", "heading_aid", "height_aid"}) {
        plant.set(std::string(aid) + ".rate", 1.0);
    }
    filter.set("body_velocity.scale_sigma", 0.01);
    filter.set("standstill.velocity_sigma", 0.1);
    plant.start();
    for (const char* angle : {"roll", "pitch", "heading", "latitude", "longitude"}) {
        const double truth = plant.get(std::string("truth.") + angle);
        filter.set(std::string("initial.") + angle, std::remainder(truth, 2.0 * std::acos(-1.0)));
    }
    filter.set("initial.velocity[2]", plant.get("truth.velocity[2]"));
    filter.start();

    Connection<double> reals(plant, filter, "Real");
    Connection<int> integers(plant, filter, "Integer");
    Connection<int> booleans(plant, filter, "Boolean");
    Port<double> results = port<double>(filter, filter.names("Real", "output"));
    Port<int> counters = port<int>(filter, {"used_fixes", "rejected_samples"});
    ASSERT_GE(reals.from.names.size(), 10U);
    ASSERT_GE(results.names.size(), 30U);

    const long before = allocations();
    for (int i = 0; i < steps; ++i) {
        plant.step(i * step_size, step_size);
        reals.carry(plant, filter);
        integers.carry(plant, filter);
        booleans.carry(plant, filter);
        filter.step(i * step_size, step_size);
        filter.read(results);
        filter.read(counters);
    }
    const long after = allocations();
    EXPECT_EQ(after - before, 0);

    // The filter was at work.
    EXPECT_GE(counters.values[0], 45);
    EXPECT_EQ(counters.values[1], 0);
}

INSTANTIATE_TEST_SUITE_P(
    Filters, Allocation,
    testing::Values(
        Setting{"linearised", alignment, 1, 1, 1}, Setting{"unscented", alignment, 1, 2, 1},
        Setting{"linearised_robust", alignment, 1, 1, 2}, Setting{"unscented_robust", alignment, 1, 2, 2},
        Setting{"robust_printed", alignment, 1, 2, 2, 1}, Setting{"robust_ceiling", alignment, 1, 2, 2, 3},
        Setting{"invariant_coarse", alignment, 5, 1, 1}, Setting{"invariant_navigation", navigation, 4, 2, 1},
        Setting{"loose_linearised", navigation, 1, 1, 1}, Setting{"loose_igg", navigation, 1, 2, 3},
        Setting{"loose_adaptive", navigation, 1, 3, 4}, Setting{"full_state_linearised", navigation, 2, 1, 1},
        Setting{"full_state_bayes", navigation, 2, 2, 5},
        Setting{"full_state_augmented", navigation, 2, 3, 1},
        Setting{"tight_linearised", navigation, 3, 1, 2}, Setting{"tight_bayes", navigation, 3, 2, 5},
        Setting{"tight_augmented", navigation, 3, 3, 3}, Setting{"unscented_combined", alignment, 1, 2, 6},
        Setting{"loose_combined", navigation, 1, 2, 6}, Setting{"tight_combined", navigation, 3, 1, 6}),
    [](const auto& info) { return info.param.name; });

// Control: what an FMU allocates is counted, through new and through malloc.
TEST(AllocationCount, SeesWhatAnFmuAllocates) {
    LoadedFmu plant(PLANT, description_of("TruthPlant"));
    plant.start();
    const long before = allocations();
    plant.store_state();
    EXPECT_GT(allocations() - before, 0);
}

TEST(AllocationCount, StandsStillWhenNothingIsAllocated) {
    const long before = allocations();
    EXPECT_EQ(allocations() - before, 0);
}

}  // namespace
}  // namespace truenorth::test
