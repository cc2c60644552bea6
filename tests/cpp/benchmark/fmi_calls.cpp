// Time of the calls that a master makes most, on the binaries of the AlignmentFilter:
//
//     bench_fmi [FMI2_BINARY FMI3_BINARY DESCRIPTIONS]    others than those of this build, to compare
//
// Prints the median over batches, so that a noisy machine disturbs it little.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

#include "fmi/binary.hpp"
#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

namespace {

using truenorth::test::Binary;

constexpr int kCallsPerBatch = 1000;
constexpr int kBatches = 101;
constexpr std::size_t kCovariances = 144;

// NOLINTNEXTLINE(modernize-avoid-variadic-functions): the standard says so
void log(fmi2ComponentEnvironment /*environment*/, fmi2String /*name*/, fmi2Status /*status*/,
         fmi2String /*category*/, fmi2String /*format*/, ...) {}

// Nanoseconds of one call.
template <class Call>
double time_of(Call call) {
    std::array<double, kBatches> batches{};
    for (double& batch : batches) {
        const auto begin = std::chrono::steady_clock::now();
        for (int k = 0; k < kCallsPerBatch; ++k) {
            call();
        }
        const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
        batch = taken.count() / kCallsPerBatch;
    }
    std::ranges::nth_element(batches, batches.begin() + kBatches / 2);
    return batches[kBatches / 2];
}

void print(const char* what, double nanoseconds, std::size_t scalars) {
    std::printf("%-52s %9.0f ns %9.2f ns a scalar\n", what, nanoseconds,
                nanoseconds / static_cast<double>(scalars));
}

// References of covariance[1,1] to covariance[12,12], which follow one another.
std::vector<unsigned> covariances(unsigned first) {
    std::vector<unsigned> references(kCovariances);
    std::iota(references.begin(), references.end(), first);
    return references;
}

void time_fmi2(const Binary& fmu) {
    fmi2CallbackFunctions callbacks{};
    callbacks.logger = log;
    const auto c = fmu.function<fmi2InstantiateTYPE>("fmi2Instantiate")(
        "timed", fmi2CoSimulation, fmu.token().c_str(), nullptr, &callbacks, fmi2False, fmi2False);
    fmu.function<fmi2SetupExperimentTYPE>("fmi2SetupExperiment")(c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    fmu.function<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode")(c);
    fmu.function<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(c);

    auto* const get = fmu.function<fmi2GetRealTYPE>("fmi2GetReal");
    const auto references = covariances(fmu.references().at("covariance[1,1]"));
    std::vector<double> values(kCovariances);
    print("FMI 2: get 144 covariances in one call",
          time_of([&] { get(c, references.data(), kCovariances, values.data()); }), kCovariances);

    auto* const set = fmu.function<fmi2SetRealTYPE>("fmi2SetReal");
    const std::array<unsigned, 3> input{fmu.references().at("imu.delta_velocity[1]"),
                                        fmu.references().at("imu.delta_velocity[2]"),
                                        fmu.references().at("imu.delta_velocity[3]")};
    const std::array<double, 3> force{0.0, 0.0, 0.0};
    print("FMI 2: set three inputs in one call",
          time_of([&] { set(c, input.data(), input.size(), force.data()); }), input.size());

    auto* const step = fmu.function<fmi2DoStepTYPE>("fmi2DoStep");
    double time = 0.0;
    print("FMI 2: step without new data", time_of([&] {
              step(c, time, 0.01, fmi2True);
              time += 0.01;
          }),
          1);
    fmu.function<fmi2FreeInstanceTYPE>("fmi2FreeInstance")(c);
}

void time_fmi3(const Binary& fmu) {
    auto* const c = fmu.function<fmi3InstantiateCoSimulationTYPE>("fmi3InstantiateCoSimulation")(
        "timed", fmu.token().c_str(), nullptr, false, false, false, false, nullptr, 0, nullptr, nullptr,
        nullptr);
    fmu.function<fmi3EnterInitializationModeTYPE>("fmi3EnterInitializationMode")(c, false, 0.0, 0.0, false,
                                                                                 0.0);
    fmu.function<fmi3ExitInitializationModeTYPE>("fmi3ExitInitializationMode")(c);

    auto* const get = fmu.function<fmi3GetFloat64TYPE>("fmi3GetFloat64");
    const unsigned array = fmu.references().at("covariance");
    std::vector<double> values(kCovariances);
    print("FMI 3: get 144 covariances as one array",
          time_of([&] { get(c, &array, 1, values.data(), kCovariances); }), kCovariances);
    fmu.function<fmi3FreeInstanceTYPE>("fmi3FreeInstance")(c);
}

}  // namespace

int main(int argc, char** argv) {
    const bool others = argc == 4;
    const std::string descriptions = others ? argv[3] : std::string(GENERATED) + "/AlignmentFilter";
    time_fmi2(Binary(others ? argv[1] : FMI2, descriptions + "/fmi2/modelDescription.xml"));
    time_fmi3(Binary(others ? argv[2] : FMI3, descriptions + "/fmi3/modelDescription.xml"));
}
