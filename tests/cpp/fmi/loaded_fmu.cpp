#include "loaded_fmu.hpp"

#include <dlfcn.h>

#include <fstream>
#include <iostream>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace truenorth::test {
namespace {

std::string content_of(const std::string& path) {
    const std::ifstream file(path);
    std::ostringstream content;
    content << file.rdbuf();
    return content.str();
}

std::string first_match(const std::string& text, const std::string& pattern) {
    std::smatch match;
    if (!std::regex_search(text, match, std::regex(pattern))) {
        throw std::runtime_error("not found: " + pattern);
    }
    return match[1];
}

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

template <class Function>
Function* LoadedFmu::function(const char* name) const {
    void* symbol = dlsym(library_, name);
    if (symbol == nullptr) {
        throw std::runtime_error(std::string(name) + " is not exported");
    }
    return reinterpret_cast<Function*>(symbol);  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
}

LoadedFmu::LoadedFmu(const std::string& binary, const std::string& description)
    : description_(content_of(description)), library_(dlopen(binary.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (library_ == nullptr) {
        throw std::runtime_error(dlerror());
    }
    get_real_ = function<fmi2GetRealTYPE>("fmi2GetReal");
    set_real_ = function<fmi2SetRealTYPE>("fmi2SetReal");
    get_integer_ = function<fmi2GetIntegerTYPE>("fmi2GetInteger");
    set_integer_ = function<fmi2SetIntegerTYPE>("fmi2SetInteger");
    get_boolean_ = function<fmi2GetBooleanTYPE>("fmi2GetBoolean");
    set_boolean_ = function<fmi2SetBooleanTYPE>("fmi2SetBoolean");
    do_step_ = function<fmi2DoStepTYPE>("fmi2DoStep");
    free_instance_ = function<fmi2FreeInstanceTYPE>("fmi2FreeInstance");
    callbacks_.logger = log;
    const std::string guid = first_match(description_, "guid=\"([^\"]*)\"");
    component_ = function<fmi2InstantiateTYPE>("fmi2Instantiate")("test", fmi2CoSimulation, guid.c_str(),
                                                                  nullptr, &callbacks_, fmi2False, fmi2False);
    if (component_ == nullptr) {
        throw std::runtime_error("fmi2Instantiate failed");
    }
}

LoadedFmu::~LoadedFmu() {
    free_instance_(component_);
    dlclose(library_);
}

void LoadedFmu::set(const std::string& name, double value) {
    const fmi2ValueReference vr = reference(name);
    require(set_real_(component_, &vr, 1, &value), "fmi2SetReal");
}

void LoadedFmu::set(const std::string& name, int value) {
    const fmi2ValueReference vr = reference(name);
    require(set_integer_(component_, &vr, 1, &value), "fmi2SetInteger");
}

void LoadedFmu::start() {
    require(function<fmi2SetupExperimentTYPE>("fmi2SetupExperiment")(component_, fmi2False, 0.0, 0.0,
                                                                     fmi2False, 0.0),
            "fmi2SetupExperiment");
    require(function<fmi2EnterInitializationModeTYPE>("fmi2EnterInitializationMode")(component_),
            "fmi2EnterInitializationMode");
    require(function<fmi2ExitInitializationModeTYPE>("fmi2ExitInitializationMode")(component_),
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
    require(function<fmi2GetFMUstateTYPE>("fmi2GetFMUstate")(component_, &state), "fmi2GetFMUstate");
    require(function<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate")(component_, &state), "fmi2FreeFMUstate");
}

fmi2ValueReference LoadedFmu::reference(const std::string& name) const {
    const std::string literal = std::regex_replace(name, std::regex(R"([\[\].])"), R"(\$&)");
    return static_cast<fmi2ValueReference>(
        std::stoul(first_match(description_, "name=\"" + literal + "\" valueReference=\"([0-9]+)\"")));
}

std::vector<std::string> LoadedFmu::names(const std::string& type, const std::string& causality) const {
    const std::regex variable("<ScalarVariable name=\"([^\"]*)\"[^>]*causality=\"" + causality +
                              "\"[^>]*>\\s*<" + type + "[ /]");
    std::vector<std::string> found;
    for (auto match = std::sregex_iterator(description_.begin(), description_.end(), variable);
         match != std::sregex_iterator(); ++match) {
        found.push_back((*match)[1]);
    }
    return found;
}

}  // namespace truenorth::test
