#include "loaded_fmu.hpp"

#include <iostream>
#include <regex>
#include <stdexcept>

namespace truenorth::test {
namespace {

void require(fmi2Status status, const char* what) {
    if (status != fmi2OK) {
        throw std::runtime_error(std::string(what) + " failed");
    }
}

// NOLINTNEXTLINE(modernize-avoid-variadic-functions): the standard says so
void log(fmi2ComponentEnvironment /*environment*/, fmi2String name, fmi2Status /*status*/,
         fmi2String category, fmi2String text, ...) {
    std::cerr << name << ' ' << category << ' ' << text << '\n';
}

}  // namespace

LoadedFmu::LoadedFmu(const std::string& binary, const std::string& description)
    : binary_(binary, description) {
    get_real_ = binary_.function<fmi2GetRealTYPE>("fmi2GetReal");
    set_real_ = binary_.function<fmi2SetRealTYPE>("fmi2SetReal");
    get_integer_ = binary_.function<fmi2GetIntegerTYPE>("fmi2GetInteger");
    set_integer_ = binary_.function<fmi2SetIntegerTYPE>("fmi2SetInteger");
    get_boolean_ = binary_.function<fmi2GetBooleanTYPE>("fmi2GetBoolean");
    set_boolean_ = binary_.function<fmi2SetBooleanTYPE>("fmi2SetBoolean");
    do_step_ = binary_.function<fmi2DoStepTYPE>("fmi2DoStep");
    free_instance_ = binary_.function<fmi2FreeInstanceTYPE>("fmi2FreeInstance");
    callbacks_.logger = log;
    component_ = binary_.function<fmi2InstantiateTYPE>("fmi2Instantiate")(
        "test", fmi2CoSimulation, binary_.token().c_str(), nullptr, &callbacks_, fmi2False, fmi2False);
    if (component_ == nullptr) {
        throw std::runtime_error("fmi2Instantiate failed");
    }
}

LoadedFmu::~LoadedFmu() { free_instance_(component_); }

void LoadedFmu::set(const std::string& name, double value) {
    const fmi2ValueReference vr = reference(name);
    require(set_real_(component_, &vr, 1, &value), "fmi2SetReal");
}

void LoadedFmu::set(const std::string& name, int value) {
    const fmi2ValueReference vr = reference(name);
    require(set_integer_(component_, &vr, 1, &value), "fmi2SetInteger");
}

void LoadedFmu::start() {
    require(binary_.function<fmi2SetupExperimentTYPE>("fmi2SetupExperiment")(component_, fmi2False, 0.0, 0.0,
                                                                             fmi2False, 0.0),
            "fmi2SetupExperiment");
    require(binary_.function<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode")(component_),
            "fmi2EnterInitializationMode");
    require(binary_.function<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(component_),
            "fmi2ExitInitializationMode");
}

void LoadedFmu::step(double time, double size) {
    require(do_step_(component_, time, size, fmi2True), "fmi2DoStep");
}

void LoadedFmu::read(Port<double>& port) {
    require(get_real_(component_, port.references.data(), port.references.size(), port.values.data()),
            "fmi2GetReal");
}

void LoadedFmu::read(Port<int>& port) {
    auto* get = port.boolean ? get_boolean_ : get_integer_;
    require(get(component_, port.references.data(), port.references.size(), port.values.data()),
            port.boolean ? "fmi2GetBoolean" : "fmi2GetInteger");
}

void LoadedFmu::write(const Port<double>& port) {
    require(set_real_(component_, port.references.data(), port.references.size(), port.values.data()),
            "fmi2SetReal");
}

void LoadedFmu::write(const Port<int>& port) {
    auto* set = port.boolean ? set_boolean_ : set_integer_;
    require(set(component_, port.references.data(), port.references.size(), port.values.data()),
            port.boolean ? "fmi2SetBoolean" : "fmi2SetInteger");
}

double LoadedFmu::get(const std::string& name) {
    const fmi2ValueReference vr = reference(name);
    double value = 0.0;
    require(get_real_(component_, &vr, 1, &value), "fmi2GetReal");
    return value;
}

void LoadedFmu::store_state() {
    fmi2FMUstate state = nullptr;
    require(binary_.function<fmi2GetFMUstateTYPE>("fmi2GetFMUstate")(component_, &state), "fmi2GetFMUstate");
    require(binary_.function<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate")(component_, &state),
            "fmi2FreeFMUstate");
}

fmi2ValueReference LoadedFmu::reference(const std::string& name) const {
    return binary_.references().at(name);
}

std::vector<std::string> LoadedFmu::names(const std::string& type, const std::string& causality) const {
    const auto lock = compiling();
    const std::regex variable("<ScalarVariable name=\"([^\"]*)\"[^>]*causality=\"" + causality +
                              "\"[^>]*>\\s*<" + type + "[ /]");
    const std::string& description = binary_.description();
    std::vector<std::string> found;
    for (auto match = std::sregex_iterator(description.begin(), description.end(), variable);
         match != std::sregex_iterator(); ++match) {
        found.push_back((*match)[1]);
    }
    return found;
}

}  // namespace truenorth::test
