// Many instances of one binary, each in a thread of its own, do what each does alone.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <thread>
#include <vector>

#include "loaded_fmu.hpp"

namespace truenorth::test {
namespace {

constexpr std::size_t threads = 8;
constexpr int steps = 500;
constexpr double step_size = 0.01;

struct Subject {
    const char* name;
    const char* binary;
};

class Threads : public testing::TestWithParam<Subject> {
  protected:
    // All Real outputs after each step of a run that `number` tells from others, joined.
    static std::vector<double> run(const Subject& subject, std::size_t number) {
        LoadedFmu fmu(subject.binary,
                      std::string(GENERATED) + "/" + subject.name + "/fmi2/modelDescription.xml");
        const bool plant = std::string(subject.name) == "TruthPlant";
        if (plant) {
            fmu.set("seed", static_cast<int>(number));
        } else {
            fmu.set("initial.heading", 0.1 * static_cast<double>(number));
        }
        fmu.start();
        Port<double> outputs{fmu.names("Real", "output"), {}, {}};
        for (const std::string& name : outputs.names) {
            outputs.references.push_back(fmu.reference(name));
        }
        outputs.values.resize(outputs.names.size());
        std::vector<double> trace;
        for (int k = 0; k < steps; ++k) {
            if (!plant) {
                fmu.set("imu.sample", k + 1);
                fmu.set("imu.time", step_size * (k + 1));
                fmu.set("imu.delta_velocity[3]", 9.8 * step_size);
            }
            fmu.step(k * step_size, step_size);
            fmu.read(outputs);
            trace.insert(trace.end(), outputs.values.begin(), outputs.values.end());
        }
        fmu.store_state();
        return trace;
    }
};

TEST_P(Threads, RunAsEachAlone) {
    std::array<std::vector<double>, threads> together;
    std::vector<std::thread> running;
    for (std::size_t i = 0; i < threads; ++i) {
        running.emplace_back([&, i] { together.at(i) = run(GetParam(), i); });
    }
    for (std::thread& thread : running) {
        thread.join();
    }
    for (std::size_t i = 0; i < threads; ++i) {
        EXPECT_EQ(together.at(i), run(GetParam(), i)) << "instance " << i;
    }
    EXPECT_NE(together[0], together[1]);
}

INSTANTIATE_TEST_SUITE_P(Fmus, Threads,
                         testing::Values(Subject{"TruthPlant", PLANT}, Subject{"AlignmentFilter", ALIGNMENT}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace truenorth::test
