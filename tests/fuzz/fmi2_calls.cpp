// Every function of FMI 2 in any order, with any arguments. Found is what a sanitizer finds, a call that
// hangs, and a refusal without a sentence.
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "chance.hpp"
#include "fmi/binary.hpp"
#include "fmi2FunctionTypes.h"
#include "session.hpp"

namespace {

using truenorth::fuzz::Chance;
using truenorth::test::Binary;

thread_local long sentences = 0;  // that the FMU has logged as errors

// NOLINTNEXTLINE(modernize-avoid-variadic-functions): the standard says so
void log(fmi2ComponentEnvironment /*environment*/, fmi2String name, fmi2Status status, fmi2String category,
         fmi2String format, ...) {
    if (name == nullptr || category == nullptr || format == nullptr || std::strcmp(format, "%s") != 0) {
        std::abort();
    }
    sentences += status == fmi2Error ? 1 : 0;
}

// A master in C may ask for a kind that there is not.
template <class Value>
using StatusOfAnyKind = fmi2Status(fmi2Component, unsigned kind, Value* value);
static_assert(sizeof(fmi2StatusKind) == sizeof(unsigned));

class Calls final : public truenorth::fuzz::Session {
  public:
    Calls(const Binary& binary, std::string resources, Chance chance)
        : Session(chance), binary_(binary), resources_(std::move(resources)) {
        callbacks_.logger = log;
        add_functions();
        begin();
    }
    Calls(const Calls&) = delete;
    Calls(Calls&&) = delete;
    Calls& operator=(const Calls&) = delete;
    Calls& operator=(Calls&&) = delete;
    ~Calls() override { binary_.function<fmi2FreeInstanceTYPE>("fmi2FreeInstance")(component_); }

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
        const fmi2Status status = binary_.function<Function>(name)(component_, arguments...);
        if (status != fmi2OK && status != fmi2Error) {
            watch_.fail(std::string(name) + " returned status " + std::to_string(status));
        }
        return status == fmi2OK;
    }

    void begin() {
        binary_.function<fmi2FreeInstanceTYPE>("fmi2FreeInstance")(component_);
        const auto type = chance_.one_in(3) ? fmi2ModelExchange : fmi2CoSimulation;
        component_ = binary_.function<fmi2InstantiateTYPE>("fmi2Instantiate")(
            "fuzzed", type, binary_.token().c_str(), resources_.c_str(), &callbacks_, fmi2False,
            chance_.one_in(2));
        if (component_ == nullptr) {
            watch_.fail("fmi2Instantiate was refused");
        }
        states_.fill(nullptr);
        muted_ = false;
    }

    unsigned any_kind() { return static_cast<unsigned>(chance_.below(5)); }

    void draw_references() {
        count_ = chance_.below(references_.size());
        for (auto& reference : references_) {
            reference = chance_.reference(binary_.references().size());
        }
        for (auto& value : reals_) {
            value = chance_.real();
        }
        for (auto& value : integers_) {
            value = chance_.integer();
        }
    }

    template <class Function, class Value>
    void add_access(const char* name, Value* values) {
        functions_.emplace_back(name, [this, name, values] {
            draw_references();
            return call<Function>(name, chance_.perhaps(references_.data()), count_, chance_.perhaps(values));
        });
    }

    void add_functions();

    const Binary& binary_;
    std::string resources_;
    fmi2CallbackFunctions callbacks_{};
    fmi2Component component_ = nullptr;
    bool muted_ = false;  // errors may have been switched off
    std::array<fmi2FMUstate, 4> states_{};
    std::vector<fmi2Byte> blob_;
    std::size_t count_ = 0;
    std::array<fmi2ValueReference, 8> references_{};
    std::array<double, 8> reals_{};
    std::array<int, 8> integers_{};
    std::array<fmi2String, 8> strings_{};
    std::vector<std::pair<std::string, std::function<bool()>>> functions_;
};

void Calls::add_functions() {
    const auto add = [this](const char* name, auto body) { functions_.emplace_back(name, body); };
    add_access<fmi2GetRealTYPE>("fmi2GetReal", reals_.data());
    add_access<fmi2SetRealTYPE>("fmi2SetReal", std::as_const(reals_).data());
    add_access<fmi2GetIntegerTYPE>("fmi2GetInteger", integers_.data());
    add_access<fmi2SetIntegerTYPE>("fmi2SetInteger", std::as_const(integers_).data());
    add_access<fmi2GetBooleanTYPE>("fmi2GetBoolean", integers_.data());
    add_access<fmi2SetBooleanTYPE>("fmi2SetBoolean", std::as_const(integers_).data());
    add_access<fmi2GetStringTYPE>("fmi2GetString", strings_.data());
    add_access<fmi2SetStringTYPE>("fmi2SetString", std::as_const(strings_).data());
    add("fmi2SetupExperiment", [this] {
        return call<fmi2SetupExperimentTYPE>("fmi2SetupExperiment", fmi2False, 0.0,
                                             chance_.one_in(3) ? chance_.real() : 0.0, chance_.one_in(4),
                                             chance_.real());
    });
    for (const char* const name : {"fmi2EnterInitializationMode", "fmi2ExitInitializationMode"}) {
        for (int weight = 0; weight < 4; ++weight) {
            add(name, [this, name] { return call<fmi2EnterInitializationModeTYPE>(name); });
        }
    }
    for (const char* const name : {"fmi2Terminate", "fmi2Reset", "fmi2CancelStep", "fmi2EnterEventMode",
                                   "fmi2EnterContinuousTimeMode"}) {
        add(name, [this, name] { return call<fmi2TerminateTYPE>(name); });
    }
    for (int weight = 0; weight < 6; ++weight) {
        add("fmi2DoStep", [this] {
            const double size = chance_.one_in(8) ? chance_.real() : 0.01;
            if (size > 2.0 && size <= 86400.0) {
                return true;  // a step that long is work, and no hang
            }
            double time = chance_.real();
            if (!chance_.one_in(20)) {
                call<fmi2GetRealStatusTYPE>("fmi2GetRealStatus", fmi2LastSuccessfulTime, &time);
            }
            return call<fmi2DoStepTYPE>("fmi2DoStep", time, size, chance_.one_in(2));
        });
    }
    add("fmi2SetDebugLogging", [this] {
        static constexpr std::array<fmi2String, 4> categories{"logAll", "logStatusError", "none", nullptr};
        muted_ = true;
        return call<fmi2SetDebugLoggingTYPE>("fmi2SetDebugLogging", chance_.one_in(2), chance_.below(5),
                                             chance_.perhaps(categories.data()));
    });
    add("fmi2GetFMUstate", [this] {
        return call<fmi2GetFMUstateTYPE>("fmi2GetFMUstate",
                                         chance_.perhaps(&states_[chance_.below(states_.size())]));
    });
    add("fmi2SetFMUstate", [this] {
        return call<fmi2SetFMUstateTYPE>("fmi2SetFMUstate", states_[chance_.below(states_.size())]);
    });
    add("fmi2FreeFMUstate", [this] {
        return call<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate",
                                          chance_.perhaps(&states_[chance_.below(states_.size())]));
    });
    add("fmi2SerializeFMUstate", [this] {
        const fmi2FMUstate state = states_[chance_.below(states_.size())];
        std::size_t size = 0;
        if (!call<fmi2SerializedFMUstateSizeTYPE>("fmi2SerializedFMUstateSize", state,
                                                  chance_.perhaps(&size))) {
            return false;
        }
        blob_.resize(chance_.one_in(10) ? size / 2 : size);
        return call<fmi2SerializeFMUstateTYPE>("fmi2SerializeFMUstate", state, chance_.perhaps(blob_.data()),
                                               blob_.size());
    });
    add("fmi2DeSerializeFMUstate", [this] {
        if (!blob_.empty() && chance_.one_in(4)) {
            blob_[chance_.below(blob_.size())] = static_cast<char>(chance_.integer());
        }
        return call<fmi2DeSerializeFMUstateTYPE>("fmi2DeSerializeFMUstate", chance_.perhaps(blob_.data()),
                                                 blob_.size(),
                                                 chance_.perhaps(&states_[chance_.below(states_.size())]));
    });
    add("fmi2SetTime", [this] { return call<fmi2SetTimeTYPE>("fmi2SetTime", chance_.real()); });
    add("fmi2NewDiscreteStates", [this] {
        fmi2EventInfo info{};
        return call<fmi2NewDiscreteStatesTYPE>("fmi2NewDiscreteStates", chance_.perhaps(&info));
    });
    add("fmi2CompletedIntegratorStep", [this] {
        return call<fmi2CompletedIntegratorStepTYPE>("fmi2CompletedIntegratorStep", fmi2True,
                                                     chance_.perhaps(&integers_[0]),
                                                     chance_.perhaps(&integers_[1]));
    });
    for (const char* const name : {"fmi2GetDerivatives", "fmi2GetEventIndicators", "fmi2GetContinuousStates",
                                   "fmi2GetNominalsOfContinuousStates"}) {
        add(name, [this, name] {
            return call<fmi2GetDerivativesTYPE>(name, chance_.perhaps(reals_.data()), chance_.below(3));
        });
    }
    add("fmi2SetContinuousStates", [this] {
        return call<fmi2SetContinuousStatesTYPE>(
            "fmi2SetContinuousStates", chance_.perhaps(std::as_const(reals_).data()), chance_.below(3));
    });
    add("fmi2GetRealStatus", [this] {
        return call<StatusOfAnyKind<fmi2Real>>("fmi2GetRealStatus", any_kind(),
                                               chance_.perhaps(reals_.data()));
    });
    for (const char* const name : {"fmi2GetIntegerStatus", "fmi2GetBooleanStatus"}) {
        add(name, [this, name] {
            return call<StatusOfAnyKind<fmi2Integer>>(name, any_kind(), chance_.perhaps(integers_.data()));
        });
    }
    add("fmi2GetStatus", [this] {
        fmi2Status status{};
        return call<StatusOfAnyKind<fmi2Status>>("fmi2GetStatus", any_kind(), chance_.perhaps(&status));
    });
    add("fmi2GetStringStatus", [this] {
        return call<StatusOfAnyKind<fmi2String>>("fmi2GetStringStatus", any_kind(),
                                                 chance_.perhaps(strings_.data()));
    });
    add("fmi2SetRealInputDerivatives", [this] {
        return call<fmi2SetRealInputDerivativesTYPE>("fmi2SetRealInputDerivatives", references_.data(), 1U,
                                                     integers_.data(), std::as_const(reals_).data());
    });
    add("fmi2GetRealOutputDerivatives", [this] {
        return call<fmi2GetRealOutputDerivativesTYPE>("fmi2GetRealOutputDerivatives", references_.data(), 1U,
                                                      integers_.data(), reals_.data());
    });
    add("fmi2GetDirectionalDerivative", [this] {
        return call<fmi2GetDirectionalDerivativeTYPE>("fmi2GetDirectionalDerivative", references_.data(), 1U,
                                                      references_.data(), 1U, std::as_const(reals_).data(),
                                                      reals_.data());
    });
}

}  // namespace

std::unique_ptr<truenorth::fuzz::Session> truenorth::fuzz::begin_session(const Binary& binary,
                                                                         const std::string& resources,
                                                                         Chance chance) {
    return std::make_unique<Calls>(binary, resources, chance);
}
