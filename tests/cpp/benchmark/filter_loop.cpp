// An AlignmentFilter of FMI 2 on a base that rolls, at 100 Hz, for instructions.py to count what its calls
// cost:
//
//     bench_loop BINARY DESCRIPTION STEPS STEPS_PER_FIX [REAL|INTEGER|BOOLEAN PARAMETER VALUE]...
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmi/binary.hpp"
#include "fmi2FunctionTypes.h"

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kStep = 0.01;  // s
constexpr double kLatitude = 32.0 * kDegree;
constexpr double kLongitude = 118.0 * kDegree;
constexpr double kHeight = 30.0;  // m
constexpr double kHeading = 40.0 * kDegree;
constexpr double kRoll = 3.0 * kDegree;  // amplitude, one radian a second
constexpr double kGravity = 9.795;       // m/s2
constexpr double kEarth = 7.292115e-5;   // rad/s
constexpr double kVelocitySigma = 0.1;   // m/s, of a fix

// NOLINTNEXTLINE(modernize-avoid-variadic-functions): the standard says so
void log(fmi2ComponentEnvironment /*environment*/, fmi2String /*name*/, fmi2Status /*status*/,
         fmi2String /*category*/, fmi2String /*format*/, ...) {}

class Filter {
  public:
    Filter(const std::string& binary, const std::string& description)
        : fmu_(binary, description),
          set_real_(fmu_.function<fmi2SetRealTYPE>("fmi2SetReal")),
          set_integer_(fmu_.function<fmi2SetIntegerTYPE>("fmi2SetInteger")),
          step_(fmu_.function<fmi2DoStepTYPE>("fmi2DoStep")) {
        callbacks_.logger = log;
        component_ = fmu_.function<fmi2InstantiateTYPE>("fmi2Instantiate")(
            "counted", fmi2CoSimulation, fmu_.token().c_str(), nullptr, &callbacks_, fmi2False, fmi2False);
    }

    void set(const std::string& type, const std::string& name, double value) {
        const unsigned reference = fmu_.references().at(name);
        const auto number = static_cast<fmi2Integer>(value);
        check(type == "REAL" ? set_real_(component_, &reference, 1, &value)
              : type == "INTEGER"
                  ? set_integer_(component_, &reference, 1, &number)
                  : fmu_.function<fmi2SetBooleanTYPE>("fmi2SetBoolean")(component_, &reference, 1, &number));
    }

    void start() {
        check(fmu_.function<fmi2SetupExperimentTYPE>("fmi2SetupExperiment")(component_, fmi2False, 0.0, 0.0,
                                                                            fmi2False, 0.0));
        check(fmu_.function<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode")(component_));
        check(fmu_.function<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(component_));
    }

    [[nodiscard]] std::vector<unsigned> references(const std::vector<std::string>& names) const {
        std::vector<unsigned> found;
        for (const std::string& name : names) {
            found.push_back(fmu_.references().at(name));
        }
        return found;
    }

    // A new sample: its values and its count.
    template <std::size_t N>
    void give(const std::vector<unsigned>& references, const std::array<double, N>& values, unsigned counter,
              int count) {
        check(set_real_(component_, references.data(), N, values.data()));
        check(set_integer_(component_, &counter, 1, &count));
    }

    void step(double time) { check(step_(component_, time, kStep, fmi2True)); }

    [[nodiscard]] int used_fixes() const {
        const unsigned reference = fmu_.references().at("used_fixes");
        int value = 0;
        check(fmu_.function<fmi2GetIntegerTYPE>("fmi2GetInteger")(component_, &reference, 1, &value));
        return value;
    }

  private:
    static void check(fmi2Status status) {
        if (status != fmi2OK) {
            throw std::runtime_error("a call was refused");
        }
    }

    truenorth::test::Binary fmu_;
    fmi2SetRealTYPE* set_real_;
    fmi2SetIntegerTYPE* set_integer_;
    fmi2DoStepTYPE* step_;
    fmi2CallbackFunctions callbacks_{};
    fmi2Component component_ = nullptr;
};

// Increments of the rate of the Earth and of a roll, and of the force of gravity, right, forward, up.
std::array<double, 7> increments(int k) {
    const double before = kRoll * std::sin((k - 1) * kStep);
    const double now = kRoll * std::sin(k * kStep);
    const double mean = (before + now) / 2.0;
    const double north = kEarth * std::cos(kLatitude);
    return {-north * std::sin(kHeading) * kStep,
            north * std::cos(kHeading) * kStep + now - before,
            kEarth * std::sin(kLatitude) * kStep,
            -kGravity * std::sin(mean) * kStep,
            0.0,
            kGravity * std::cos(mean) * kStep,
            k * kStep};
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const int steps = std::stoi(arguments.at(2));
    const int steps_per_fix = std::stoi(arguments.at(3));
    Filter filter(arguments[0], arguments[1]);
    filter.set("REAL", "initial.latitude", kLatitude);
    filter.set("REAL", "initial.longitude", kLongitude);
    filter.set("REAL", "initial.height", kHeight);
    filter.set("REAL", "initial.heading", kHeading + 5.0 * kDegree);
    for (std::size_t k = 4; k < arguments.size(); k += 3) {
        filter.set(arguments[k], arguments.at(k + 1), std::stod(arguments.at(k + 2)));
    }
    filter.start();
    const auto imu = filter.references({"imu.delta_angle[1]", "imu.delta_angle[2]", "imu.delta_angle[3]",
                                        "imu.delta_velocity[1]", "imu.delta_velocity[2]",
                                        "imu.delta_velocity[3]", "imu.time"});
    const auto gnss = filter.references({"gnss.velocity[1]", "gnss.velocity[2]", "gnss.velocity[3]",
                                         "gnss.latitude", "gnss.longitude", "gnss.height", "gnss.time"});
    const auto counters = filter.references({"imu.sample", "gnss.sample"});
    std::mt19937 generator(1);
    std::normal_distribution<double> noise(0.0, kVelocitySigma);
    for (int k = 1; k <= steps; ++k) {
        filter.give(imu, increments(k), counters[0], k);
        if (k % steps_per_fix == 0) {
            const std::array fix{noise(generator), noise(generator), noise(generator), kLatitude,
                                 kLongitude,       kHeight,          k * kStep};
            filter.give(gnss, fix, counters[1], k / steps_per_fix);
        }
        filter.step((k - 1) * kStep);
    }
    std::printf("%d of %d fixes used\n", filter.used_fixes(), steps / steps_per_fix);
    return 0;
}
