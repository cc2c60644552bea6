// Every function of FMI 3 in any order, with any arguments. Found is what a sanitizer finds, a call that
// hangs, and a refusal without a sentence.
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "chance.hpp"
#include "fmi/binary.hpp"
#include "fmi3FunctionTypes.h"
#include "session.hpp"

namespace {

using truenorth::fuzz::Chance;
using truenorth::test::Binary;

thread_local long sentences = 0;  // that the FMU has logged as errors

void log(fmi3InstanceEnvironment /*environment*/, fmi3Status status, fmi3String category, fmi3String text) {
    if (category == nullptr || text == nullptr) {
        std::abort();
    }
    sentences += status == fmi3Error ? 1 : 0;
}

class Calls final : public truenorth::fuzz::Session {
  public:
    Calls(const Binary& binary, std::string resources, Chance chance)
        : Session(chance), binary_(binary), resources_(std::move(resources)) {
        add_variables();
        add_life();
        add_states();
        add_events();
        add_absent();
        begin();
    }
    Calls(const Calls&) = delete;
    Calls(Calls&&) = delete;
    Calls& operator=(const Calls&) = delete;
    Calls& operator=(Calls&&) = delete;
    ~Calls() override { binary_.function<fmi3FreeInstanceTYPE>("fmi3FreeInstance")(instance_); }

    void go_on() override {
        if (chance_.one_in(500)) {
            begin();
        }
        auto& [name, function] = functions_[chance_.below(functions_.size())];
        const long before = sentences;
        const bool honoured = watch_.run(name, function);
        if (!honoured && sentences == before && !muted_) {
            watch_.fail(name + " was refused without a sentence");
        }
    }

  private:
    template <class Function, class... Arguments>
    bool call(const char* name, Arguments... arguments) {
        const fmi3Status status = binary_.function<Function>(name)(instance_, arguments...);
        if (status != fmi3OK && status != fmi3Error) {
            watch_.fail(std::string(name) + " returned status " + std::to_string(status));
        }
        return status == fmi3OK;
    }

    void begin() {
        binary_.function<fmi3FreeInstanceTYPE>("fmi3FreeInstance")(instance_);
        const char* const token = binary_.token().c_str();
        const bool logging = chance_.one_in(2);
        if (chance_.one_in(3)) {
            instance_ = binary_.function<fmi3InstantiateModelExchangeTYPE>("fmi3InstantiateModelExchange")(
                "fuzzed", token, resources_.c_str(), false, logging, nullptr, log);
        } else {
            instance_ = binary_.function<fmi3InstantiateCoSimulationTYPE>("fmi3InstantiateCoSimulation")(
                "fuzzed", token, resources_.c_str(), false, logging, false, false, nullptr, 0, nullptr, log,
                nullptr);
        }
        if (instance_ == nullptr) {
            watch_.fail("the instance was refused");
        }
        states_.fill(nullptr);
        time_ = 0.0;
        muted_ = !logging;
    }

    template <class Body>
    void add(const char* name, Body body) {
        functions_.emplace_back(name, body);
    }

    template <class Function, class Value>
    void add_access(const char* name, Value* values) {
        add(name, [this, name, values] {
            const std::size_t count = chance_.below(references_.size());
            for (auto& reference : references_) {
                reference = chance_.reference(binary_.references().size());
            }
            for (std::size_t i = 0; i < reals_.size(); ++i) {
                reals_[i] = chance_.real();
                integers_[i] = chance_.integer();
                long_integers_[i] = chance_.one_in(9) ? std::int64_t{1} << 40U : chance_.integer();
                booleans_[i] = chance_.one_in(2);
            }
            return call<Function>(name, chance_.perhaps(references_.data()), count, chance_.perhaps(values),
                                  chance_.one_in(3) ? chance_.below(values_ + 1) : count);
        });
    }

    void add_variables();
    void add_life();
    void add_states();
    void add_events();
    void add_absent();

    static constexpr std::size_t values_ = 256;  // more than any array has elements

    const Binary& binary_;
    std::string resources_;
    fmi3Instance instance_ = nullptr;
    bool muted_ = false;  // errors may be switched off
    double time_ = 0.0;   // that the instance said it has reached
    std::array<fmi3FMUState, 4> states_{};
    std::vector<fmi3Byte> blob_;
    std::array<fmi3ValueReference, 8> references_{};
    std::array<double, values_> reals_{};
    std::array<fmi3Int32, values_> integers_{};
    std::array<fmi3Int64, values_> long_integers_{};
    std::array<bool, values_> booleans_{};
    std::array<fmi3String, 8> strings_{};
    std::vector<std::pair<std::string, std::function<bool()>>> functions_;
};

void Calls::add_variables() {
    add_access<fmi3GetFloat64TYPE>("fmi3GetFloat64", reals_.data());
    add_access<fmi3SetFloat64TYPE>("fmi3SetFloat64", std::as_const(reals_).data());
    add_access<fmi3GetInt32TYPE>("fmi3GetInt32", integers_.data());
    add_access<fmi3SetInt32TYPE>("fmi3SetInt32", std::as_const(integers_).data());
    add_access<fmi3GetInt64TYPE>("fmi3GetInt64", long_integers_.data());
    add_access<fmi3SetInt64TYPE>("fmi3SetInt64", std::as_const(long_integers_).data());
    add_access<fmi3GetBooleanTYPE>("fmi3GetBoolean", booleans_.data());
    add_access<fmi3SetBooleanTYPE>("fmi3SetBoolean", std::as_const(booleans_).data());
    add_access<fmi3GetStringTYPE>("fmi3GetString", strings_.data());
    add_access<fmi3SetStringTYPE>("fmi3SetString", std::as_const(strings_).data());
}

void Calls::add_life() {
    for (int weight = 0; weight < 4; ++weight) {
        add("fmi3EnterInitializationMode", [this] {
            const double start = chance_.one_in(3) ? chance_.real() : 0.0;
            const bool honoured = call<fmi3EnterInitializationModeTYPE>(
                "fmi3EnterInitializationMode", false, 0.0, start, chance_.one_in(4), chance_.real());
            time_ = honoured ? start : time_;
            return honoured;
        });
        add("fmi3ExitInitializationMode",
            [this] { return call<fmi3ExitInitializationModeTYPE>("fmi3ExitInitializationMode"); });
    }
    for (const char* const name :
         {"fmi3Terminate", "fmi3Reset", "fmi3EnterStepMode", "fmi3EnterConfigurationMode",
          "fmi3ExitConfigurationMode", "fmi3EvaluateDiscreteStates"}) {
        add(name, [this, name] { return call<fmi3TerminateTYPE>(name); });
    }
    for (int weight = 0; weight < 6; ++weight) {
        add("fmi3DoStep", [this] {
            const double size = chance_.one_in(8) ? chance_.real() : 0.01;
            if (size > 2.0 && size <= 86400.0) {
                return true;  // a step that long is work, and no hang
            }
            bool event = false;
            bool terminate = false;
            bool early = false;
            return call<fmi3DoStepTYPE>("fmi3DoStep", chance_.one_in(20) ? chance_.real() : time_, size,
                                        chance_.one_in(2), chance_.perhaps(&event),
                                        chance_.perhaps(&terminate), chance_.perhaps(&early), &time_);
        });
    }
    add("fmi3SetDebugLogging", [this] {
        static constexpr std::array<fmi3String, 4> categories{"logAll", "logStatusError", "none", nullptr};
        muted_ = true;
        return call<fmi3SetDebugLoggingTYPE>("fmi3SetDebugLogging", chance_.one_in(2), chance_.below(5),
                                             chance_.perhaps(categories.data()));
    });
}

void Calls::add_states() {
    const auto any = [this]() -> fmi3FMUState& { return states_[chance_.below(states_.size())]; };
    add("fmi3GetFMUState",
        [this, any] { return call<fmi3GetFMUStateTYPE>("fmi3GetFMUState", chance_.perhaps(&any())); });
    add("fmi3SetFMUState", [this, any] { return call<fmi3SetFMUStateTYPE>("fmi3SetFMUState", any()); });
    add("fmi3FreeFMUState",
        [this, any] { return call<fmi3FreeFMUStateTYPE>("fmi3FreeFMUState", chance_.perhaps(&any())); });
    add("fmi3SerializeFMUState", [this, any] {
        const fmi3FMUState state = any();
        std::size_t size = 0;
        if (!call<fmi3SerializedFMUStateSizeTYPE>("fmi3SerializedFMUStateSize", state,
                                                  chance_.perhaps(&size))) {
            return false;
        }
        blob_.resize(chance_.one_in(10) ? size / 2 : size);
        return call<fmi3SerializeFMUStateTYPE>("fmi3SerializeFMUState", state, chance_.perhaps(blob_.data()),
                                               blob_.size());
    });
    add("fmi3DeserializeFMUState", [this, any] {
        if (!blob_.empty() && chance_.one_in(4)) {
            blob_[chance_.below(blob_.size())] = static_cast<fmi3Byte>(chance_.integer());
        }
        return call<fmi3DeserializeFMUStateTYPE>("fmi3DeserializeFMUState", chance_.perhaps(blob_.data()),
                                                 blob_.size(), chance_.perhaps(&any()));
    });
}

void Calls::add_events() {
    for (const char* const name : {"fmi3EnterEventMode", "fmi3EnterContinuousTimeMode"}) {
        add(name, [this, name] { return call<fmi3EnterEventModeTYPE>(name); });
    }
    add("fmi3SetTime", [this] { return call<fmi3SetTimeTYPE>("fmi3SetTime", chance_.real()); });
    add("fmi3UpdateDiscreteStates", [this] {
        std::array<bool, 5> flags{};
        return call<fmi3UpdateDiscreteStatesTYPE>("fmi3UpdateDiscreteStates", chance_.perhaps(&flags[0]),
                                                  chance_.perhaps(&flags[1]), chance_.perhaps(&flags[2]),
                                                  chance_.perhaps(&flags[3]), chance_.perhaps(&flags[4]),
                                                  chance_.perhaps(reals_.data()));
    });
    add("fmi3CompletedIntegratorStep", [this] {
        return call<fmi3CompletedIntegratorStepTYPE>("fmi3CompletedIntegratorStep", true,
                                                     chance_.perhaps(&booleans_[0]),
                                                     chance_.perhaps(&booleans_[1]));
    });
    for (const char* const name : {"fmi3GetContinuousStateDerivatives", "fmi3GetEventIndicators",
                                   "fmi3GetContinuousStates", "fmi3GetNominalsOfContinuousStates"}) {
        add(name, [this, name] {
            return call<fmi3GetContinuousStatesTYPE>(name, chance_.perhaps(reals_.data()), chance_.below(3));
        });
    }
    add("fmi3SetContinuousStates", [this] {
        return call<fmi3SetContinuousStatesTYPE>(
            "fmi3SetContinuousStates", chance_.perhaps(std::as_const(reals_).data()), chance_.below(3));
    });
    for (const char* const name : {"fmi3GetNumberOfEventIndicators", "fmi3GetNumberOfContinuousStates"}) {
        add(name, [this, name] {
            std::size_t count = 0;
            return call<fmi3GetNumberOfContinuousStatesTYPE>(name, chance_.perhaps(&count));
        });
    }
}

void Calls::add_absent() {
    add("fmi3GetNumberOfVariableDependencies", [this] {
        std::size_t count = 0;
        return call<fmi3GetNumberOfVariableDependenciesTYPE>("fmi3GetNumberOfVariableDependencies", 0U,
                                                             &count);
    });
    add("fmi3GetOutputDerivatives", [this] {
        return call<fmi3GetOutputDerivativesTYPE>("fmi3GetOutputDerivatives", references_.data(), 1U,
                                                  integers_.data(), reals_.data(), 1U);
    });
    add("fmi3GetDirectionalDerivative", [this] {
        return call<fmi3GetDirectionalDerivativeTYPE>("fmi3GetDirectionalDerivative", references_.data(), 1U,
                                                      references_.data(), 1U, reals_.data(), 1U,
                                                      reals_.data(), 1U);
    });
    add("fmi3GetAdjointDerivative", [this] {
        return call<fmi3GetAdjointDerivativeTYPE>("fmi3GetAdjointDerivative", references_.data(), 1U,
                                                  references_.data(), 1U, reals_.data(), 1U, reals_.data(),
                                                  1U);
    });
    add("fmi3GetClock", [this] {
        return call<fmi3GetClockTYPE>("fmi3GetClock", references_.data(), chance_.below(2), booleans_.data());
    });
    add("fmi3SetClock", [this] {
        return call<fmi3SetClockTYPE>("fmi3SetClock", references_.data(), chance_.below(2),
                                      std::as_const(booleans_).data());
    });
    add("fmi3GetIntervalDecimal", [this] {
        fmi3IntervalQualifier qualifier{};
        return call<fmi3GetIntervalDecimalTYPE>("fmi3GetIntervalDecimal", references_.data(), 1U,
                                                reals_.data(), &qualifier);
    });
    add("fmi3ActivateModelPartition", [this] {
        return call<fmi3ActivateModelPartitionTYPE>("fmi3ActivateModelPartition", 0U, chance_.real());
    });
}

}  // namespace

std::unique_ptr<truenorth::fuzz::Session> truenorth::fuzz::begin_session(const Binary& binary,
                                                                         const std::string& resources,
                                                                         Chance chance) {
    return std::make_unique<Calls>(binary, resources, chance);
}
